//! One training step (forward, backward, Adam, each way between host and device) on batches of windows of 200; beside
//! `golden/bench_pytorch/train_step.py`.
//!
//! Threads by `RAYON_NUM_THREADS`. Three architectures: 16/32/64, the same at stride 1, and the default accelerometer network's. The environment
//! may ask for others than all of them on a batch of 200 on the CPU:
//!
//! * `DPN_BENCH_NETS=kernel-41`, `DPN_BENCH_BATCHES=200,1000,5000`
//! * `DPN_BENCH_DEVICE=wgpu`, built with `--features wgpu`: steps as a training hands them to a card, which is named; `DPN_BENCH_NETWORKS=16` of them at once

use dpn_bench::{asked, iterations, time};
use dpn_core::random::Stream;
use dpn_pronet::config::Input;
use dpn_pronet::{Adam, AdamConfig, Device, ProNetConfig, Trainable, init::initial_parameters};
use rand::Rng;

fn main() {
    let strided = ProNetConfig::default();
    let dense = ProNetConfig { strides: vec![1, 1, 1], ..ProNetConfig::default() };
    let long = ProNetConfig {
        input: Input::SecondDifferences,
        channels: vec![32, 32, 64],
        kernels: vec![41, 5, 3],
        strides: vec![1, 4, 2],
        paddings: vec![20, 2, 1],
        hidden: vec![32, 32, 16],
        leak: 0.1,
        ..ProNetConfig::default()
    };
    let nets = [("strides-1-2-2", strided), ("strides-1-1-1", dense), ("kernel-41", long)];
    let (chosen, batches) = (asked("DPN_BENCH_NETS"), asked("DPN_BENCH_BATCHES"));
    let batches: Vec<usize> = match &batches {
        Some(sizes) => sizes.iter().map(|size| size.parse().expect("a number of windows")).collect(),
        None => vec![200],
    };
    let device = asked("DPN_BENCH_DEVICE").map_or_else(|| "cpu".to_owned(), |names| names.concat());
    for (name, config) in &nets {
        if chosen.as_ref().is_some_and(|chosen| !chosen.iter().any(|net| net == name)) {
            continue;
        }
        for &batch in &batches {
            let name = format!("{name}, {batch} windows");
            match device.as_str() {
                "cpu" => step(&name, config, batch),
                #[cfg(feature = "wgpu")]
                "wgpu" => card::step(&name, config, batch),
                _ => panic!("this bench was built without the device `{device}`"),
            }
        }
    }
}

fn step(name: &str, config: &ProNetConfig, batch: usize) {
    let stream = Stream::new(1).named("bench");
    let network = Trainable::new(config, &Device::Cpu).expect("its keys go together");
    let mut rng = stream.named("windows").rng();
    let windows: Vec<f32> = (0..batch * config.window).map(|_| 0.2 * (rng.random::<f32>() - 0.5)).collect();
    let mut parameters = initial_parameters(config, &stream);
    let mut adam = Adam::new(AdamConfig::default(), parameters.len());
    let timing = time(iterations(40), || {
        // Of the mean of (10 (sigma - 0.1))^2.
        let (_, gradient) = network.gradient(&parameters, &windows, |sigma| {
            (0.0, sigma.iter().map(|sigma| (sigma - 0.1) * 200.0 / batch as f32).collect())
        });
        adam.step(&mut parameters, &gradient, 1e-3);
    });
    println!("train_step {name}: median {:.2} ms, cpu {:.2} ms", timing.wall_ms, timing.cpu_ms);
}

#[cfg(feature = "wgpu")]
mod card {
    use dpn_bench::{asked, iterations, time};
    use dpn_core::random::Stream;
    use dpn_gpu::{Examples, Gpu, LevelDraw, Loss, Source, State, Step, Training, Turns};
    use dpn_pronet::{AdamConfig, ProNetConfig, init::initial_parameters};
    use std::sync::Arc;

    /// Steps that are handed over at a time.
    const STEPS: usize = 32;

    pub(super) fn step(name: &str, config: &ProNetConfig, batch: usize) {
        let gpu = Gpu::open().expect("a card");
        let networks: usize =
            asked("DPN_BENCH_NETWORKS").map_or(1, |n| n.concat().parse().expect("a number"));
        let trainings: Vec<Training> = (0..networks)
            .map(|_| Training::new(&gpu, config, Loss::Mse, AdamConfig::default(), 1.0))
            .collect();
        let state = State::new(initial_parameters(config, &Stream::new(1).named("bench")));
        let turns = Turns { offset: true, sign: true, reverse: true, grow_share: 0.0, factors: [1.0; 2] };
        let identity: Vec<f64> =
            (0..config.window.pow(2)).map(|i| f64::from(u8::from(i % (config.window + 1) == 0))).collect();
        let samples = (0..2000).map(|i| (i as f32 * 0.1).sin()).collect();
        let levels = (LevelDraw::Uniform, [0.01, 0.2]);
        let source =
            Arc::new(Source::new(config.window, samples, vec![[0, 199]], &[identity], levels, turns));
        let rate = (1..=STEPS as u64).map(|number| Step { number, rate: 1e-3, keep: 0.9 });
        let steps: Vec<Step> = rate.collect();
        let timing = time(iterations(4), || {
            std::thread::scope(|scope| {
                for training in &trainings {
                    let (mut state, steps, source) = (state.clone(), &steps, Arc::clone(&source));
                    scope.spawn(move || {
                        let rows = (0..(STEPS * batch) as u32).map(|i| [0, i % 65_536]).collect();
                        let examples = Examples::Drawn { source, rows, key: [1, 2] };
                        training.steps(&mut state, examples, batch, steps).expect("the card computes")
                    });
                }
            });
        });
        println!(
            "train_step {name} on {}: {networks} networks at once, median {:.3} ms a step",
            gpu.adapter(),
            timing.wall_ms / STEPS as f64
        );
    }
}
