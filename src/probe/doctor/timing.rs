//! Rate, jitter, dropped samples, samples that come twice.

use super::clock;
use crate::finding::Finding;
use dpn_core::Recorded;
use dpn_core::signal::ranks::{Column, Level, levels};
use std::io;

/// Jitter of a step, relative to the median one, from which an integrator notices.
const JITTER: f64 = 0.05;
/// A step longer than nearly all others by this factor is a hole, not the pause behind a burst.
const PAUSE: f64 = 5.0;
/// Share of samples equal to the one before from which the log is polled faster than the sensor.
const TWICE: f64 = 0.05;

pub(super) fn findings(recording: &dyn Recorded) -> io::Result<Vec<Finding>> {
    let period = recording.rate().period();
    let count = recording.len() - 1;
    let mut findings = Vec::new();
    let mean_hz = count as f64 / recording.length_s();
    findings.push(Finding::note(
        "rate",
        format!("{:.3} Hz by the median step, {mean_hz:.3} Hz by the mean one", recording.rate().hz()),
    ));
    findings.extend(clock::unlikely(recording.rate()));
    let each_step = |take: &mut dyn FnMut(f64)| recording.pairs(&mut |a, b| take(b.t.seconds_since(a.t)));
    let asked = [0.01, 0.99, 0.97].map(Level::Quantile);
    let found = levels(&[Column { count, levels: &asked }], |take| each_step(&mut |step| take(0, step)))?;
    let [low, high] = [found[0][0], found[0][1]].map(|step| step / period - 1.0);
    let text = || {
        format!(
            "1 % of the steps are shorter than {:.2} and 1 % longer than {:.2} periods",
            1.0 + low,
            1.0 + high
        )
    };
    if high > JITTER || low < -JITTER {
        findings.push(Finding::warning(
            "jitter",
            text(),
            "take the sensor's own clock for stamps, not the time of arrival; an integrator turns jitter into noise",
        ));
    }
    // A burst empties a queue: many steps near zero, then a long one; the median step says nothing then.
    // Holes are no pauses behind bursts: without them, one of a minute would make every other step a short one.
    let longest = PAUSE * found[0][2];
    let (mut sum, mut even) = (0.0, 0.0);
    each_step(&mut |step| {
        if step <= longest {
            (sum, even) = (sum + step, even + 1.0);
        }
    })?;
    // The second pass recovers the digits the first lost, as in `stats::mean`.
    let (rough, mut off) = (sum / even, 0.0);
    each_step(&mut |step| off += if step <= longest { step - rough } else { 0.0 })?;
    let usual = rough + off / even;
    let mut bursts = 0;
    each_step(&mut |step| bursts += usize::from(step <= longest && step < 0.2 * usual))?;
    if bursts as f64 > 0.05 * count as f64 {
        findings.push(Finding::bad(
            "jitter",
            format!("{bursts} steps are shorter than a fifth of the mean one: samples were stamped as a queue was emptied"),
            "stamp samples where they are taken",
        ));
        findings.extend(dropped(recording, longest, usual)?);
    } else {
        findings.extend(dropped(recording, 1.5 * period, period)?);
    }
    findings.extend(repeated(recording)?);
    Ok(findings)
}

/// Steps longer than `limit` \[s\].
fn dropped(recording: &dyn Recorded, limit: f64, period: f64) -> io::Result<Option<Finding>> {
    /// Places that are named.
    const NAMED: usize = 5;
    let start = recording.span()[0];
    let (mut holes, mut lost, mut places) = (0, 0.0, Vec::new());
    let (mut at, mut longest) = (0.0, 0.0);
    recording.pairs(&mut |a, b| {
        let step = b.t.seconds_since(a.t);
        if step > limit {
            let from = a.t.seconds_since(start);
            holes += 1;
            lost += (step / period).round() - 1.0;
            if places.len() < NAMED {
                places.push(format!("{from:.2}"));
            }
            if step >= longest {
                (at, longest) = (from, step);
            }
        }
    })?;
    if holes == 0 {
        return Ok(None);
    }
    let more = if holes > NAMED { ", ..." } else { "" };
    let text = format!(
        "{holes} hole(s), about {lost:.0} samples lost; at {}{more} s; the longest, {longest:.3} s, at {at:.2} s",
        places.join(", ")
    );
    let remedy = "look for a full buffer or a slow disk where the log was written; an estimator integrates across a hole with one sample";
    let is_bad = lost > 0.001 * recording.len() as f64 || longest > 0.1;
    Ok(Some(Finding::bad_where(is_bad, "gaps", text, remedy)))
}

