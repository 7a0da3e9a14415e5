//! Variances per sample, under the names of MathWorks' `factorIMUParameters` (which takes no deviations).
//!
//! Its page gives the unit of the bias noises, `(rad/s)^2` and `(m/s^2)^2`, and no more; here they are the variances of the bias's increment
//! from one sample to the next.

use super::keyed::{self, Line};
use super::layout::{Layout, keys};
use dpn_core::noise::Meaning;

/// The properties of `factorIMUParameters`.
pub(super) const LAYOUT: Layout = Layout {
    keys: keys(
        ["AccelerometerNoise", "AccelerometerBiasNoise", "GyroscopeNoise", "GyroscopeBiasNoise"],
        Meaning::SampleVariance,
        Meaning::WalkStepVariance,
    ),
    rate: Some("SampleRate"),
    other_rates: &[],
    marks: &[],
    per_axis: true,
    walks_required: false,
};

pub(super) fn write(lines: &[Line], rate: Option<&str>) -> String {
    let mut text = String::from("# variances per sample (MathWorks factorIMUParameters)\n");
    if let Some(rate) = rate {
        text.push_str(&format!("SampleRate: {rate}  # Hz\n"));
    }
    text + &keyed::yaml(lines, "")
}
