//! Ground truth: poses, in some files with velocities and biases.
//!
//! EuRoC's `state_groundtruth_estimate0/data.csv` and TUM-VI's `mocap0/data.csv` share one layout: stamp, position of the body in
//! the world, quaternion `w x y z` of `world_from_body`; then, in fuller files, velocity in the world (11 columns), gyroscope bias
//! and accelerometer bias (17 columns). The header decides which; without one, the number of columns does.

use crate::io::IoError;
use crate::io::decimal::TimeUnit;
use crate::io::pose::rotation;
use crate::io::rows::Rows;
use crate::time::Stamp;
use nalgebra::{Isometry3, Translation3, Vector3};
use std::path::Path;
use thiserror::Error;

/// Sensor biases, as the ground truth's authors estimated them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Biases {
    /// Gyroscope \[rad/s\].
    pub gyro: Vector3<f64>,
    /// Accelerometer \[m/s^2\].
    pub accel: Vector3<f64>,
}

/// The true state at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueState {
    /// When.
    pub t: Stamp,
    /// Points in the body frame to the world \[m\].
    pub world_from_body: Isometry3<f64>,
    /// Velocity \[m/s\]; in files of 11 and 17 columns.
    pub vel_in_world: Option<Vector3<f64>>,
    /// Biases; in files of 17 columns.
    pub biases: Option<Biases>,
}

/// True states in increasing time, at least one; all with the same parts.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundTruth {
    states: Vec<TrueState>,
}

/// Why states are not ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum GroundTruthError {
    /// No state.
    #[error("no state; ground truth needs at least one")]
    Empty,
    /// Stamps that stand still or go back.
    #[error("stamps do not increase at state {index}")]
    TimeNotIncreasing {
        /// Index of the offending state.
        index: usize,
    },
    /// NaN or infinity.
    #[error("state {index} holds a value that is not finite")]
    NotFinite {
        /// Index of the offending state.
        index: usize,
    },
    /// A state with other parts than the first one, or with biases and no velocity.
    #[error("state {index} has other parts than the first, or biases without velocity")]
    Uneven {
        /// Index of the offending state.
        index: usize,
    },
}

impl TrueState {
    fn values(&self) -> impl Iterator<Item = &f64> {
        let pose = &self.world_from_body;
        let biases = self.biases.iter().flat_map(|b| b.gyro.iter().chain(&b.accel));
        pose.translation
            .vector
            .iter()
            .chain(pose.rotation.coords.iter())
            .chain(self.vel_in_world.iter().flatten())
            .chain(biases)
    }
}

impl GroundTruth {
    /// Checks `states` and takes them.
    ///
    /// # Errors
    /// No state; stamps that do not increase; values that are not finite; states with different parts, or with biases and no velocity.
    pub fn new(states: Vec<TrueState>) -> Result<Self, GroundTruthError> {
        let first = states.first().ok_or(GroundTruthError::Empty)?;
        let parts = |s: &TrueState| (s.vel_in_world.is_some(), s.biases.is_some());
        let wanted = parts(first);
        for (index, state) in states.iter().enumerate() {
            if parts(state) != wanted || wanted == (false, true) {
                return Err(GroundTruthError::Uneven { index });
            }
            if !state.values().all(|v| v.is_finite()) {
                return Err(GroundTruthError::NotFinite { index });
            }
            if index > 0 && states[index - 1].t >= state.t {
                return Err(GroundTruthError::TimeNotIncreasing { index });
            }
        }
        Ok(Self { states })
    }

    /// The states, oldest first.
    pub fn states(&self) -> &[TrueState] {
        &self.states
    }

    /// Whether every state has a velocity.
    pub fn has_velocity(&self) -> bool {
        self.states.iter().all(|s| s.vel_in_world.is_some())
    }

    /// Whether every state has biases.
    pub fn has_biases(&self) -> bool {
        self.states.iter().all(|s| s.biases.is_some())
    }
}

