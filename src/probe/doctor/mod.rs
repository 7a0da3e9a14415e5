//! The health of somebody's log, before anybody trusts a figure made from it: findings by weight, each with a remedy.
//!
//! * [`timing`]: rate, jitter, dropped samples, the same sample twice.
//! * `clock`: clocks that were set, rates that no IMU has.
//! * [`values`]: gravity, units, swapped columns, clipped and dead axes, converter steps.
//! * `frozen`: sensors that stand still for a while.
//! * `mixed`: a gyroscope's unit, axes that are others, counters that run over, readings that jump by themselves.
//! * `turned`: gravity's direction against the gyroscope's turns; `bias`: a bias that these contradict.
//! * `attitudes`: gravity's length, however the sensor lies.
//! * `held`: a sensor slower than its rows, in motion.
//! * `copies`: rows that stand there once more.
//! * [`vibration`]: spectral peaks and what may be aliased.
//! * [`motion`]: rest and motion, drift of the bias at rest.
//! * [`reading`]: damage, stamps that stand still or go back, values that are no numbers, all of which the reader left out.
//! * `covariance`: what the messages say of their noise.
//! * [`table`]: many logs, a row each.
//! * [`examine_log`]: all of them; `examine` without the last.
//!
//! Every check runs on what there is: of a clock that jumps the longest part is looked at, and a sample beyond what any IMU measures is named
//! and left out.

mod attitudes;
mod bias;
mod clock;
mod copies;
#[cfg(feature = "logs")]
mod covariance;
mod frozen;
mod held;
mod kept;
mod mixed;
pub mod motion;
#[cfg(feature = "logs")]
pub mod reading;
pub mod table;
pub mod timing;
mod turned;
pub mod values;
pub mod vibration;

use crate::finding::Finding;
use crate::phases::{Phase, Stretch, phases};
use crate::rates;
use crate::rest_noise::RestNoise;
use dpn_core::{Recorded, Sensor};
#[cfg(feature = "logs")]
use dpn_logs::Log;
use serde::Serialize;
use std::io;
use vibration::AxisSpectrum;

/// What an examination leaves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Examination {
    /// Samples that were looked at.
    pub samples: usize,
    /// From the first to the last stamp \[s\].
    pub length_s: f64,
    /// Median rate \[Hz\].
    pub rate_hz: f64,
    /// What a table of logs has of it.
    pub figures: LogFigures,
    /// What was found, the gravest first.
    pub findings: Vec<Finding>,
    /// Spectra of the six axes, for the plot; none where the log is too short.
    #[serde(skip)]
    pub spectra: Vec<AxisSpectrum>,
    /// Noise in the longest rest.
    #[serde(skip)]
    pub rest: Option<RestNoise>,
}

/// A log in a few numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LogFigures {
    /// Samples that were lost, about.
    pub lost: f64,
    /// Seconds at rest.
    pub rest_s: f64,
    /// Length of the specific force: the median at rest, else of the whole log \[m/s^2\].
    pub gravity: f64,
    /// White noise at rest, the largest of the axes \[m/s^2/sqrt(Hz)\]; none where nothing rests.
    pub accel_noise: Option<f64>,
    /// The same of the gyroscope \[rad/s/sqrt(Hz)\].
    pub gyro_noise: Option<f64>,
}

/// Looks at what somebody recorded: its samples, and what the reader had to leave out or guess.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
#[cfg(feature = "logs")]
pub fn examine_log(log: &Log) -> io::Result<Examination> {
    let mut examination = examine(&log.recording)?;
    examination.findings.retain(|finding| !finding.is_of_zeros(log.alone));
    examination.findings.extend(reading::findings(log));
    let at_rest = [examination.figures.accel_noise, examination.figures.gyro_noise];
    examination.findings.extend(covariance::findings(log, at_rest));
    for (number, part) in (2..).zip(&log.others) {
        let other = examine(&part.recording)?;
        let [from, to] = part.places;
        let name = format!("part {number}, {}s {from} to {to}", log.place);
        let is_new = |f: &Finding| {
            f.warns()
                && !examination.findings.iter().any(|own| own.about == f.about && own.weight <= f.weight)
        };
        let named = |f: &Finding| Finding { text: format!("{name}: {}", f.text), ..f.clone() };
        let new: Vec<Finding> = other.findings.iter().filter(|f| is_new(f)).map(named).collect();
        let what =
            format!("{name}: {} samples, {:.1} s, {:.1} Hz", other.samples, other.length_s, other.rate_hz);
        examination.findings.push(Finding::note("parts", what));
        examination.findings.extend(new);
    }
    examination.findings.sort_by_key(|finding| finding.weight);
    Ok(examination)
}

