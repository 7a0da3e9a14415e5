//! What an estimate says of how well its poses are known.

use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_figures::PoseBelief;
use nalgebra::{Matrix3, Matrix6};
use std::path::Path;

/// What `dpn run` leaves beside its trajectory, and the columns of the deviations in it.
const STATES: &str = "states.csv";
const COLUMNS: [&str; 6] =
    ["p_std_x [m]", "p_std_y [m]", "p_std_z [m]", "r_std_x [rad]", "r_std_y [rad]", "r_std_z [rad]"];

/// Of messages: covariances along the axes of the poses' frame.
pub(super) fn of_messages(covariances: &[(Stamp, [f64; 36])]) -> Vec<PoseBelief> {
    let block = |rows: &[f64; 36], from: usize| Matrix3::from_fn(|i, k| rows[6 * (from + i) + from + k]);
    let belief = |(t, rows): &(Stamp, [f64; 36])| PoseBelief {
        t: *t,
        position: block(rows, 0),
        rotation: block(rows, 3),
    };
    covariances.iter().map(belief).collect()
}

/// Of a run's trajectory: the deviations in the states beside it; none where there are none.
pub(super) fn of_run(trajectory: &Path, poses: &[StampedPose]) -> Vec<PoseBelief> {
    let text = std::fs::read_to_string(trajectory.with_file_name(STATES)).unwrap_or_default();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let columns: Option<Vec<usize>> =
        COLUMNS.iter().map(|name| head.iter().position(|column| column == name)).collect();
    let Some(columns) = columns else { return Vec::new() };
    let belief = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let t = Stamp::from_ns(fields.first()?.parse().ok()?);
        let pose = &poses[poses.binary_search_by_key(&t, |pose| pose.t).ok()?];
        let deviations =
            columns.iter().map(|at| fields.get(*at)?.parse::<f64>().ok()).collect::<Option<Vec<f64>>>()?;
        let covariance = Matrix6::from_fn(|i, k| if i == k { deviations[i].powi(2) } else { 0.0 });
        Some(PoseBelief::of_right(t, &pose.world_from_body, &covariance))
    };
    lines.filter_map(belief).collect()
}
