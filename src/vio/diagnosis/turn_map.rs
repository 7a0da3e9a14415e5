//! How a camera's turns come out of the gyroscope's, as a linear map.
//!
//! With the turns as rates in the camera's axes as calibrated, `camera = A gyroscope + u`, over pairs of frames, each with its own information, by iterated
//! weights (Geman and McClure's). Where all is well `A = 1`. Its polar form `A = R S` says what is not: `R` is a camera mounted otherwise, a scale of all axes a
//! gyroscope that reads otherwise, a scale of pan and tilt against roll a focal length: about the axis pixels say an angle without it; across it the shift of all points may be
//! a path's, and what is left, the bending `x y`, `x^2` of their flow, is as many times the true turn as the focal length is the true one.

use crate::clock::{ALIKE_PAIRS, FlowTurn, GyroCourse, weight};
use dpn_core::geometry::nearest::nearest_orthogonal;
use dpn_core::geometry::so3;
use dpn_core::signal::stats::upper_median;
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

/// Unknowns: the map by rows, the bias.
const UNKNOWNS: usize = 12;

/// A pair of frames: mean rates between them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    /// The gyroscope's, in the body's axes \[rad/s\].
    pub(crate) body: Vector3<f64>,
    /// The camera's, in its own.
    pub(crate) cam: Vector3<f64>,
    /// Information about the latter.
    pub(crate) information: Matrix3<f64>,
    /// From frame to frame \[s\].
    pub(crate) seconds: f64,
    /// Whether it begins with the frame that the turn before ended with.
    pub(crate) follows: bool,
}

impl Turn {
    /// Of a pair whose stamps are `offset_s` short of the gyroscope's clock; `None` where samples do not cover it.
    pub(crate) fn of(
        pair: &FlowTurn,
        before: Option<&FlowTurn>,
        course: &GyroCourse,
        offset_s: f64,
    ) -> Option<Self> {
        let (from, to) = (pair.from.plus_seconds(offset_s), pair.to.plus_seconds(offset_s));
        let seconds = pair.seconds();
        Some(Self {
            body: course.mean_rate(from, to)?,
            cam: pair.turn / seconds,
            information: pair.information * (seconds * seconds),
            seconds,
            follows: before.is_some_and(|before| before.to == pair.from),
        })
    }
}

/// The map, as what may be wrong with a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TurnMap {
    /// What turns the mounting that was given into the one that fits, in the camera's axes \[rad\].
    pub(crate) away: Vector3<f64>,
    /// Its deviation by axis \[rad\].
    pub(crate) away_std: Vector3<f64>,
    /// The camera's rate per gyroscope's about its x, y and z.
    pub(crate) scale: Vector3<f64>,
    /// Its deviation.
    pub(crate) scale_std: Vector3<f64>,
    map: Matrix3<f64>,
    /// What the camera's rate is beside \[rad/s\].
    pub(crate) bias: Vector3<f64>,
}

impl TurnMap {
    /// Of turns before a camera turned by `cam_from_body`; `None` where turns about some axis are missing.
    pub(crate) fn of(turns: &[Turn], cam_from_body: &UnitQuaternion<f64>) -> Option<Self> {
        let mut found = SVector::<f64, UNKNOWNS>::zeros();
        let mut weights = vec![1.0; turns.len()];
        let mut covariance = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        for _ in 0..6 {
            let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
            let mut right = SVector::<f64, UNKNOWNS>::zeros();
            for (turn, weight) in turns.iter().zip(&weights) {
                let rows = rows(turn, cam_from_body);
                let weighted = rows.transpose() * turn.information * *weight;
                normal += weighted * rows;
                right += weighted * turn.cam;
            }
            let inverse = normal.cholesky()?.inverse();
            found = inverse * right;
            let squares = |turn: &Turn| {
                let left = turn.cam - rows(turn, cam_from_body) * found;
                left.dot(&(turn.information * left))
            };
            let all: Vec<f64> = turns.iter().map(squares).collect();
            let scale = upper_median(all.iter().copied())?.max(f64::MIN_POSITIVE);
            weights = all.iter().map(|squares| weight(*squares, scale)).collect();
            let spread = all.iter().zip(&weights).map(|(squares, weight)| squares * weight).sum::<f64>()
                / (3.0 * weights.iter().sum::<f64>() - UNKNOWNS as f64).max(1.0);
            covariance = inverse * (spread * ALIKE_PAIRS);
        }
        let map = Matrix3::from_fn(|row, column| found[3 * row + column]);
        let rotation = UnitQuaternion::from_rotation_matrix(&nearest_orthogonal(&map).0);
        let scale = (rotation.inverse().to_rotation_matrix().matrix() * map).diagonal();
        // Next to A = 1: R is half the odd part, S the even one.
        let of = |row: usize, column: usize| covariance[(3 * row + column, 3 * row + column)];
        let odd = |a: usize, b: usize| 0.5 * (of(a, b) + of(b, a)).sqrt();
        Some(Self {
            away: so3::log(&rotation),
            away_std: Vector3::new(odd(1, 2), odd(0, 2), odd(0, 1)),
            scale,
            scale_std: Vector3::from_fn(|k, _| of(k, k).sqrt()),
            map,
            bias: found.fixed_rows::<3>(9).into_owned(),
        })
    }

    /// The camera's rate that the gyroscope's is mapped to, without the bias \[rad/s\].
    pub(crate) fn turned(&self, turn: &Turn, cam_from_body: &UnitQuaternion<f64>) -> Vector3<f64> {
        self.map * (cam_from_body * turn.body)
    }
}

/// Rows of a turn: `camera = A gyroscope + u`.
fn rows(turn: &Turn, cam_from_body: &UnitQuaternion<f64>) -> SMatrix<f64, 3, UNKNOWNS> {
    let gyro = cam_from_body * turn.body;
    let mut rows = SMatrix::<f64, 3, UNKNOWNS>::zeros();
    for row in 0..3 {
        rows.fixed_view_mut::<1, 3>(row, 3 * row).tr_copy_from(&gyro);
        rows[(row, 9 + row)] = 1.0;
    }
    rows
}
