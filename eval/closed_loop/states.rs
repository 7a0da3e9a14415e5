//! What the estimator believed at every frame, as a table.

use super::drive::EstimatorOutput;
use dpn_core::{NoiseTrack, Sensor};
use dpn_io::axis_columns;
use dpn_vio::estimator::Phase;
use std::io::Write;

/// Before the pose that covariances are about: stamp, position, quaternion (w x y z).
pub const ANCHOR: &str = "#anchor,";

/// Writes a line a frame as CSV: stamp, what the estimator does, state, believed deviations of the pose, noise in force, counts, the scale's relative
/// deviation, and where levels are learned those of walks and pixels. A line behind `#anchor` has the pose that the estimator took for known.
///
/// # Errors
/// Those of the writer.
pub fn write_states(
    output: &EstimatorOutput,
    noise: &NoiseTrack,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    write!(
        out,
        "#timestamp [ns],phase,{},q_w,q_x,q_y,q_z,{},{},{},{},{},{},{},tracked,landmarks,outliers,iterations,whitened,scale_std",
        axis_columns("p", "m"),
        axis_columns("v", "m s^-1"),
        axis_columns("accel_bias", "m s^-2"),
        axis_columns("gyro_bias", "rad s^-1"),
        axis_columns("p_std", "m"),
        axis_columns("r_std", "rad"),
        axis_columns("accel_noise", "m s^-2"),
        axis_columns("gyro_noise", "rad s^-1"),
    )?;
    let learned = output.updates.iter().any(|update| update.levels.is_some());
    writeln!(out, "{}", if learned { ",accel_walk_level,gyro_walk_level,pixel_level" } else { "" })?;
    if let Some(anchor) = &output.report.anchor {
        let (p, q) = (anchor.world_from_body.translation.vector, anchor.world_from_body.rotation.coords);
        write!(out, "{ANCHOR}{}", anchor.t.ns())?;
        for value in p.iter().chain([&q.w, &q.x, &q.y, &q.z]) {
            write!(out, ",{value:?}")?;
        }
        writeln!(out)?;
    }
    for update in &output.updates {
        let phase = match update.phase {
            Phase::Initialising(reason) => format!("initialising: {}", reason.name()),
            Phase::Tracking => "tracking".to_owned(),
            Phase::Restarted(_) => "restarted".to_owned(),
        };
        write!(out, "{},{phase}", update.t.ns())?;
        match &update.state {
            Some(state) => {
                let (p, q) =
                    (state.world_from_body.translation.vector, state.world_from_body.rotation.coords);
                let values = p.iter().chain([&q.w, &q.x, &q.y, &q.z]).chain(&state.vel_in_world);
                for value in values.chain(&state.bias.accel).chain(&state.bias.gyro) {
                    write!(out, ",{value:?}")?;
                }
            }
            None => write!(out, "{}", ",".repeat(16))?,
        }
        match &update.covariance {
            Some(covariance) => {
                for variance in covariance.diagonal().iter() {
                    write!(out, ",{:?}", variance.max(0.0).sqrt())?;
                }
            }
            None => write!(out, "{}", ",".repeat(6))?,
        }
        let at = noise.stamps().partition_point(|t| *t <= update.t).max(1) - 1;
        for value in Sensor::ALL.into_iter().flat_map(|sensor| noise.noises()[at].of(sensor)) {
            write!(out, ",{value:?}")?;
        }
        let [whitened, scale_std] =
            [update.whitened, update.scale_std].map(|x| x.map(|x| format!("{x:?}")).unwrap_or_default());
        write!(
            out,
            ",{},{},{},{},{whitened},{scale_std}",
            update.tracked, update.landmarks, update.outliers, update.iterations
        )?;
        if let Some(levels) = &update.levels {
            let [.., accel_walk, gyro_walk] = levels.inertial.0;
            write!(out, ",{accel_walk:?},{gyro_walk:?},{:?}", levels.pixel)?;
        }
        writeln!(out)?;
    }
    Ok(())
}
