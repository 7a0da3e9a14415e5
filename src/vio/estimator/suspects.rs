//! What of the calibration the residuals point at: a score test.
//!
//! At a window's solution, with its cameras held where they are, a quantity `c` of the calibration (the camera's place and mounting on the body, its clock, a sensor's
//! scale) changes the inertial residuals alone: the body's states go along with it. With these residuals `v` and their derivatives `J` by the states and `K`
//! by `c`, whitened, and `H` the information of all that the window knows, of the prior and of the tracks too,
//!
//! ```text
//! I = K^T K - Z^T H^-1 Z,   Z = J^T K,   g = -K^T v,   c = (sum I)^-1 sum g
//! ```
//!
//! once for every window whose frames are all new. The deviation is that of the scatter of the windows' own scores, whatever noise was told. The prior was made with what is
//! wrong and holds on to it: what is found is a part of what is there.
//! Source: the score test of C. R. Rao, Proc. Cambridge Phil. Soc. 44 (1948); White's (1982) covariance for it.

use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::preint::{NoisySample, Preintegration};
use crate::state::{ACCEL_BIAS, GYRO_BIAS, POSITION, ROTATION, STATE_DIM, VELOCITY};
use crate::window::{Frame, Window};
use dpn_core::geometry::so3::hat;
use dpn_core::{GRAVITY, Stamp};
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use serde::Serialize;
use thiserror::Error;

/// The camera's place on the body (3), its mounting (3), its clock (1), scales of gyroscope (3) and accelerometer (3).
const UNKNOWNS: usize = 13;
const MOUNTING: usize = 3;
const CLOCK: usize = 6;
const GYRO: usize = 7;
const ACCEL: usize = 10;
/// A quantity: its place, how many numbers it has, what each may be off by before anything is seen, and by what all of them are that is worth a word. Good recordings
/// have up to 0.04 m, 0.007 rad, 0.002 s and 0.03 \[m, rad, s, 1, 1\].
struct Quantity {
    first: usize,
    count: usize,
    usual: f64,
    worth: f64,
}
const QUANTITIES: [Quantity; 5] = [
    Quantity { first: 0, count: 3, usual: 0.1, worth: 0.07 },
    Quantity { first: MOUNTING, count: 3, usual: 0.1, worth: 0.025 },
    Quantity { first: CLOCK, count: 1, usual: 0.02, worth: 0.006 },
    Quantity { first: GYRO, count: 3, usual: 0.1, worth: 0.05 },
    // In level flight it is told from a bias by little: allowed for, never said.
    Quantity { first: ACCEL, count: 3, usual: 0.1, worth: f64::INFINITY },
];
/// So many deviations from none.
const SURE: f64 = 5.0;
/// Scales about the camera's axis and across it are apart, and those across it alike, by this share of the latter ...
const APART: f64 = 0.4;
/// ... where an axis of the IMU is the camera's by so much.
const ALONG: f64 = 0.7;
/// Fewest windows that are asked.
const FEWEST: usize = 6;
/// Windows that are kept: half an hour.
const MOST: usize = 1000;

type Score = SVector<f64, UNKNOWNS>;
type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Derivative = SMatrix<f64, STATE_DIM, UNKNOWNS>;

/// Adds up what windows say.
#[derive(Debug, Clone, Default)]
pub(super) struct Suspects {
    windows: Vec<(Score, Information)>,
    /// The newest frame of the last window that was read.
    until: Option<Stamp>,
}

/// What of the calibration residuals point at, and by how much it has to change.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Error)]
#[serde(rename_all = "snake_case", tag = "suspect")]
pub enum Suspect {
    /// The camera's place on the body.
    #[error(
        "residuals want the camera {:.2} m elsewhere on the body, by ({:.2}, {:.2}, {:.2}) m in the IMU's axes: look at the translation of the extrinsics",
        size(off), off[0], off[1], off[2]
    )]
    Place {
        /// In the body's axes \[m\].
        off: [f64; 3],
    },
    /// The camera's mounting.
    #[error(
        "residuals want the camera turned by {:.1} degrees or more about ({:.2}, {:.2}, {:.2}) in the IMU's axes: look at the rotation of the extrinsics and at the \
         principal point",
        size(off).to_degrees(), off[0] / size(off), off[1] / size(off), off[2] / size(off)
    )]
    Mounting {
        /// In the body's axes \[rad\].
        off: [f64; 3],
    },
    /// The camera's clock.
    #[error("residuals want {:+.1} ms more added to the camera's stamps (--time-offset)", 1e3 * off_s)]
    Clock {
        /// \[s\]
        off_s: f64,
    },
    /// The gyroscope's scale by axis, or the focal length.
    #[error(
        "residuals have the gyroscope read {:.2}, {:.2} and {:.2} times the rate about its axes: --gyro-scale takes a scale out{}",
        1.0 + off[0], 1.0 + off[1], 1.0 + off[2], or_focal(*focal)
    )]
    GyroScale {
        /// More than one.
        off: [f64; 3],
        /// What a focal length that explains it is over the one given, where turns about the camera's axis look right.
        focal: Option<f64>,
    },
}

