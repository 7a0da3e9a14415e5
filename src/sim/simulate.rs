//! From a flight's name, a seed and a configuration to a recording and everything that is true about it.

use crate::config::{FlightConfig, StampPattern};
use crate::flight::{Flight, FlightPlan, Phase, Phases};
use crate::imu::{self, ImuTruth};
use crate::trajectory::Trajectory;
use dpn_core::config::{ConfigFaults, Validate};
use dpn_core::imu::RecordingError;
use dpn_core::truth::{Biases, TrueState};
use dpn_core::{ImuRecording, ImuSample, Stamp};
use nalgebra::{Isometry3, Translation3};
use rayon::prelude::*;
use thiserror::Error;

/// Why there is no flight.
#[derive(Debug, Error, PartialEq)]
pub enum SimulationError {
    /// Keys out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigFaults),
    /// Readings that make no recording.
    #[error("{flight}: its readings make no recording")]
    Recording {
        /// Which flight.
        flight: Flight,
        /// What is wrong with them.
        source: RecordingError,
    },
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
    /// State at every sample, with velocity and biases.
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
    pub fn split(&self) -> dpn_core::Side {
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
    let plan = FlightPlan::new(flight, seed);
    let stamps = stamps(config, plan.phases.duration());
    let first = Stamp::from_ns(config.epoch_ns);
    let times: Vec<f64> = stamps.iter().map(|s| s.seconds_since(first)).collect();
    let trajectory = imu::flown(&plan, seed, &config.vibration);
    let (truth, reading) = imu::read(&plan, &trajectory, &times, seed, config);

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
            let state = trajectory.state(seconds);
            TrueState {
                t,
                world_from_body: Isometry3::from_parts(
                    Translation3::from(state.position_in_world),
                    state.world_from_body,
                ),
                vel_in_world: Some(state.vel_in_world),
                biases: Some(Biases { gyro: truth.bias.gyro[i].into(), accel: truth.bias.accel[i].into() }),
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
        trajectory,
        phases: plan.phases,
    })
}

/// The path of `flight` alone, without its readings.
///
/// # Errors
/// A configuration out of its bounds.
pub fn path(flight: Flight, seed: u64, config: &FlightConfig) -> Result<Trajectory, SimulationError> {
    config.validate()?;
    Ok(imu::flown(&FlightPlan::new(flight, seed), seed, &config.vibration))
}

