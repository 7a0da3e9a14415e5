//! What a track says, as a page for people.

use super::{EffectiveNoise, Plan, TrackSummary};
use crate::phases::Phase;
use crate::rest_noise::RestNoise;
use crate::text::{aligned, instrument, listed};
use dpn_core::estimate::{Doubt, Seen, two};
use dpn_core::{SampleRate, Sensor};
use dpn_pronet::range::LOUD;
use std::fmt::Write;

/// Share from which a median is one of what was extrapolated.
const MOST_OF: f64 = 0.5;

/// A track that is further than this factor from the spectrum at rest says another noise.
const APART: f64 = 1.3;
/// The same of what errs as much in motion, where rotors shake more than any spectrum tells: on EuRoC's flights the two are 2.4 apart.
const SHAKEN: f64 = 3.0;

/// The warnings that go before everything else: estimates of what no network has seen.
pub fn warnings(plan: &Plan<'_>, summary: &TrackSummary) -> Vec<String> {
    let mut all = Vec::new();
    for part in &summary.phases {
        for outside in part.outside.iter().filter(|o| o.share > LOUD && Some(o.sensor) != summary.silent) {
            let (percent, sensor) = (100.0 * outside.share, outside.sensor);
            match part.phase {
                None => all.push(format!(
                    "OUT OF RANGE: {percent:.0} % of the {sensor} windows are unlike anything its network was trained on{}; its sigma there is \
                     extrapolated: take it for \"loud\" or \"quiet\", not for a number",
                    plan.noise.trained_on(sensor).map_or_else(String::new, |r| format!(
                        " (roughness {} to {} {})",
                        two(r.roughness[0]),
                        two(r.roughness[1]),
                        sensor.unit()
                    ))
                )),
                Some(phase) => all.push(format!("out of range while {phase}: {percent:.0} % of the {sensor} windows")),
            }
        }
    }
    all
}

fn loudest(axes: [f64; 3]) -> f64 {
    axes.into_iter().fold(0.0, f64::max)
}

/// Tracks that the spectrum in motion contradicts, accelerometer's and gyroscope's.
pub(super) fn in_motion(
    plan: &Plan<'_>,
    summary: &TrackSummary,
    effective: &EffectiveNoise,
    rate: SampleRate,
) -> Vec<String> {
    let Some(part) = [Phase::Moving, Phase::Motors].into_iter().find_map(|phase| summary.phase(phase)) else {
        return Vec::new();
    };
    let words = |(sensor, seen): (Sensor, &Seen)| {
        if Some(sensor) == summary.silent {
            return None;
        }
        let mut axes = part.of(sensor).map(|axis| axis.sigma.middle);
        let said = [axes.next()?, axes.next()?, axes.next()?];
        // What is extrapolated anyway is contradicted by a filter alone.
        if matches!(seen, Seen::Flat { .. })
            && part.outside.iter().any(|o| o.sensor == sensor && o.share > MOST_OF)
        {
            return None;
        }
        let who = plan.noise.spec().to_string();
        if let Some(doubt) = Doubt::of(sensor, said, seen, rate) {
            return Some(doubt.words(&who));
        }
        let (said, errs) =
            (loudest(said), loudest(effective.pasted_span(sensor).filter(|_| *seen == Seen::Untold)?));
        let apart = said > SHAKEN * errs || errs > SHAKEN * said;
        apart.then(|| {
            format!(
                "NOT KNOWN: in motion {who} says {} {} a sample of the {sensor}, and the spectrum {}: one of them is wrong; a trajectory (--against) or the odometry tells \
                 (dpn run --noise self)",
                two(said),
                sensor.unit(),
                two(errs)
            )
        })
    };
    Sensor::ALL.into_iter().zip(&effective.seen).filter_map(words).collect()
}

/// Tracks that say another noise at rest than the spectrum does, which sees more than a second at a time. Where the log moves later its rest may be not quite still, so that less
/// is no contradiction.
pub(super) fn at_rest(
    plan: &Plan<'_>,
    summary: &TrackSummary,
    rest: &RestNoise,
    rate: SampleRate,
) -> Vec<String> {
    let Some(part) = summary.phase(Phase::Rest) else { return Vec::new() };
    let moves = [Phase::Moving, Phase::Motors].into_iter().any(|phase| summary.phase(phase).is_some());
    let words = |sensor: Sensor| {
        if part.outside.iter().any(|o| o.sensor == sensor && o.share > MOST_OF) {
            return None;
        }
        let seen = rest.sensor(sensor).densities()?.map(|density| density.times(rate.hz().sqrt()));
        let axes = part.of(sensor).map(|axis| axis.sigma.middle).zip(seen).zip(["x", "y", "z"]);
        let ((said, seen), axis) = axes
            .filter(|((said, seen), _)| *said > seen.high * APART || !moves && *said < seen.low / APART)
            .max_by(|((a, of_a), _), ((b, of_b), _)| {
                (a / of_a.value).ln().abs().total_cmp(&(b / of_b.value).ln().abs())
            })?;
        Some(format!(
            "NOT KNOWN: at rest {} says {} {} a sample of the {sensor}'s {axis}, and its spectrum there {} ({} to {}): in motion it may be as far off; \
             the lines to paste are not its, and the odometry learns the noise in motion (dpn run --noise self)",
            plan.noise.spec(),
            two(said),
            sensor.unit(),
            two(seen.value),
            two(seen.low),
            two(seen.high)
        ))
    };
    summary.sensors().filter_map(words).collect()
}

