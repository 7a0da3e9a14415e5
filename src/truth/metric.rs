//! How large a trajectory is, by the accelerometer: a camera alone does not know.
//!
//! Over `T` to both sides of an instant a position's second difference is the acceleration's mean under a triangle, times `T^2`. Published positions are `s` times those
//! of a point at the lever `l`; gravity is in a constant `c`, and the force has a bias `b`:
//! ```text
//! integral (T - |u|) R(t + u) (f(t + u) - b) du = (p(t + T) - 2 p(t) + p(t - T) - (R(t + T) - 2 R(t) + R(t - T)) l) / s + c
//! ```
//! The forces are on the left: a published attitude that is off by a degree turns gravity, positions are off by millimetres.

use crate::align::interpolated;
use crate::config::TruthConfig;
use crate::layout::Frames;
use dpn_core::ImuSample;
use dpn_core::trajectory::StampedPose;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// `T` \[s\].
const SPAN_S: f64 = 0.5;
/// Below this correlation nothing is said: the body hardly moves.
const TELLS: f64 = 0.8;
/// The fewest instants.
const LEAST: usize = 20;

/// Scale, lever, bias.
const UNKNOWNS: usize = 7;
/// One instant: what they are multiplied with, and the force.
type Row = (SMatrix<f64, 3, UNKNOWNS>, Vector3<f64>);

/// The trajectory's scale, 1 in metres; none where the motion does not tell.
pub(crate) fn scale(
    samples: &[ImuSample],
    poses: &[StampedPose],
    frames: &Frames,
    config: &TruthConfig,
) -> Option<f64> {
    let imu_from_published = frames.body_from_published_body.inverse();
    let at = |t: dpn_core::Stamp| {
        let pose = interpolated(poses, t.plus_seconds(frames.delay_s), config.longest_gap_s)?;
        Some((pose.translation.vector, pose.rotation * imu_from_published))
    };
    let row = |middle: usize| -> Option<Row> {
        let t = samples[middle].t;
        let ([p0, p1, p2], [r0, r1, r2]) = {
            let (a, b, c) = (at(t.plus_seconds(-SPAN_S))?, at(t)?, at(t.plus_seconds(SPAN_S))?);
            ([a.0, b.0, c.0], [a.1, b.1, c.1].map(|r| r.to_rotation_matrix().into_inner()))
        };
        let from = samples.partition_point(|s| s.t.seconds_since(t) <= -SPAN_S);
        let to = samples.partition_point(|s| s.t.seconds_since(t) < SPAN_S);
        let (mut sum, mut turned, mut weight) = (Vector3::zeros(), Matrix3::zeros(), 0.0);
        for sample in &samples[from..to] {
            let under = SPAN_S - sample.t.seconds_since(t).abs();
            let attitude = at(sample.t)?.1.to_rotation_matrix().into_inner() * under;
            sum += attitude * Vector3::from(sample.accel);
            turned += attitude;
            weight += under;
        }
        let mut by = SMatrix::<f64, 3, UNKNOWNS>::zeros();
        by.set_column(0, &(p2 - 2.0 * p1 + p0));
        by.fixed_columns_mut::<3>(1).copy_from(&(r2 - 2.0 * r1 + r0));
        let square = SPAN_S * SPAN_S / weight;
        by.fixed_columns_mut::<3>(4).copy_from(&(turned * square));
        Some((by, sum * square))
    };
    let every = (samples.len() as f64 * SPAN_S / samples.last()?.t.seconds_since(samples.first()?.t)).ceil();
    let rows: Vec<Row> = (0..samples.len()).step_by((every as usize).max(1)).filter_map(row).collect();
    let n = rows.len() as f64;
    let mean =
        rows.iter().fold((SMatrix::zeros(), Vector3::zeros()), |m: Row, r| (m.0 + r.0 / n, m.1 + r.1 / n));
    let (mut normal, mut right, mut square) =
        (SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros(), SVector::<f64, UNKNOWNS>::zeros(), 0.0);
    for (by, y) in &rows {
        let (by, y) = (by - mean.0, y - mean.1);
        normal += by.transpose() * by;
        right += by.transpose() * y;
        square += y.norm_squared();
    }
    let solved = normal.cholesky()?.solve(&right);
    let explained = right.dot(&solved);
    (rows.len() >= LEAST && explained > TELLS * TELLS * square).then_some(1.0 / solved[0])
}
