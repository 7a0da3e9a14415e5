//! ORB-SLAM3's settings: densities, which it brings to the rate `IMU.Frequency` by itself.

use super::keyed::{self, Line};
use super::layout::{Layout, keys};
use dpn_core::noise::Meaning;

/// The keys of the settings.
pub(super) const LAYOUT: Layout = Layout {
    keys: keys(
        ["IMU.NoiseAcc", "IMU.AccWalk", "IMU.NoiseGyro", "IMU.GyroWalk"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: Some("IMU.Frequency"),
    other_rates: &[],
    marks: &[],
    per_axis: false,
    walks_required: true,
};

pub(super) fn write(lines: &[Line], rate: Option<&str>) -> String {
    let mut text = String::from("%YAML:1.0\n# ORB-SLAM3: densities\n");
    text.push_str(&keyed::yaml(lines, ""));
    if let Some(rate) = rate {
        text.push_str(&format!("IMU.Frequency: {rate}  # Hz; ORB-SLAM3 multiplies by its root itself\n"));
    }
    text
}
