//! One training step (forward, backward, Adam) on a batch of 200 windows of 200; beside `golden/bench_pytorch/train_step.py`.
//!
//! Threads by `RAYON_NUM_THREADS`. Three architectures: the default, the same at stride 1, and a long first kernel on second differences.

use burn::tensor::{Device, Tensor, TensorData};
use dpn_bench::{iterations, time};
use dpn_core::random::Stream;
use dpn_pronet::config::Input;
use dpn_pronet::{Adam, AdamConfig, ProNet, ProNetConfig};
use rand::Rng;

const BATCH: usize = 200;

fn main() {
    let strided = ProNetConfig::default();
    let dense = ProNetConfig { strides: vec![1, 1, 1], ..ProNetConfig::default() };
    let long = ProNetConfig {
        input: Input::SecondDifferences,
        channels: vec![32, 32, 64],
        kernels: vec![41, 5, 3],
        strides: vec![1, 4, 2],
        paddings: vec![21, 2, 1],
        hidden: vec![32, 32, 16],
        leak: 0.1,
        ..ProNetConfig::default()
    };
    for (name, config) in [("strides-1-2-2", strided), ("strides-1-1-1", dense), ("kernel-41", long)] {
        step(name, &config, true);
        if std::env::var_os("DPN_BENCH_PLAIN").is_some() {
            step(&format!("{name} plain"), &config, false);
        }
    }
}

fn step(name: &str, config: &ProNetConfig, fused: bool) {
    let device = Device::flex().autodiff();
    let stream = Stream::new(1).named("bench");
    let mut net = match ProNet::new(config, &stream, &device) {
        Ok(net) => net,
        Err(error) => panic!("{error}"),
    };
    let mut rng = stream.named("windows").rng();
    let windows: Vec<f32> = (0..BATCH * config.window).map(|_| 0.2 * (rng.random::<f32>() - 0.5)).collect();
    let mut parameters = net.parameters();
    let mut adam = Adam::new(AdamConfig::default(), parameters.len());
    let timing = time(iterations(40), || {
        let x = Tensor::<2>::from_data(TensorData::new(windows.clone(), [BATCH, config.window]), &device);
        let sigma = if fused { net.forward(x) } else { net.forward_plain(x) };
        let loss = ((sigma - 0.1) * 10.0).square().mean();
        let gradient = net.flat_gradient(&loss.backward());
        adam.step(&mut parameters, &gradient, 1e-3);
        net = net.with_parameters(&parameters);
    });
    println!("train_step {name}: median {:.2} ms, cpu {:.2} ms", timing.wall_ms, timing.cpu_ms);
}
