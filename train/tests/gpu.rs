//! A GPU through wgpu learns what the processor does. Not part of the default build: it needs a Vulkan driver, Mesa's lavapipe at least.
//! `cargo test -p dpn-train --features wgpu gpu -- --nocapture` prints the time of a step as well.

use super::resume::{StopAfter, config as small, corpus};
use dpn_core::Sensor;
use dpn_core::progress::Silent;
use dpn_gpu::Gpu;
use dpn_train::Device;
use dpn_train::config::TrainConfig;
use dpn_train::label::Label;
use dpn_train::run::{Run, RunError, RunSummary, history};
use dpn_train::trainer::{TrainError, Trainer};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Updates that are compared.
const STEPS: u64 = 10;

fn gpu() -> Device {
    Device::Gpu(Gpu::open().unwrap())
}

/// The default network of `sensor`, and batches so large that an epoch has `STEPS` updates. Of this label the processor draws the examples: both learn from the same.
fn config(sensor: Sensor) -> TrainConfig {
    let mut config = TrainConfig::for_sensor(sensor);
    config.noise.label = Label::Total;
    config.fit.epochs = 2;
    config.fit.batch = 100;
    config.fit.draws_per_window = 20;
    config.fit.validate_every = 2;
    config
}

/// Weights before and after `STEPS` updates on `device`, and the mean time of a step \[s\].
fn trained(sensor: Sensor, device: &Device) -> (Vec<f32>, Vec<f32>, f64) {
    let trainer = Trainer::new(&config(sensor), &corpus(), device).unwrap();
    let mut state = trainer.start();
    let before = state.weights.clone();
    let from = Instant::now();
    trainer.epoch(&mut state, &AtomicBool::new(false), &mut |_, _| {}).unwrap();
    assert_eq!(state.adam.steps(), STEPS);
    (before, state.weights, from.elapsed().as_secs_f64() / STEPS as f64)
}

fn length(values: impl Iterator<Item = f32>) -> f64 {
    values.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn weights_after_ten_steps_are_the_processors() {
    for sensor in Sensor::ALL {
        let (before, cpu, cpu_s) = trained(sensor, &Device::Cpu);
        let (_, gpu, gpu_s) = trained(sensor, &gpu());
        let apart = length(gpu.iter().zip(&cpu).map(|(a, b)| a - b));
        let (whole, moved) =
            (length(cpu.iter().copied()), length(cpu.iter().zip(&before).map(|(a, b)| a - b)));
        println!(
            "{sensor}: {:.1e} of the weights, {:.1e} of what {STEPS} steps moved them; a step {:.1} ms, on the CPU {:.1} ms",
            apart / whole,
            apart / moved,
            1e3 * gpu_s,
            1e3 * cpu_s
        );
        assert!(moved > 0.01 * whole, "{sensor}: the weights hardly moved");
        assert!(apart < 1e-3 * whole, "{sensor}: {} of the weights", apart / whole);
    }
}

/// Runs of several lots an epoch would take long on a software driver: with so few windows an epoch is one.
fn run(dir: &Path, config: &TrainConfig, device: &Device, stop: Option<u64>) -> Result<RunSummary, RunError> {
    let corpus = corpus();
    let flag = AtomicBool::new(false);
    let resume = dir.join("checkpoint.safetensors").is_file();
    let run = Run::open(dir, config, &corpus, device, resume)?;
    match stop {
        Some(after) => run.train(&flag, &mut StopAfter(after, &flag)),
        None => run.train(&flag, &mut Silent),
    }
    .map(|(summary, _)| summary)
}

#[test]
fn a_run_that_stopped_on_a_card_goes_on_there_to_the_same_bits_and_on_the_processor_too() {
    let dirs = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let [whole, there, here] = [0, 1, 2].map(|i: usize| dirs[i].path());
    let gpu = gpu();
    run(whole, &small(), &gpu, None).unwrap();
    for dir in [there, here] {
        let stopped = run(dir, &small(), &gpu, Some(6));
        assert!(matches!(stopped, Err(RunError::Train(TrainError::Stopped { epoch: 3 }))), "{stopped:?}");
    }
    run(there, &small(), &gpu, None).unwrap();
    let bytes = |dir: &Path| std::fs::read(dir.join("accel.safetensors")).unwrap();
    assert!(bytes(whole) == bytes(there));
    let summary = run(here, &small(), &Device::Cpu, None).unwrap();
    assert_eq!(history(&here.into()).unwrap().len(), 4);
    assert!(summary.validation_rmse.is_finite());
}

/// What the card draws is not what the processor draws, but it is as hard to tell: the losses of an epoch are.
#[test]
fn examples_that_the_card_draws_teach_what_the_processors_do() {
    let mut config = small();
    config.fit.draws_per_window = 20;
    config.fit.epochs = 6;
    let loss = |device: &Device| {
        let dir = tempfile::tempdir().unwrap();
        let summary = run(dir.path(), &config, device, None).unwrap();
        let all = history(&dir.path().into()).unwrap();
        (all[0].loss, all[5].loss, summary.validation_rmse)
    };
    let (card, processor) = (loss(&gpu()), loss(&Device::Cpu));
    println!("card {card:?}, processor {processor:?}");
    for (a, b) in [(card.0, processor.0), (card.1, processor.1), (card.2, processor.2)] {
        assert!((a / b - 1.0).abs() < 0.15, "{card:?} {processor:?}");
    }
    assert!(card.1 < 0.5 * card.0, "nothing was learned: {card:?}");
}

#[test]
fn networks_that_go_together_are_those_that_go_alone() {
    let of = |seed| TrainConfig { seed, ..small() };
    let alone = [1, 2].map(|seed| {
        let dir = tempfile::tempdir().unwrap();
        run(dir.path(), &of(seed), &gpu(), None).unwrap()
    });
    let together: Vec<RunSummary> = std::thread::scope(|scope| {
        let both = [1, 2].map(|seed| {
            scope.spawn(move || {
                let dir = tempfile::tempdir().unwrap();
                run(dir.path(), &of(seed), &gpu(), None).unwrap()
            })
        });
        both.into_iter().map(|one| one.join().unwrap()).collect()
    });
    assert_eq!(alone.to_vec(), together);
    assert!(alone[0].validation_rmse != alone[1].validation_rmse);
}