/// The page: how the log went, and quantiles by phase, per sample and as densities.
pub fn page(plan: &Plan<'_>, summary: &TrackSummary, rate: SampleRate) -> String {
    let mut text =
        format!("noise by {}, every {} samples, of the samples past only\n", plan.noise.spec(), plan.every());
    if let Some([seen_hz, trained_hz]) = plan.noise.seen_and_trained_hz() {
        let what = match plan.noise.block() {
            1 => "every sample".to_owned(),
            block => format!("means of {block} samples"),
        };
        let _ = writeln!(
            text,
            "the networks saw {what} ({seen_hz:.0} Hz; trained at {trained_hz:.0} Hz); deviations are those of one sample"
        );
    }
    if summary.unknown_s > 0.0 {
        let _ = writeln!(
            text,
            "the first {:.1} s have no full window: constants stand there and do not count below",
            summary.unknown_s
        );
    }
    let _ = writeln!(
        text,
        "deviation of one sample, median (5 % to 95 %); at {:.0} Hz density = deviation * {:.5}",
        rate.hz(),
        1.0 / rate.hz().sqrt()
    );
    for sensor in summary.sensors() {
        let head = format!("{} [{}]", instrument(sensor), sensor.unit());
        let mut rows = vec![[&head, "time", "x", "y", "z", "out of range"].map(str::to_owned)];
        for part in &summary.phases {
            let label = part.phase.map_or_else(|| "whole log".to_owned(), |p| p.to_string());
            let none = || "-".to_owned();
            let mut axes = part
                .of(sensor)
                .map(|a| format!("{} ({} to {})", two(a.sigma.middle), two(a.sigma.low), two(a.sigma.high)));
            let [x, y, z] = std::array::from_fn(|_| axes.next().unwrap_or_else(none));
            let outside = part.outside.iter().find(|o| o.sensor == sensor);
            let outside = outside.map_or_else(none, |o| format!("{:.0} %", 100.0 * o.share));
            rows.push([format!("  {label}"), format!("{:.0} s", part.seconds), x, y, z, outside]);
        }
        text.push_str(&aligned(&rows));
    }
    if let (Some(rest), Some(moving)) = (summary.phase(Phase::Rest), summary.phase(Phase::Moving)) {
        for sensor in summary.sensors() {
            // What is extrapolated is no number, and neither is its ratio to one.
            let loud =
                |p: &super::PhaseSummary| p.outside.iter().any(|o| o.sensor == sensor && o.share > MOST_OF);
            if let Some(part) = [moving, rest].into_iter().find(|part| loud(part)) {
                let phase = part.phase.map_or_else(String::new, |phase| phase.to_string());
                let _ = writeln!(
                    text,
                    "{sensor}: how much noisier moving than at rest is not known: {phase} it is out of range"
                );
                continue;
            }
            let largest = |p: &super::PhaseSummary| p.of(sensor).map(|a| a.sigma.middle).fold(0.0, f64::max);
            let _ = writeln!(
                text,
                "{sensor}: {} times as noisy moving as at rest (medians of the loudest axis)",
                two(largest(moving) / largest(rest).max(f64::MIN_POSITIVE))
            );
        }
    }
    for line in outside(summary) {
        let _ = writeln!(text, "{line}");
    }
    text
}

/// Where a track is extrapolated, a line a sensor: for the page, and for the small print of a picture.
pub fn outside(summary: &TrackSummary) -> Vec<String> {
    let of = |sensor: Sensor| {
        let spans: Vec<String> = summary
            .outside
            .iter()
            .filter(|span| span.sensor == sensor)
            .map(|span| format!("{:.1}-{:.1}", span.from_s, span.to_s))
            .collect();
        (!spans.is_empty()).then(|| format!("{sensor} out of range: s {}", listed(&spans)))
    };
    Sensor::ALL.into_iter().filter_map(of).collect()
}
