//! Basalt's calibration (JSON, all below `value0`): densities despite the name `_std`; older files have one number for the three axes.
//!
//! `accel_bias_std`, `gyro_bias_std` are the walks; Basalt brings the noise to the rate `imu_update_rate` by itself.

use super::keyed::AxesText;
use super::keyed::Line;
use super::layout::{Layout, keys};
use dpn_core::noise::Meaning;

/// The keys below `value0`.
pub(super) const LAYOUT: Layout = Layout {
    keys: keys(
        ["accel_noise_std", "accel_bias_std", "gyro_noise_std", "gyro_bias_std"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: Some("imu_update_rate"),
    other_rates: &[],
    marks: &[],
    per_axis: true,
    walks_required: true,
};

/// JSON has no comments: what is not known is left out.
pub(super) fn write(lines: &[Line], rate: Option<&str>) -> String {
    let mut entries: Vec<String> =
        rate.map(|rate| format!("        \"imu_update_rate\": {rate}")).into_iter().collect();
    entries.extend(lines.iter().filter_map(|line| {
        let values = line.values?.each_text();
        Some(format!("        \"{}\": [{}]", line.key.name, values.join(", ")))
    }));
    format!("{{\n    \"value0\": {{\n{}\n    }}\n}}\n", entries.join(",\n"))
}
