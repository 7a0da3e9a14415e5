//! Ground truth: the body's states as somebody else measured them; poses, and sometimes velocities and biases.

use crate::time::Stamp;
use nalgebra::{Isometry3, Vector3};
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
