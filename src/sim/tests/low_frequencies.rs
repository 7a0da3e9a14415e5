//! What the simulated IMU reads below 35 Hz, and what of it no motion explains, against EuRoC's flights.

use dpn_core::geometry::so3;
use dpn_core::signal::Welch;
use dpn_core::signal::stats::median;
use dpn_core::{GRAVITY, Sensor};
use dpn_sim::{FlightConfig, Phase, SimulatedFlight, simulate_all};
use nalgebra::Vector3;

/// Samples in a span of .1 s.
const SPAN: usize = 20;

fn flights() -> Vec<SimulatedFlight> {
    let mut config = FlightConfig::default();
    config.white.schedule = false;
    simulate_all(1, &config).unwrap()
}

/// Median over the flights of a figure an axis, gyroscope and accelerometer.
fn medians(figures: &[[[f64; 3]; 2]], sensor: usize) -> [f64; 3] {
    std::array::from_fn(|axis| median(&figures.iter().map(|f| f[sensor][axis]).collect::<Vec<_>>()))
}

fn within_twice(what: &str, found: [f64; 3], real: [f64; 3]) {
    for (found, real) in found.into_iter().zip(real) {
        assert!((0.5..2.0).contains(&(found / real)), "{what}: {found} where EuRoC has {real}");
    }
}

/// Per interval: what gyroscope and accelerometer read on top of bias and motion, by the ground truth's states.
fn unexplained(flight: &SimulatedFlight) -> [Vec<Vector3<f64>>; 2] {
    let samples = flight.recording.samples();
    let flying =
        |i: &usize| flight.phase_track[*i] == Phase::Flying && flight.phase_track[*i + 1] == Phase::Flying;
    let intervals = (0..samples.len() - 1).filter(flying).map(|i| {
        let (from, to) = (&flight.ground_truth[i], &flight.ground_truth[i + 1]);
        let dt = to.t.seconds_since(from.t);
        let turned = so3::log(&(from.world_from_body.rotation.inverse() * to.world_from_body.rotation));
        let world_from_middle = from.world_from_body.rotation * so3::exp(&(0.5 * turned));
        let faster = to.vel_in_world.unwrap() - from.vel_in_world.unwrap();
        let force = world_from_middle.inverse() * (faster / dt + Vector3::new(0.0, 0.0, GRAVITY));
        let bias = from.biases.unwrap();
        let mean = |a: [f64; 3], b: [f64; 3]| 0.5 * (Vector3::from(a) + Vector3::from(b));
        (
            mean(samples[i].gyro, samples[i + 1].gyro) - bias.gyro - turned / dt,
            mean(samples[i].accel, samples[i + 1].accel) - bias.accel - force,
        )
    });
    let (gyro, accel) = intervals.unzip();
    [gyro, accel]
}

#[test]
fn increments_err_as_those_of_euroc_do() {
    // Robust deviation of increments over .1 s minus ground truth, over sqrt(20) times the interval; median of V1_02, V2_01, V2_02, for the
    // accelerometer also MH_04 and MH_05, whose rotations are the gyroscope's own.
    let real = [[0.0046, 0.0085, 0.0058], [0.18, 0.17, 0.18]];
    let figures: Vec<[[f64; 3]; 2]> = flights()
        .iter()
        .map(|flight| {
            unexplained(flight).map(|errors| {
                let sums: Vec<Vector3<f64>> = errors
                    .chunks_exact(SPAN)
                    .map(|c| c.iter().sum::<Vector3<f64>>() / (SPAN as f64).sqrt())
                    .collect();
                std::array::from_fn(|axis| {
                    let values: Vec<f64> = sums.iter().map(|s| s[axis]).collect();
                    let middle = median(&values);
                    1.4826 * median(&values.iter().map(|v| (v - middle).abs()).collect::<Vec<_>>())
                })
            })
        })
        .collect();
    for (sensor, real) in real.into_iter().enumerate() {
        within_twice(["gyro", "accel"][sensor], medians(&figures, sensor), real);
    }
}

#[test]
fn bands_are_as_loud_as_those_of_euroc() {
    // Deviation of what is read in flight in each band, median over the eleven sequences.
    let real = [
        (8.0, 14.0, [[0.0121, 0.0271, 0.0304], [0.250, 0.075, 0.135]]),
        (14.0, 20.0, [[0.0085, 0.0303, 0.0185], [0.350, 0.079, 0.146]]),
        (20.0, 35.0, [[0.0217, 0.0144, 0.0173], [0.363, 0.381, 0.224]]),
        (80.0, 100.0, [[0.0062, 0.0358, 0.0198], [0.821, 0.272, 0.500]]),
    ];
    let flights = flights();
    for (low, high, real) in real {
        let figures: Vec<[[f64; 3]; 2]> = flights
            .iter()
            .map(|flight| {
                [Sensor::Gyro, Sensor::Accel].map(|sensor| {
                    std::array::from_fn(|axis| {
                        let all = flight.recording.axis(sensor, axis);
                        let flown = all.iter().zip(&flight.phase_track).filter(|(_, p)| **p == Phase::Flying);
                        let x: Vec<f64> = flown.map(|(v, _)| *v).collect();
                        let spectrum =
                            Welch::new(400).unwrap().spectrum(&x, flight.recording.rate()).unwrap();
                        spectrum.band_power(low, high).sqrt()
                    })
                })
            })
            .collect();
        for (sensor, real) in real.into_iter().enumerate() {
            let what = format!("{} from {low} to {high} Hz", ["gyro", "accel"][sensor]);
            within_twice(&what, medians(&figures, sensor), real);
        }
    }
}
