//! The health of somebody's log, before anybody trusts a figure made from it: findings by weight, each with a remedy.
//!
//! * [`timing`]: rate, jitter, dropped samples, the same sample twice.
//! * `clock`: clocks that were set, rates that no IMU has.
//! * [`values`]: gravity, units, swapped columns, clipped and dead axes, converter steps.
//! * [`vibration`]: spectral peaks and what may be aliased.
//! * [`motion`]: rest and motion, drift of the bias at rest.
//! * [`reading`]: damage, stamps that stand still or go back, values that are no numbers, all of which the reader left out.
//! * [`examine_log`]: all of them; `examine` without the last.
//!
//! Every check runs on what there is: of a clock that jumps the longest part is looked at, and a sample beyond what any IMU measures is named
//! and left out.

mod clock;
mod kept;
pub mod motion;
#[cfg(feature = "logs")]
pub mod reading;
pub mod timing;
pub mod values;
pub mod vibration;

use crate::finding::Finding;
use crate::phases::phases;
use crate::rest_noise::RestNoise;
use dpn_core::Recorded;
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
    /// What was found, the gravest first.
    pub findings: Vec<Finding>,
    /// Spectra of the six axes, for the plot; none where the log is too short.
    #[serde(skip)]
    pub spectra: Vec<AxisSpectrum>,
}

/// Looks at what somebody recorded: its samples, and what the reader had to leave out or guess.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
#[cfg(feature = "logs")]
pub fn examine_log(log: &Log) -> io::Result<Examination> {
    let mut examination = examine(&log.recording)?;
    examination.findings.extend(reading::findings(log));
    examination.findings.sort_by_key(|finding| finding.weight);
    Ok(examination)
}

/// Looks at a log as a whole.
pub(crate) fn examine(recording: &dyn Recorded) -> io::Result<Examination> {
    let (part, jumps) = clock::without_jumps(recording)?;
    let recording = part.as_ref().map_or(recording, |part| part);
    let mut findings: Vec<Finding> = jumps.into_iter().collect();
    findings.extend(timing::findings(recording)?);
    let (measured, outliers) = values::without_outliers(recording)?;
    let measured = measured.as_ref().map_or(recording, |measured| measured);
    findings.extend(outliers);
    let rest = crate::allan::rest::rest(measured)?;
    let spectra = vibration::spectra(measured)?;
    findings.extend(values::findings(measured, &rest)?);
    findings.extend(vibration::findings(&spectra));
    findings.extend(motion::findings(measured, &rest)?);
    let at_rest = RestNoise::of(measured, &phases(measured)?)?;
    findings.extend(at_rest.iter().flat_map(RestNoise::findings));
    findings.sort_by_key(|finding| finding.weight);
    Ok(Examination {
        samples: recording.len(),
        length_s: recording.length_s(),
        rate_hz: recording.rate().hz(),
        findings,
        spectra,
    })
}
