//! From a flight's name, a seed and a configuration to a recording and everything that is true about it.

use crate::config::{ConfigError, FlightConfig, StampPattern};
use crate::flight::{Flight, FlightPlan, Phase, Phases, Split};
use crate::imu::{self, ImuTruth};
use crate::trajectory::{SplineError, Trajectory};
use dpn_core::imu::RecordingError;
use dpn_core::{ImuRecording, ImuSample, Stamp};
use nalgebra::{Isometry3, Translation3, Vector3};
use rayon::prelude::*;
use thiserror::Error;

/// Why there is no flight.
#[derive(Debug, Error, PartialEq)]
pub enum SimulationError {
    /// Keys out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A trajectory that cannot be.
    #[error("{flight}: its trajectory is no spline")]
    Trajectory {
        /// Which flight.
        flight: Flight,
        /// What is wrong with it.
        source: SplineError,
    },
    /// Readings that make no recording.
    #[error("{flight}: its readings make no recording")]
    Recording {
        /// Which flight.
        flight: Flight,
        /// What is wrong with them.
        source: RecordingError,
    },
}

/// The body's true state at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueState {
    /// The sample's stamp.
    pub t: Stamp,
    /// Pose: maps points of the body frame into the world.
    pub world_from_body: Isometry3<f64>,
    /// Velocity \[m/s\].
    pub vel_in_world: Vector3<f64>,
    /// Bias of the gyroscope \[rad/s\].
    pub gyro_bias: Vector3<f64>,
    /// Bias of the accelerometer \[m/s^2\].
    pub accel_bias: Vector3<f64>,
}

/// A flight, recorded, with the truth beside it. All per-sample series have the recording's length.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedFlight {
    /// Which flight.
    pub flight: Flight,
    /// The seed it was made with.
    pub seed: u64,
    /// What the IMU recorded.
    pub recording: ImuRecording,
    /// The parts the recording was put together from.
    pub truth: ImuTruth,
    /// State at every sample.
    pub ground_truth: Vec<TrueState>,
    /// Pose, velocity and rates at any time, seconds after the first stamp.
    pub trajectory: Trajectory,
    /// When each phase begins and ends, seconds after the first stamp.
    pub phases: Phases,
    /// Phase at every sample.
    pub phase_track: Vec<Phase>,
}

impl SimulatedFlight {
    /// The flight's name.
    pub fn name(&self) -> &'static str {
        self.flight.name()
    }

    /// Whether it may be trained on.
    pub fn split(&self) -> Split {
        self.flight.split()
    }
}

/// Flies `flight`: the same flight, seed and configuration give the same bits.
///
/// # Errors
/// A configuration out of its bounds. The other errors would be bugs of the flights; they are not seen.
pub fn simulate(
    flight: Flight,
    seed: u64,
    config: &FlightConfig,
) -> Result<SimulatedFlight, SimulationError> {
    config.validate()?;
    let plan =
        FlightPlan::new(flight, seed).map_err(|source| SimulationError::Trajectory { flight, source })?;
    let stamps = stamps(config, plan.phases.duration());
    let first = Stamp::from_ns(config.epoch_ns);
    let times: Vec<f64> = stamps.iter().map(|s| s.seconds_since(first)).collect();
    let (truth, reading) = imu::read(&plan, &times, seed, config);

    let samples = stamps
        .iter()
        .zip(reading.gyro.iter().zip(&reading.accel))
        .map(|(&t, (&gyro, &accel))| ImuSample { t, gyro, accel })
        .collect();
    let recording =
        ImuRecording::new(samples).map_err(|source| SimulationError::Recording { flight, source })?;
    let ground_truth = stamps
        .iter()
        .zip(&times)
        .enumerate()
        .map(|(i, (&t, &seconds))| {
            let state = plan.trajectory.state(seconds);
            TrueState {
                t,
                world_from_body: Isometry3::from_parts(
                    Translation3::from(state.position_in_world),
                    state.world_from_body,
                ),
                vel_in_world: state.vel_in_world,
                gyro_bias: truth.bias.gyro[i].into(),
                accel_bias: truth.bias.accel[i].into(),
            }
        })
        .collect();
    Ok(SimulatedFlight {
        flight,
        seed,
        recording,
        truth,
        ground_truth,
        phase_track: times.iter().map(|&t| plan.phases.at(t)).collect(),
        trajectory: plan.trajectory,
        phases: plan.phases,
    })
}

/// All eleven flights, in order, flown in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_all(seed: u64, config: &FlightConfig) -> Result<Vec<SimulatedFlight>, SimulationError> {
    Flight::ALL
        .into_par_iter()
        .map(|flight| simulate(flight, seed, config))
        .collect()
}

/// Stamps from the epoch on, up to `duration` seconds.
fn stamps(config: &FlightConfig, duration: f64) -> Vec<Stamp> {
    let period_ns = 1e9 / config.rate_hz.hz();
    let n = (duration * config.rate_hz.hz()).round() as i64;
    let grid = match config.stamps {
        StampPattern::Exact => 1,
        StampPattern::Euroc => 256,
    };
    (0..n)
        .map(|i| {
            let since = (i as f64 * period_ns).round() as i64;
            Stamp::from_ns(config.epoch_ns + (since + grid / 2) / grid * grid)
        })
        .collect()
}