fn repeated(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let mut twice = 0;
    recording.pairs(&mut |a, b| twice += usize::from(a.gyro == b.gyro && a.accel == b.accel))?;
    let share = twice as f64 / recording.len() as f64;
    Ok((share > TWICE).then(|| {
        Finding::warning(
            "repeats",
            format!("{:.0} % of the samples are the one before once more, all six axes", 100.0 * share),
            "the sensor is read faster than it measures, or it was frozen; log at its own rate, for noise per sample is wrong like this",
        )
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Weight;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, ImuSample, Stamp};

    fn of(samples: Vec<ImuSample>) -> Vec<Finding> {
        findings(&ImuRecording::new(samples).unwrap()).unwrap()
    }

    fn find<'a>(findings: &'a [Finding], about: &str) -> Option<&'a Finding> {
        findings.iter().find(|f| f.about == about)
    }

    #[test]
    fn a_clean_log_has_a_rate_and_nothing_else() {
        let found = of(level(30));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].text, "200.000 Hz by the median step, 200.000 Hz by the mean one");
    }

    #[test]
    fn holes_are_counted_with_their_places() {
        let mut samples = level(30);
        samples.drain(1000..1003);
        samples.drain(4000..4001);
        let found = of(samples);
        let gaps = find(&found, "gaps").unwrap();
        assert_eq!(gaps.weight, Weight::Warning);
        assert!(gaps.text.starts_with("2 hole(s), about 4 samples lost; at "), "{gaps:?}");
        assert!(gaps.text.contains(", 20.01 s; the longest, 0.020 s, at "), "{gaps:?}");
    }

    #[test]
    fn a_pause_of_a_minute_is_a_hole_and_no_jitter() {
        let mut samples = level(30);
        for s in &mut samples[3000..] {
            s.t = Stamp::from_ns(s.t.ns() + 60_000_000_000);
        }
        let found = of(samples.clone());
        assert!(find(&found, "jitter").is_none(), "{found:?}");
        let gaps = find(&found, "gaps").unwrap();
        assert!(gaps.weight == Weight::Bad && gaps.text.contains("the longest, 60.005 s, at "), "{gaps:?}");
        // Behind bursts too.
        for (i, s) in samples.iter_mut().enumerate() {
            let pause = if i < 3000 { 0 } else { 60_000_000_000 };
            s.t = Stamp::from_ns(pause + (i as i64 / 4) * 20_000_000 + (i as i64 % 4) * 100_000);
        }
        let found = of(samples);
        assert!(find(&found, "jitter").is_some());
        assert!(find(&found, "gaps").unwrap().text.starts_with("1 hole(s), "), "{found:?}");
    }

    #[test]
    fn jitter_bursts_and_repeats_are_told_apart() {
        let mut samples = level(30);
        for (i, s) in samples.iter_mut().enumerate() {
            s.t = Stamp::from_ns(s.t.ns() + if i % 7 == 0 { 1_000_000 } else { 0 });
        }
        let found = of(samples.clone());
        assert_eq!(find(&found, "jitter").map(|f| f.weight), Some(Weight::Warning));
        for (i, s) in samples.iter_mut().enumerate() {
            // Four at a time.
            s.t = Stamp::from_ns((i as i64 / 4) * 20_000_000 + (i as i64 % 4) * 100_000);
        }
        assert!(of(samples).iter().any(|f| f.weight == Weight::Bad && f.about == "jitter"));
        let mut polled = level(30);
        for i in (1..polled.len()).step_by(2) {
            (polled[i].gyro, polled[i].accel) = (polled[i - 1].gyro, polled[i - 1].accel);
        }
        let found = of(polled);
        assert!(find(&found, "repeats").unwrap().text.starts_with("50 % of the samples"), "{found:?}");
    }
}
