//! How well a second of one axis says `sigma_eff`, on the validation examples that a network's training was judged on: the network, `effective(T)`, the
//! samples' own roughness, and the label's own scatter, as the Markdown table of the book.
//!
//! `cargo run --release -p dpn-eval --example judge_effective -- CONFIG WEIGHTS DATA`, for example `configs/train/accel-effective.toml
//! models/accel/effective-s0.safetensors data`.
#![allow(clippy::unwrap_used)]

use dpn_core::estimate::{Effective, EffectiveStream};
use dpn_core::random::Stream;
use dpn_core::{SampleRate, Sensor};
use dpn_pronet::Weights;
use dpn_pronet::range::WindowFigures;
use dpn_train::calibration::Calibration;
use dpn_train::draw::inject;
use dpn_train::trainer::{Trainer, cpu, predict_with_spread};
use dpn_train::windows::WINDOW;
use std::path::Path;
use std::sync::Arc;

/// Root mean square of the logarithm of `said` over `truth`, and its mean.
fn log_error(said: &[f64], truth: &[f64], rows: &[usize]) -> (f64, f64) {
    let errors: Vec<f64> = rows.iter().map(|&row| (said[row] / truth[row]).ln()).collect();
    let n = errors.len() as f64;
    ((errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(), errors.iter().sum::<f64>() / n)
}

/// The scatter of the label: how far the sums over a span of one window are from their expectation, for white noise.
fn scatter(span: usize) -> f64 {
    let found = |index: u64| {
        let mut window = [0.0; WINDOW];
        inject(&mut window, 1.0, &mut Stream::new(1).named("scatter").index(index).rng());
        let sums = window.chunks_exact(span).map(|part| part.iter().sum::<f64>().powi(2) / span as f64);
        (sums.sum::<f64>() / (WINDOW / span) as f64).sqrt()
    };
    let said: Vec<f64> = (0..4000).map(found).collect();
    log_error(&said, &vec![1.0; said.len()], &(0..said.len()).collect::<Vec<_>>()).0
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let weights = Weights::load(&args[2]).unwrap();
    let config = dpn_train::config::load(Path::new(&args[1]), Sensor::Accel).unwrap();
    let corpora = dpn_train::asl::load(Path::new(&args[3])).unwrap();
    let trainer = Trainer::new(&config, &dpn_train::corpus::to_train(corpora).unwrap(), &cpu()).unwrap();
    let (examples, truth) = trainer.validation();
    let span = config.noise.span();
    let effective = Arc::new(Effective::sum(span as f64 / 200.0, SampleRate::HZ_200).unwrap());
    let each = |answer: &mut dyn FnMut(&[f64]) -> f64| -> Vec<f64> {
        (0..examples.len()).map(|row| answer(examples.row(row))).collect()
    };
    // No window follows another here: each is asked without a memory.
    let plain = each(&mut |window| EffectiveStream::new(Arc::clone(&effective)).sigma(window));
    let rough = each(&mut |window| {
        WindowFigures::of(&window.iter().map(|v| *v as f32).collect::<Vec<_>>()).roughness
    });
    let (said, spread) = predict_with_spread(&weights, &examples.samples);
    let spread = spread.unwrap();
    let pick = |wanted: &dyn Fn(usize) -> bool| (0..examples.len()).filter(|&row| wanted(row)).collect();
    let share = |row: usize| examples.vibration[row] / truth[row];
    let parts: [(&str, Vec<usize>); 4] = [
        ("all", pick(&|_| true)),
        ("white noise alone", pick(&|row| examples.vibration[row] == 0.0)),
        ("vibration, the lesser part", pick(&|row| share(row) > 0.0 && share(row) < 0.7)),
        ("vibration, the greater part", pick(&|row| share(row) >= 0.7)),
    ];
    println!(
        "| {} | windows | network | `effective` | second differences | rms z, within one |",
        config.sensor()
    );
    println!("|---|---|---|---|---|---|");
    for (name, rows) in parts {
        let of = |said: &[f64]| {
            let (rms, mean) = log_error(said, truth, &rows);
            format!("{rms:.3} ({mean:+.2})")
        };
        let at = |x: &[f64]| rows.iter().map(|&row| x[row]).collect::<Vec<f64>>();
        let z = Calibration::of(&at(&said), &at(&spread), &at(truth));
        let (network, plain, rough) = (of(&said), of(&plain), of(&rough));
        let (rms, one) = (z.rms_z, 100.0 * z.within_one);
        println!("| {name} | {} | {network} | {plain} | {rough} | {rms:.2}, {one:.0} % |", rows.len());
    }
    println!(
        "\nThe label's own scatter, sums over {span} samples of white noise in one window: {:.3}",
        scatter(span)
    );
}
