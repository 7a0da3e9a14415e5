//! OpenVINS' `kalibr_imu_chain.yaml`: Kalibr's keys below `imu0`, in OpenCV's YAML.

use super::keyed::{self, Line};
use super::layout::Layout;

/// Kalibr's keys.
pub(super) const LAYOUT: Layout =
    Layout { marks: &["T_i_b", "Tw", "Ta", "Tg", "R_IMUtoGYRO", "R_IMUtoACC"], ..super::kalibr::LAYOUT };

pub(super) fn write(lines: &[Line], rate: Option<&str>) -> String {
    let mut text = String::from("%YAML:1.0\n# OpenVINS kalibr_imu_chain.yaml: densities\nimu0:\n");
    text.push_str(&keyed::yaml(lines, "  "));
    if let Some(rate) = rate {
        text.push_str(&format!("  update_rate: {rate}  # Hz\n"));
    }
    text
}
