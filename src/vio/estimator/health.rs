//! When an estimate is not to be believed any more.

use crate::state::NavState;
use dpn_core::config::Limit;
use serde::Serialize;
use thiserror::Error;

dpn_core::settings!(
    /// Limits beyond which the estimator gives up and starts again.
    #[derive(Copy)]
    pub struct HealthConfig {
        /// Largest accelerometer bias \[m/s^2\].
        pub max_accel_bias: f64 = 2.5 => Limit::Positive,
        /// Largest gyro bias \[rad/s\].
        pub max_gyro_bias: f64 = 1.0 => Limit::Positive,
        /// Largest correction of the newest position against the inertial prediction \[m\].
        pub max_jump: f64 = 1.0 => Limit::Positive,
        /// Largest speed \[m/s\].
        pub max_speed: f64 = 50.0 => Limit::Positive,
        /// A frame with fewer tracks going on than this is starved.
        pub min_tracks: usize = 6,
        /// Starvation beyond this is a failure \[s\]: inertial integration alone drifts away in seconds.
        pub max_starved: f64 = 3.0 => Limit::Positive,
        /// A step between two samples longer than this is a gap that integration cannot bridge \[s\].
        pub max_imu_gap: f64 = 0.1 => Limit::Positive,
    }
);

/// Why the estimator started again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Error)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum RestartReason {
    /// A number that is none.
    #[error("a state was not finite")]
    NotFinite,
    /// A bias that no sensor has \[m/s^2 or rad/s\].
    #[error("biases of {accel:.2} m/s^2 and {gyro:.3} rad/s: no sensor has those")]
    Bias {
        /// Of the accelerometer.
        accel: f64,
        /// Of the gyro.
        gyro: f64,
    },
    /// A jump against the inertial prediction \[m\].
    #[error("a jump of {distance:.2} m against the inertial prediction")]
    Jump {
        /// How far.
        distance: f64,
    },
    /// A speed that is not believed \[m/s\].
    #[error("a speed of {speed:.1} m/s")]
    Speed {
        /// How fast.
        speed: f64,
    },
    /// Too few tracks for too long \[s\].
    #[error("too few tracks for {seconds:.1} s")]
    Starved {
        /// How long.
        seconds: f64,
    },
    /// The camera's clock turned out to be off \[s\].
    #[error("the camera's clock was off by {:.1} ms more than was known", 1e3 * seconds)]
    CameraClock {
        /// By how much.
        seconds: f64,
    },
    /// A hole in the samples \[s\].
    #[error("a gap of {seconds:.2} s in the IMU's samples")]
    ImuGap {
        /// How long.
        seconds: f64,
    },
}

impl RestartReason {
    /// Whether samples and tracks contradicted each other; what a sensor left out is no contradiction.
    pub fn is_contradiction(&self) -> bool {
        !matches!(self, Self::Starved { .. } | Self::ImuGap { .. } | Self::CameraClock { .. })
    }
}

impl HealthConfig {
    /// What is wrong with a state, if anything; `predicted` is where the samples alone would have put it. A bias may lie as far beyond its limit as
    /// jumps that were found `reach`, accelerometer and gyro.
    pub(crate) fn judge(
        &self,
        state: &NavState,
        predicted: &NavState,
        reach: [f64; 2],
    ) -> Option<RestartReason> {
        if !state.is_finite() {
            return Some(RestartReason::NotFinite);
        }
        let (accel, gyro) = (state.bias.accel.norm(), state.bias.gyro.norm());
        if accel > self.max_accel_bias + reach[0] || gyro > self.max_gyro_bias + reach[1] {
            return Some(RestartReason::Bias { accel, gyro });
        }
        let jump = state.world_from_body.translation.vector - predicted.world_from_body.translation.vector;
        if jump.norm() > self.max_jump {
            return Some(RestartReason::Jump { distance: jump.norm() });
        }
        let speed = state.vel_in_world.norm();
        (speed > self.max_speed).then_some(RestartReason::Speed { speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn each_fault_is_named() {
        let config = HealthConfig::default();
        let (good, none) = (NavState::identity(), [0.0; 2]);
        assert_eq!(config.judge(&good, &good, none), None);
        let mut bad = good;
        bad.vel_in_world.x = f64::NAN;
        assert_eq!(config.judge(&bad, &good, none), Some(RestartReason::NotFinite));
        let mut bad = good;
        bad.bias.accel = Vector3::new(3.0, 0.0, 0.0);
        assert_eq!(config.judge(&bad, &good, none), Some(RestartReason::Bias { accel: 3.0, gyro: 0.0 }));
        assert_eq!(config.judge(&bad, &good, [1.0, 0.0]), None);
        let mut bad = good;
        bad.world_from_body.translation.vector.y = 1.5;
        assert_eq!(config.judge(&bad, &good, none), Some(RestartReason::Jump { distance: 1.5 }));
        let mut bad = good;
        bad.vel_in_world.z = -60.0;
        assert_eq!(config.judge(&bad, &good, none), Some(RestartReason::Speed { speed: 60.0 }));
    }
}
