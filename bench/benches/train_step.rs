//! One training step (forward, backward, Adam, each way between host and device) on batches of windows of 200; beside
//! `golden/bench_pytorch/train_step.py`.
//!
//! Threads by `RAYON_NUM_THREADS`. Three architectures: 16/32/64, the same at stride 1, and the default accelerometer network's. The environment
//! may ask for others than all of them on a batch of 200 on the CPU:
//!
//! * `DPN_BENCH_NETS=kernel-41`, `DPN_BENCH_BATCHES=200,1000,5000`
//! * `DPN_BENCH_DEVICE=wgpu`, built with `--features wgpu`; the adapter is named, and whether it is a card or software

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
    let device = device();
    for (name, config) in &nets {
        if chosen.as_ref().is_some_and(|chosen| !chosen.iter().any(|net| net == name)) {
            continue;
        }
        for &batch in &batches {
            step(&format!("{name}, {batch} windows"), config, batch, &device);
        }
    }
}

/// Where to compute.
fn device() -> Device {
    let name = asked("DPN_BENCH_DEVICE").map_or_else(|| "cpu".to_owned(), |names| names.concat());
    let device =
        Device::named(&name).unwrap_or_else(|| panic!("this bench was built without the device `{name}`"));
    #[cfg(feature = "wgpu")]
    if let Device::Burn(device) = &device {
        let identity = device.identity().expect("wgpu knows its adapter");
        let kind = if identity.physical.is_some() { "a card" } else { "software" };
        println!("train_step on {} ({kind}, {})", identity.name, identity.fingerprint);
    }
    device
}

fn step(name: &str, config: &ProNetConfig, batch: usize, device: &Device) {
    let stream = Stream::new(1).named("bench");
    let network = Trainable::new(config, device).expect("its keys go together");
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