/// Reads a ground-truth file of ASL's layout.
///
/// # Errors
/// A file that cannot be read or holds no row; other than 8, 11 or 17 columns; a row that holds what is no finite number; a
/// quaternion that is no rotation; stamps that do not increase.
pub fn read(path: &Path) -> Result<GroundTruth, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path)
}

const POSE: [&str; 7] = ["p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z"];
const VELOCITY: [&str; 3] = ["v_x", "v_y", "v_z"];
const GYRO_BIAS: [&str; 3] = ["b_w_x", "b_w_y", "b_w_z"];
const ACCEL_BIAS: [&str; 3] = ["b_a_x", "b_a_y", "b_a_z"];

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<GroundTruth, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    let width = rows.width();
    if !matches!(width, 8 | 11 | 17) {
        return Err(IoError::UnknownLayout {
            path: path.to_path_buf(),
            line: rows.header().map_or(rows.line() + 1, |h| h.line),
            found: width,
            expected: "8 (stamp, position, quaternion w x y z), 11 (and velocity) and 17 (and biases)",
        });
    }
    let mut states: Vec<TrueState> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let t = rows.stamp_after(states.last().map(|s| s.t), 0, TimeUnit::Nanos)?;
        let [x, y, z, qw, qx, qy, qz] = rows.numbers([1, 2, 3, 4, 5, 6, 7], POSE)?;
        let vector =
            |columns, names| -> Result<_, IoError> { Ok(Vector3::from(rows.numbers(columns, names)?)) };
        states.push(TrueState {
            t,
            world_from_body: Isometry3::from_parts(
                Translation3::new(x, y, z),
                rotation([qw, qx, qy, qz]).map_err(|norm| IoError::BadQuaternion {
                    path: path.to_path_buf(),
                    line: rows.line(),
                    norm,
                })?,
            ),
            vel_in_world: if width >= 11 { Some(vector([8, 9, 10], VELOCITY)?) } else { None },
            biases: if width == 17 {
                Some(Biases {
                    gyro: vector([11, 12, 13], GYRO_BIAS)?,
                    accel: vector([14, 15, 16], ACCEL_BIAS)?,
                })
            } else {
                None
            },
        });
    }
    Ok(GroundTruth { states })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(text: &str) -> Result<GroundTruth, IoError> {
        parse(text.as_bytes(), Path::new("data.csv"))
    }

    #[test]
    fn the_quaternion_is_read_scalar_first() {
        // A quarter turn about z takes the body's x axis to the world's y axis.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let truth = case(&format!("10,1,2,3,{half},0,0,{half}\n")).unwrap();
        let x = truth.states()[0].world_from_body * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((x.coords - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
        assert!(!truth.has_velocity() && !truth.has_biases());
    }

    #[test]
    fn eleven_and_seventeen_columns_carry_more() {
        let eleven = case("10,1,2,3,1,0,0,0,4,5,6\n").unwrap();
        assert_eq!(eleven.states()[0].vel_in_world, Some(Vector3::new(4.0, 5.0, 6.0)));
        assert!(!eleven.has_biases());
        let seventeen = case("10,1,2,3,1,0,0,0,4,5,6,7,8,9,10,11,12\n").unwrap();
        let biases = seventeen.states()[0].biases.unwrap();
        assert_eq!(biases.gyro, Vector3::new(7.0, 8.0, 9.0));
        assert_eq!(biases.accel, Vector3::new(10.0, 11.0, 12.0));
    }

    #[test]
    fn a_wrong_width_order_or_stamp_is_refused_with_its_line() {
        let error = |text: &str| case(text).unwrap_err().to_string();
        assert!(error("10,1,2,3,1,0,0,0,9\n").starts_with("data.csv:1: 9 columns; 8 (stamp"));
        assert_eq!(
            error("10,1,2,3,1,0,0,0\n20,1,2,3,1,0,0.5,0\n"),
            "data.csv:2: the quaternion has norm 1.118033988749895; a rotation has norm 1"
        );
        assert!(error("10,1,2,3,0,0,0,0\n").contains("norm 0;"));
        assert!(error("10,1,2,3,1,0,0,0\n9,1,2,3,1,0,0,0\n").starts_with("data.csv:2: time goes"));
    }
}