fn or_focal(focal: Option<f64>) -> String {
    let words = |factor: f64| {
        format!(
            "; but turns about the camera's axis look right, as where the focal length is {factor:.2} times the one given, or beyond: is the calibration of this lens, and of images of this size?"
        )
    };
    focal.map(words).unwrap_or_default()
}

fn size(off: &[f64; 3]) -> f64 {
    Vector3::from(*off).norm()
}

impl Suspects {
    /// Reads a window that was solved, where all its frames are new; whether it was read.
    pub(super) fn read(&mut self, window: &mut Window) -> bool {
        let [oldest, .., newest] = window.frames() else { return false };
        let newest = newest.t;
        let known = self.until.is_some_and(|until| oldest.t < until) || self.windows.len() >= MOST;
        let rests = || window.frames().iter().any(|frame| frame.rest.is_some());
        if known || rests() || !window.factor_information() {
            return false;
        }
        self.until = Some(newest);
        self.windows.extend(score(window));
        true
    }

    /// All unknowns with their covariance.
    fn found(&self) -> Option<(Score, Information)> {
        let mut information = Information::zeros();
        for Quantity { first, count, usual, .. } in &QUANTITIES {
            (*first..first + count).for_each(|k| information[(k, k)] += 1.0 / (usual * usual));
        }
        let mut gradient = Score::zeros();
        for (g, i) in &self.windows {
            gradient += g;
            information += i;
        }
        let inverse = information.cholesky()?.inverse();
        let off = inverse * gradient;
        let mut spread = Information::zeros();
        for (g, i) in &self.windows {
            let left = g - i * off;
            spread += left * left.transpose();
        }
        Some((off, inverse * spread * inverse))
    }

    /// The quantity that is off by more than good recordings have, as surely as none other, before a camera mounted so; `None` where none is.
    pub(super) fn surest(&self, body_from_cam: &UnitQuaternion<f64>) -> Option<Suspect> {
        if self.windows.len() < FEWEST {
            return None;
        }
        let (off, covariance) = self.found()?;
        let sureness = |Quantity { first, count, worth, .. }: &Quantity| {
            let size = off.rows(*first, *count).norm();
            // Of its size: the deviation along itself.
            let along = off.rows(*first, *count) / size.max(f64::MIN_POSITIVE);
            let block = covariance.view((*first, *first), (*count, *count));
            let std = along.dot(&(block * &along)).max(0.0).sqrt();
            (size > *worth && size > SURE * std).then(|| size / std)
        };
        let sure = QUANTITIES.iter().filter_map(|quantity| Some((quantity.first, sureness(quantity)?)));
        let (first, _) = sure.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let three = || [off[first], off[first + 1], off[first + 2]];
        Some(match first {
            0 => Suspect::Place { off: three() },
            MOUNTING => Suspect::Mounting { off: three() },
            CLOCK => Suspect::Clock { off_s: off[CLOCK] },
            _ => Suspect::GyroScale { off: three(), focal: focal(&three(), body_from_cam) },
        })
    }
}

/// The focal length, over the one given, that looks like a gyroscope's scale: about the camera's axis pixels say an angle without it. Of a camera that looks along an axis of the IMU, and of
/// one that turned about it: where it did not, a gyroscope's scale looks like that too.
fn focal(off: &[f64; 3], body_from_cam: &UnitQuaternion<f64>) -> Option<f64> {
    let axis = body_from_cam * Vector3::z();
    let about: f64 = (0..3).map(|k| axis[k] * axis[k] * off[k]).sum();
    let across = 0.5 * (off.iter().sum::<f64>() - about);
    let alike = |k: usize| axis[k].abs() > ALONG || (off[k] - across).abs() < APART * across.abs();
    let is_focal = about.abs() < APART * across.abs() && (0..3).all(alike);
    is_focal.then_some(1.0 / (1.0 + across))
}