/// Looks at a log as a whole.
pub(crate) fn examine(recording: &dyn Recorded) -> io::Result<Examination> {
    let (part, jumps) = clock::without_jumps(recording)?;
    let recording = part.as_ref().map_or(recording, |part| part);
    let mut findings: Vec<Finding> = jumps.into_iter().collect();
    let (of_timing, lost) = timing::findings(recording)?;
    let parts = rates::parts(recording)?;
    let of_rates = rates::finding(&parts);
    // Steps of a second rate are neither holes nor jitter.
    findings.extend(
        of_timing.into_iter().filter(|f| of_rates.is_none() || !["gaps", "jitter"].contains(&f.about)),
    );
    findings.extend(of_rates);
    let (measured, outliers) = values::without_outliers(recording)?;
    let measured = measured.as_ref().map_or(recording, |measured| measured);
    findings.extend(outliers);
    let (fresh, repeats) = timing::without_repeats(measured)?;
    let measured = fresh.as_ref().map_or(measured, |fresh| fresh);
    findings.extend(frozen::findings(recording)?);
    let is_repeating = repeats.is_some();
    findings.extend(repeats);
    let rest = crate::allan::rest::rest(measured)?;
    let spectra = vibration::spectra(measured)?;
    let (of_values, gravity) = values::findings(measured, &rest)?;
    findings.extend(of_values);
    findings.extend(mixed::copies(measured)?);
    findings.extend(mixed::overflows(measured)?);
    findings.extend(mixed::jumps(measured)?);
    findings.extend(turned::flips(measured)?);
    let stretches = phases(measured)?;
    if !findings.iter().any(|found| ["units", "columns", "dead"].contains(&found.about)) {
        let windows = turned::windows(measured)?;
        findings.extend(bias::finding(&windows).or_else(|| turned::axes(&windows)));
        if let Some(of_attitudes) = attitudes::finding(measured, &stretches)? {
            findings.retain(|found| found.about != "gravity" || !found.warns());
            findings.push(of_attitudes);
        }
    }
    findings.extend(copies::finding(recording)?);
    findings.extend(vibration::finding(&spectra));
    findings.extend(motion::findings(measured, &rest, &stretches)?);
    // Without the rows that repeat it has another rate.
    let parts = if is_repeating { rates::parts(measured)? } else { parts };
    let at_rest = RestNoise::in_parts(measured, &stretches, &parts)?;
    // Where rows repeat, both sensors are held.
    let of_rest = at_rest.iter().flat_map(RestNoise::findings);
    findings.extend(of_rest.filter(|f| !is_repeating || f.about != "held"));
    if !is_repeating && !findings.iter().any(|found| found.about == "held") {
        findings.extend(held::finding(measured)?);
    }
    let noise = |sensor| {
        let of = at_rest.as_ref()?.sensors.iter().find(|noise| noise.sensor == sensor)?;
        Some(of.densities()?.iter().map(|density| density.value).fold(0.0, f64::max))
    };
    let rests = stretches.iter().filter(|stretch| stretch.phase == Phase::Rest);
    let figures = LogFigures {
        lost,
        rest_s: rests.map(Stretch::length_s).fold(0.0, |sum, s| sum + s),
        gravity,
        accel_noise: noise(Sensor::Accel),
        gyro_noise: noise(Sensor::Gyro),
    };
    findings.sort_by_key(|finding| finding.weight);
    Ok(Examination {
        samples: recording.len(),
        length_s: recording.length_s(),
        rate_hz: recording.rate().hz(),
        figures,
        findings,
        spectra,
        rest: at_rest,
    })
}
