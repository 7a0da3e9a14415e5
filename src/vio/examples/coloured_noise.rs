//! Where one white deviation is enough for noise that vibrates: errors of increments over what three covariances expect.
//!
//! `cargo run --release -p dpn-vio --example coloured_noise`: simulated flights with vibration against the same without. The noise is told as white of the
//! samples' deviation; as white that errs as much in a sum over 0.1 s; and as three lines beside white noise, fitted to its autocorrelation one
//! after the other. 1: the
//! covariance is right; 3: errors are three times what it expects. Prints the Markdown table of the book.
#![allow(clippy::unwrap_used)]

use dpn_core::{ImuNoise, ImuSample, Sensor};
use dpn_sim::{Flight, FlightConfig, simulate};
use dpn_vio::ImuBias;
use dpn_vio::preint::{
    LINES, NoiseColour, NoiseLine, NoiseLines, NoisySample, Preintegration, PreintegrationConfig,
};
use nalgebra::Vector3;

/// Samples in a tenth of a second.
const TENTH: usize = 20;
/// Lags to which a line is fitted.
const LAGS: usize = 40;

/// Noise of one sensor by axis.
type Noise = [Vec<f64>; 3];

fn noise(with: &[ImuSample], without: &[ImuSample], sensor: Sensor) -> Noise {
    let pairs = || with.iter().zip(without);
    std::array::from_fn(|axis| pairs().map(|(a, b)| a.of(sensor)[axis] - b.of(sensor)[axis]).collect())
}

fn rms(values: impl Iterator<Item = f64> + Clone) -> f64 {
    (values.clone().map(|v| v * v).sum::<f64>() / values.count() as f64).sqrt()
}

/// White deviation whose sum over a tenth errs as much.
fn effective(axis: &[f64]) -> f64 {
    rms(axis.windows(TENTH).map(|w| w.iter().sum::<f64>())) / (TENTH as f64).sqrt()
}

/// The mean autocorrelation of three axes, from lag 1 on.
fn correlation(noise: &Noise) -> Vec<f64> {
    let squares: f64 = noise.iter().flatten().map(|v| v * v).sum();
    let of = |axis: &Vec<f64>, lag: usize| axis.iter().zip(&axis[lag..]).map(|(a, b)| a * b).sum::<f64>();
    (1..=LAGS).map(|lag| noise.iter().map(|axis| of(axis, lag)).sum::<f64>() / squares).collect()
}

/// A line's autocorrelation at 200 Hz, but for its share.
fn shape(line: &NoiseLine, lag: usize) -> f64 {
    let t = lag as f64 / 200.0;
    (-t / line.decay_s).exp() * (std::f64::consts::TAU * line.hz * t).cos()
}

/// The line that is nearest to an autocorrelation, of at most this share.
fn nearest(correlation: &[f64], most: f64) -> NoiseLine {
    let mut best = (f64::INFINITY, NoiseLine::default());
    for hz in 0..=100 {
        for decay in 0..30 {
            let line = NoiseLine { share: 1.0, hz: f64::from(hz), decay_s: 0.005 * 1.25f64.powi(decay) };
            let pairs = || correlation.iter().enumerate().map(|(i, r)| (*r, shape(&line, i + 1)));
            let share = pairs().map(|(r, g)| r * g).sum::<f64>() / pairs().map(|(_, g)| g * g).sum::<f64>();
            let share = share.clamp(0.0, most);
            let left = pairs().map(|(r, g)| (r - share * g).powi(2)).sum::<f64>();
            if left < best.0 {
                best = (left, NoiseLine { share, ..line });
            }
        }
    }
    best.1
}

/// Lines that add up to the noise's autocorrelation: in turns each is fitted to what the others leave.
fn lines(noise: &Noise) -> NoiseLines {
    let mut lines = NoiseLines::default();
    for turn in 0..4 * LINES {
        let k = turn % LINES;
        lines.0[k].share = 0.0;
        let mut left = correlation(noise);
        for (i, r) in left.iter_mut().enumerate() {
            *r -= lines.0.iter().map(|line| line.share * shape(line, i + 1)).sum::<f64>();
        }
        lines.0[k] = nearest(&left, lines.white_share());
    }
    lines
}

fn integrated(config: PreintegrationConfig, samples: &[ImuSample], noise: ImuNoise) -> Preintegration {
    let noisy = |sample: &ImuSample| NoisySample { sample: *sample, noise };
    let mut preint = Preintegration::new(config, ImuBias::zero(), noisy(&samples[0]));
    samples[1..].iter().for_each(|sample| preint.push(noisy(sample)));
    preint
}

/// Root mean square of errors over expected deviations: position, rotation, velocity.
fn ratios(
    (with, without): (&[ImuSample], &[ImuSample]),
    length: usize,
    noise: ImuNoise,
    colour: NoiseColour,
) -> [f64; 3] {
    let config = PreintegrationConfig { colour, ..PreintegrationConfig::default() };
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for first in (0..with.len() - length).step_by(length) {
        let part = first..first + length + 1;
        let clean = integrated(config, &without[part.clone()], noise);
        let (truth, computed) = (clean.delta(), *integrated(config, &with[part], noise).delta());
        let turn = (computed.rotation.inverse() * truth.rotation).scaled_axis();
        let errors: [Vector3<f64>; 3] =
            [truth.position - computed.position, turn, truth.velocity - computed.velocity];
        for (k, error) in errors.iter().enumerate() {
            let variance = Vector3::from_fn(|axis, _| clean.covariance()[(3 * k + axis, 3 * k + axis)]);
            sums[k] += error.component_mul(error).component_div(&variance).sum() / 3.0;
        }
        count += 1.0;
    }
    sums.map(|sum| (sum / count).sqrt())
}

fn main() {
    for kind in [Flight::Hover, Flight::RoomMedium, Flight::HallFast] {
        let fly = |scale: f64| {
            let mut config = FlightConfig::default();
            config.vibration.scale = scale;
            simulate(kind, 1, &config).unwrap().recording
        };
        let (with, without) = (fly(1.0), fly(0.0));
        let (with, without) = (with.samples(), without.samples());
        let of = |sensor| noise(with, without, sensor);
        let (accel, gyro) = (of(Sensor::Accel), of(Sensor::Gyro));
        let told = |of: &dyn Fn(&[f64]) -> f64| {
            let by_axis = |noise: &Noise| std::array::from_fn(|axis| of(&noise[axis]));
            ImuNoise::from_values(by_axis(&accel), by_axis(&gyro)).unwrap()
        };
        let per_sample = told(&|axis| rms(axis.iter().copied()));
        let colour = NoiseColour { accel: lines(&accel), gyro: lines(&gyro) };
        println!(
            "\n{kind:?}: {per_sample:?}, effective {:?}, {}\n",
            told(&effective),
            serde_json::json!(colour)
        );
        println!(
            "| span | white, per sample | white, effective over 0.1 s | lines and white |\n|---|---|---|---|"
        );
        for length in [10, 20, 40, 100, 200] {
            let cell = |noise, colour| {
                ratios((with, without), length, noise, colour).map(|ratio| format!("{ratio:.2}")).join(", ")
            };
            println!(
                "| {:.2} s | {} | {} | {} |",
                length as f64 / 200.0,
                cell(per_sample, NoiseColour::default()),
                cell(told(&effective), NoiseColour::default()),
                cell(per_sample, colour)
            );
        }
    }
}