/// All eleven flights, in order, flown in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_all(seed: u64, config: &FlightConfig) -> Result<Vec<SimulatedFlight>, SimulationError> {
    Flight::ALL.into_par_iter().map(|flight| simulate(flight, seed, config)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::ImuSeries;
    use dpn_core::Sensor;
    use proptest::prelude::*;

    fn flown(flight: Flight, config: &FlightConfig) -> SimulatedFlight {
        simulate(flight, 42, config).unwrap()
    }

    fn reading(flight: &SimulatedFlight) -> ImuSeries {
        ImuSeries {
            gyro: flight.recording.samples().iter().map(|s| s.gyro).collect(),
            accel: flight.recording.samples().iter().map(|s| s.accel).collect(),
        }
    }

    #[test]
    fn twice_the_same_is_the_same_to_the_last_bit() {
        let config = FlightConfig::default();
        assert_eq!(flown(Flight::RoomWild, &config), flown(Flight::RoomWild, &config));
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let four_threads = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let all = |pool: &rayon::ThreadPool| pool.install(|| simulate_all(1, &config)).unwrap();
        assert_eq!(all(&one_thread), all(&four_threads));
    }

    #[test]
    fn the_flights_are_pinned() {
        // A change here changes figures made from simulated flights: say so in the change log under "Numbers".
        let flight = flown(Flight::HallSlow, &FlightConfig::default());
        let middle = flight.recording.len() / 2;
        let state = flight.trajectory.state(60.0);
        let found = [
            flight.truth.white.accel[0][0],
            flight.truth.white.gyro[middle][2],
            flight.truth.bias.accel[middle][1],
            flight.truth.vibration.accel[middle][0],
            flight.truth.vibration.gyro[middle][1],
            state.position_in_world.x,
        ];
        for (found, pinned) in found.into_iter().zip(PINNED) {
            // The sine of a long phase may differ in its last bits from machine to machine.
            assert!((found - pinned).abs() < 1e-9, "{found:e} {pinned:e}");
        }
    }

    const PINNED: [f64; 6] =
        [0.00767556111, -0.00252552623, 0.01604123035, -0.17931548710, 0.02831049874, 1.89362586614];

    #[test]
    fn switching_a_part_off_moves_no_bit_of_another() {
        let all = flown(Flight::RoomAggressive, &FlightConfig::default());
        let mut config = FlightConfig::default();
        config.vibration.scale = 0.0;
        let still = flown(Flight::RoomAggressive, &config);
        assert_ne!(all.recording, still.recording);
        assert_eq!(all.truth.white, still.truth.white);
        assert_eq!(all.truth.bias, still.truth.bias);
        // Of the vibration what the frame does is motion: the path is another one, by less than a millimetre.
        assert!(
            (all.trajectory.pose(50.0).translation.vector - still.trajectory.pose(50.0).translation.vector)
                .norm()
                < 1e-3
        );
        config = FlightConfig::default();
        config.white.scale = 0.0;
        config.quantisation.enabled = false;
        let quiet = flown(Flight::RoomAggressive, &config);
        assert_eq!(all.truth.vibration, quiet.truth.vibration);
        assert_eq!(all.truth.clean, quiet.truth.clean);
        assert_eq!(all.truth.bias, quiet.truth.bias);
    }

    #[test]
    fn the_parts_sum_to_the_recording() {
        let mut config = FlightConfig::default();
        let counted = flown(Flight::RoomMedium, &config);
        config.quantisation.enabled = false;
        let exact = flown(Flight::RoomMedium, &config);
        assert_eq!(exact.truth.unrounded(), reading(&exact));
        let (sum, read) = (counted.truth.unrounded(), reading(&counted));
        for sensor in Sensor::ALL {
            let lsb = config.quantisation.lsb(sensor);
            for i in 0..sum.len() {
                for axis in 0..3 {
                    let (sum, read) = (sum.of(sensor)[i][axis], read.of(sensor)[i][axis]);
                    let error = counted.truth.quantisation.of(sensor)[i][axis];
                    assert_eq!((sum / lsb).round() * lsb, read);
                    assert!((sum + error - read).abs() <= 4e-15 * read.abs().max(1e-3));
                }
            }
        }
    }

    #[test]
    fn an_ideal_imu_at_rest_reads_gravity_exactly() {
        let flight = flown(Flight::Hover, &FlightConfig::ideal());
        let mut stood = 0;
        for (sample, phase) in flight.recording.samples().iter().zip(&flight.phase_track) {
            if phase.stands() {
                assert_eq!((sample.gyro, sample.accel), ([0.0; 3], [0.0, 0.0, 9.81]));
                stood += 1;
            }
        }
        assert!(stood > 4000);
    }

    #[test]
    fn stamps_step_as_those_of_euroc() {
        let flight = flown(Flight::HallFast, &FlightConfig::default());
        let steps: Vec<i64> =
            flight.recording.samples().windows(2).map(|w| w[1].t.ns() - w[0].t.ns()).collect();
        assert!(steps.iter().all(|s| [4_999_936, 5_000_192].contains(s)));
        assert!((flight.recording.rate().hz() - 200.0).abs() < 0.01);
        assert!((flight.recording.duration() - flight.phases.duration()).abs() < 0.01);
        let exact = FlightConfig { stamps: StampPattern::Exact, ..FlightConfig::default() };
        let exact = flown(Flight::HallFast, &exact);
        assert!(exact.recording.samples().windows(2).all(|w| w[1].t.ns() - w[0].t.ns() == 5_000_000));
    }

    #[test]
    fn the_oracle_says_the_deviation_the_noise_was_drawn_with() {
        let flight = flown(Flight::RoomSlow, &FlightConfig::default());
        let track = flight.truth.oracle(&flight.recording).unwrap();
        assert_eq!(track.noises().len(), flight.recording.len());
        let middle = flight.recording.len() / 2;
        assert_eq!(track.noises()[middle].of(Sensor::Accel), flight.truth.white_sigma.accel[middle]);
        let other = flown(Flight::Hover, &FlightConfig::default());
        assert!(flight.truth.oracle(&other.recording).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn any_flight_of_any_seed_flies(number in 0..11usize, seed: u64) {
            let flight = simulate(Flight::ALL[number], seed, &FlightConfig::default()).unwrap();
            let sane = flight.recording.samples().iter().all(|s| {
                s.accel.iter().all(|a| a.abs() < 40.0) && s.gyro.iter().all(|g| g.abs() < 8.0)
            });
            prop_assert!(sane);
        }
    }
}
