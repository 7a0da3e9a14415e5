//! OKVIS' and OKVIS2's `imu_parameters`: densities. `sigma_bg` and `sigma_ba` beside them are priors of the biases, no walks.

use super::keyed::{self, Line};
use super::layout::{Layout, keys};
use dpn_core::noise::Meaning;

/// The keys below `imu_parameters`.
pub(super) const LAYOUT: Layout = Layout {
    keys: keys(
        ["sigma_a_c", "sigma_aw_c", "sigma_g_c", "sigma_gw_c"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: None,
    other_rates: &["imu_rate"],
    marks: &[],
    per_axis: false,
    walks_required: true,
};

pub(super) fn write(lines: &[Line], _rate: Option<&str>) -> String {
    String::from("%YAML:1.0\n# OKVIS2: densities\nimu_parameters:\n") + &keyed::yaml(lines, "    ")
}
