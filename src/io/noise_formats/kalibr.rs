//! Kalibr's `imu.yaml`, which ASL's and EuRoC's `sensor.yaml` and Maplab share: densities, a flat list of keys.

use super::keyed::{self, Line};
use super::layout::{Layout, keys};
use dpn_core::noise::Meaning;

/// The keys of `imu.yaml`.
pub(super) const LAYOUT: Layout = Layout {
    keys: keys(
        [
            "accelerometer_noise_density",
            "accelerometer_random_walk",
            "gyroscope_noise_density",
            "gyroscope_random_walk",
        ],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: Some("update_rate"),
    other_rates: &["rate_hz"],
    marks: &["rate_hz", "sensor_type"],
    per_axis: false,
    walks_required: true,
};

pub(super) fn write(lines: &[Line], rate: Option<&str>) -> String {
    let mut text = String::from("# Kalibr imu.yaml: densities\nrostopic: /imu0\n");
    if let Some(rate) = rate {
        text.push_str(&format!("update_rate: {rate}  # Hz\n"));
    }
    text + &keyed::yaml(lines, "")
}
