//! The most that a network labelled with `effective(T)` could say: the true deviation over [`SPAN`] samples of every axis along a simulated
//! flight, the mean over two seconds with the future included, written as a noise track a flight.
//!
//! ```sh
//! cargo run --release -p dpn-eval --example true_effective -- SEED OUT
//! dpn run f07-room-medium --seed SEED --noise 'self(file("OUT/f07-room-medium.csv"))'
//! ```
#![allow(clippy::unwrap_used)]

use dpn_core::{ImuNoise, NoiseTrack, Sensor};
use dpn_io::write_noise_track;
use dpn_sim::{Flight, FlightConfig, simulate};
use std::path::Path;

/// Samples of a sum: 0.1 s at 200 Hz.
const SPAN: usize = 20;
/// Deviation of the Gaussian that squares are weighed with in time, in samples: one second.
const MEMORY: f64 = 200.0;

/// Deviation of the white noise that errs as much as `errors` does in sums of [`SPAN`] samples, at every sample.
fn effective(errors: &[f64]) -> Vec<f64> {
    let squares: Vec<f64> =
        errors.windows(SPAN).map(|window| window.iter().sum::<f64>().powi(2) / SPAN as f64).collect();
    let reach = (3.0 * MEMORY) as isize;
    let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / MEMORY).powi(2)).exp()).collect();
    let last = squares.len() as isize - 1;
    let level = |at: isize| {
        let terms = (-reach..=reach).zip(&weights);
        let sum: f64 = terms.map(|(k, weight)| weight * squares[(at + k).clamp(0, last) as usize]).sum();
        (sum / weights.iter().sum::<f64>()).sqrt()
    };
    (0..errors.len()).map(|i| level(i as isize - SPAN as isize / 2)).collect()
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (seed, out) = (args[1].parse().unwrap(), Path::new(&args[2]));
    std::fs::create_dir_all(out).unwrap();
    for flight in Flight::ALL {
        let flown = simulate(flight, seed, &FlightConfig::default()).unwrap();
        let truth = &flown.truth;
        let [accel, gyro] = [Sensor::Accel, Sensor::Gyro].map(|sensor| {
            [0, 1, 2].map(|axis| {
                let parts = [&truth.vibration, &truth.white, &truth.quantisation].map(|part| part.of(sensor));
                let error = |i: usize| parts.iter().map(|part| part[i][axis]).sum();
                effective(&(0..flown.recording.len()).map(error).collect::<Vec<f64>>())
            })
        });
        let noises = (0..flown.recording.len()).map(|i| {
            ImuNoise::from_values(accel.each_ref().map(|a| a[i]), gyro.each_ref().map(|g| g[i])).unwrap()
        });
        let stamps = flown.recording.samples().iter().map(|sample| sample.t).collect();
        let track = NoiseTrack::new(stamps, noises.collect()).unwrap();
        write_noise_track(&out.join(format!("{}.csv", flight.name())), &track).unwrap();
    }
}
