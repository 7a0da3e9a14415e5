//! The health of somebody's log, before anybody trusts a figure made from it: findings by weight, each with a remedy.
//!
//! * [`timing`]: rate, jitter, dropped samples, the same sample twice.
//! * [`values`]: gravity, units, swapped columns, clipped and dead axes, converter steps.
//! * [`vibration`]: spectral peaks and what may be aliased.
//! * [`motion`]: rest and motion, drift of the bias at rest.
//! * [`reading`]: damage, stamps that stand still or go back, values that are no numbers, all of which the reader left out.
//! * [`examine_log`]: all of them; `examine` without the last.

mod finding;
pub mod motion;
#[cfg(feature = "logs")]
pub mod reading;
pub mod timing;
pub mod values;
pub mod vibration;

pub use finding::{Finding, Weight};

use dpn_core::ImuRecording;
#[cfg(feature = "logs")]
use dpn_logs::Log;
use serde::Serialize;
use vibration::AxisSpectrum;

/// What an examination leaves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Examination {
    /// Samples of the log.
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
#[cfg(feature = "logs")]
pub fn examine_log(log: &Log) -> Examination {
    let mut examination = examine(&log.recording);
    examination.findings.extend(reading::findings(log));
    examination.findings.sort_by_key(|finding| finding.weight);
    examination
}

/// Looks at a log as a whole.
pub(crate) fn examine(recording: &ImuRecording) -> Examination {
    let rest = crate::allan::rest::rest(recording);
    let spectra = vibration::spectra(recording);
    let mut findings = timing::findings(recording);
    findings.extend(values::findings(recording, &rest));
    findings.extend(vibration::findings(&spectra));
    findings.extend(motion::findings(recording, &rest));
    findings.sort_by_key(|finding| finding.weight);
    Examination {
        samples: recording.len(),
        length_s: recording.duration(),
        rate_hz: recording.rate().hz(),
        findings,
        spectra,
    }
}
