//! Draws every figure from made-up data into a folder: `cargo run -p dpn-figures --example figures -- FOLDER`.

use dpn_core::Sensor;
use dpn_core::bounds::cramer_rao_sigma;
use dpn_eval::open_loop::{Errors, Row};
use dpn_figures::{Chart, Flight, Phase, Plot, flight_sigma, rmse_vs_sigma, save};
use dpn_train::label::Label;
use dpn_train::split::Side;
use std::error::Error;
use std::path::{Path, PathBuf};

/// A sum of twelve uniform numbers, nearly normal: a linear congruential generator will do for a picture.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Estimators of the picture: name, what the base leaves in their estimate, spread over that of the bound.
const ESTIMATORS: [(&str, f64, f64); 6] = [
    ("Accel/Gyro-ProNet", 0.10, 1.3),
    ("boosted trees", 0.13, 1.5),
    ("MAD of second differences", 0.18, 2.2),
    ("Allan deviation", 0.26, 1.8),
    ("sliding variance", 0.6, 1.4),
    ("elastic net", 0.2, 4.0),
];

fn estimate(truth: &[f64], scale: f64, (_, floor, spread): (&str, f64, f64), noise: &mut Noise) -> Vec<f64> {
    truth
        .iter()
        .map(|sigma| {
            let left = 0.4 * floor * scale * (1.0 + 0.5 * noise.normal()).abs();
            let total = (sigma * sigma + left * left).sqrt();
            (total + spread * cramer_rao_sigma(total, 200) * noise.normal()).max(0.0)
        })
        .collect()
}

fn truth(sensor: Sensor, continuous: bool, noise: &mut Noise) -> Vec<f64> {
    let (low, step, levels) = match sensor {
        Sensor::Accel => (0.01, 0.02, 11),
        Sensor::Gyro => (0.001, 0.002, 8),
    };
    (0..20_427)
        .map(|i| match continuous {
            true => low + step * f64::from(levels - 1) * noise.uniform(),
            false => low + step * f64::from(i % levels),
        })
        .collect()
}

fn scale(sensor: Sensor) -> f64 {
    match sensor {
        Sensor::Accel => 0.1,
        Sensor::Gyro => 0.006,
    }
}

fn rows() -> Vec<Row> {
    let mut noise = Noise(8);
    let mut rows = Vec::new();
    for sensor in Sensor::ALL {
        let truth = truth(sensor, false, &mut noise);
        let bins = if sensor == Sensor::Accel { 11 } else { 8 };
        for (i, estimator) in ESTIMATORS.into_iter().enumerate() {
            let guess = estimate(&truth, scale(sensor), estimator, &mut noise);
            let errors = Errors::of(&guess, &truth, &truth, bins, 200);
            rows.push(Row {
                sensor,
                base: "sg(5,2)".into(),
                data: "euroc".into(),
                split: Side::Test,
                estimator: estimator.0.into(),
                levels: "grid".into(),
                label: Label::Injected,
                rmse: errors.rmse,
                rmse_spread: (i < 2).then_some(0.03 * errors.rmse),
                bias: errors.bias,
                crb: errors.crb,
                ratio: errors.rmse / errors.crb,
                n: truth.len(),
                seeds: if i < 2 { 3 } else { 0 },
                outside: None,
                by_sigma: errors.by_sigma,
            });
        }
    }
    rows
}

fn flight(short_phases: bool) -> Result<Chart, Box<dyn Error>> {
    let mut noise = Noise(9);
    let t: Vec<f64> = (0..28_000).map(|i| f64::from(i) * 0.005).collect();
    let edges = if short_phases { [4.0, 7.0, 136.0] } else { [18.0, 36.0, 122.0] };
    let mut truth = Vec::new();
    let mut signal = Vec::new();
    for &t in &t {
        let (sigma, motion) = match t {
            t if t < edges[0] || t > edges[2] => (0.028, 0.0),
            t if t < edges[1] => (0.5, 0.0),
            _ => (0.9 + 0.3 * (t * 0.13).sin(), 1.0),
        };
        truth.push(sigma);
        signal.push(9.81 + motion * (0.8 * (0.7 * t).sin() + 0.5 * (1.9 * t).cos()) + sigma * noise.normal());
    }
    let held = |gain: f64, spread: f64, noise: &mut Noise| -> Vec<f64> {
        let mut now = 0.05;
        let mut out = Vec::new();
        for (i, sigma) in truth.iter().enumerate() {
            if i % 10 == 0 {
                now = 0.8 * now + 0.2 * gain * sigma * (1.0 + spread * noise.normal()).max(0.05);
            }
            out.push(if i < 200 { 0.08 } else { now });
        }
        out
    };
    let models = [
        ("Accel-ProNet", held(1.02, 0.15, &mut noise)),
        ("as the paper reads", held(0.35, 0.3, &mut noise)),
        ("MAD of second differences", held(1.3, 0.2, &mut noise)),
        ("constant x1", vec![0.08; t.len()]),
    ];
    let phase = |label: &str, from, to| Phase { label: label.into(), from, to };
    Ok(flight_sigma(&Flight {
        name: "made up",
        sensor: Sensor::Accel,
        axis: "z",
        t: &t,
        signal: &signal,
        models: models.iter().map(|(name, sigma)| (*name, sigma.as_slice())).collect(),
        truth: Some(&truth),
        phases: vec![
            phase("at rest", 0.0, edges[0]),
            phase("motors on", edges[0], edges[1]),
            phase("flying", edges[1], edges[2]),
            phase("at rest", edges[2], 140.0),
        ],
        trained_up_to: Some(0.21),
        words: "",
    })?)
}

fn keep(plot: &impl Plot, folder: &Path, name: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let paths = save(plot, folder.join(name))?;
    for path in &paths {
        println!("{} {} bytes", path.display(), std::fs::metadata(path.path())?.len());
    }
    Ok(paths.iter().map(|path| path.path().to_owned()).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err("usage: figures FOLDER".into());
    };
    let rows = rows();
    let all: Vec<&Row> = rows.iter().collect();
    keep(&rmse_vs_sigma(&all, 200)?, &folder, "rmse_vs_sigma")?;
    keep(&rmse_vs_sigma(&all[..2], 200)?, &folder, "rmse_vs_sigma_one_sensor")?;
    keep(&flight(false)?, &folder, "flight_sigma")?;
    keep(&flight(true)?, &folder, "flight_sigma_short_phases")?;
    Ok(())
}