/// A window's score; `None` without inertial measurements. Its factor is its information's.
fn score(window: &Window) -> Option<(Score, Information)> {
    let layout = window.layout();
    let lever = window.body_from_cam().translation.vector;
    let mut across = vec![0.0; layout.dim() * UNKNOWNS];
    let (mut gradient, mut information) = (Score::zeros(), Information::zeros());
    for (i, pair) in window.frames().windows(2).enumerate() {
        let preint = pair[1].preint.as_ref()?;
        let root = sqrt_information(preint)?;
        let (first, last) = preint.samples().first().zip(preint.samples().last())?;
        let (residual, d_i, d_j) = inertial_jacobians(preint, &pair[0].state, &pair[1].state);
        let direct = by_scales(preint, &pair[0], &d_i);
        let by = root
            * (d_i * by_place(&pair[0], first, &lever) + d_j * by_place(&pair[1], last, &lever) + direct);
        gradient -= by.transpose() * (root * residual);
        information += by.transpose() * by;
        for (frame, d) in [(i, root * d_i), (i + 1, root * d_j)] {
            let product = d.transpose() * by;
            for c in 0..UNKNOWNS {
                for r in 0..STATE_DIM {
                    across[c * layout.dim() + layout.state(frame, r)] += product[(r, c)];
                }
            }
        }
    }
    let columns: Vec<&[f64]> = across
        .chunks_exact_mut(layout.dim())
        .map(|column| {
            window.factor.solve_lower(column, 0);
            &*column
        })
        .collect();
    for r in 0..UNKNOWNS {
        for c in 0..UNKNOWNS {
            information[(r, c)] -= columns[r].iter().zip(columns[c]).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    let finite = gradient.iter().chain(information.iter()).all(|v| v.is_finite());
    finite.then_some((gradient, information))
}

/// How a frame's state moves with the camera's place, mounting and clock, its camera held.
fn by_place(frame: &Frame, sample: &NoisySample, lever: &Vector3<f64>) -> Derivative {
    let state = &frame.state;
    let rotation = state.world_from_body.rotation.to_rotation_matrix().into_inner();
    let rate = Vector3::from(sample.sample.gyro) - state.bias.gyro;
    let force = Vector3::from(sample.sample.accel) - state.bias.accel;
    let accel = rotation * force - Vector3::z() * GRAVITY;
    let mut by = Derivative::zeros();
    let mut put = |row, column, block: Matrix3<f64>| by.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    put(POSITION, 0, -rotation);
    put(VELOCITY, 0, -rotation * hat(&rate));
    put(POSITION, MOUNTING, -rotation * hat(lever));
    put(ROTATION, MOUNTING, -Matrix3::identity());
    put(VELOCITY, MOUNTING, -rotation * hat(&rate) * hat(lever));
    by.fixed_view_mut::<3, 1>(POSITION, CLOCK).copy_from(&-state.vel_in_world);
    by.fixed_view_mut::<3, 1>(ROTATION, CLOCK).copy_from(&-rate);
    by.fixed_view_mut::<3, 1>(VELOCITY, CLOCK).copy_from(&-accel);
    by
}

/// How a residual moves with the scales of what the samples read: as with a bias of the size of the mean reading.
fn by_scales(preint: &Preintegration, frame: &Frame, d_i: &SMatrix<f64, STATE_DIM, STATE_DIM>) -> Derivative {
    let samples = preint.samples();
    let mean = |of: fn(&NoisySample) -> [f64; 3]| {
        samples.iter().map(|s| Vector3::from(of(s))).sum::<Vector3<f64>>() / samples.len() as f64
    };
    let rate = mean(|s| s.sample.gyro) - frame.state.bias.gyro;
    let force = mean(|s| s.sample.accel) - frame.state.bias.accel;
    let mut by = Derivative::zeros();
    for (column, bias, reading) in [(GYRO, GYRO_BIAS, rate), (ACCEL, ACCEL_BIAS, force)] {
        for axis in 0..3 {
            let rows = d_i.fixed_view::<9, 1>(0, bias + axis) * reading[axis];
            by.fixed_view_mut::<9, 1>(0, column + axis).copy_from(&rows);
        }
    }
    by
}
