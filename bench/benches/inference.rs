//! Six windows through both networks (three axes each), on one thread.

use dpn_bench::{iterations, time};
use dpn_core::Sensor;
use dpn_core::random::Stream;
use dpn_pronet::config::Input;
use dpn_pronet::init::initial_parameters;
use dpn_pronet::{Card, Predictor, ProNetConfig, Weights};
use rand::Rng;

fn main() {
    let default = ProNetConfig::default();
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
    for (name, config) in [("strides-1-2-2", default), ("kernel-41", long)] {
        six(name, &config);
    }
}

fn six(name: &str, config: &ProNetConfig) {
    let stream = Stream::new(1).named("bench");
    let mut networks = Sensor::ALL.map(|sensor| {
        let config = ProNetConfig { sensor, ..config.clone() };
        let flat = initial_parameters(&config, &stream.named(sensor.name()));
        let mut rng = stream.named("windows").rng();
        let windows: Vec<f32> = (0..3 * config.window).map(|_| rng.random::<f32>() - 0.5).collect();
        (Predictor::new(&Weights::new(&config, flat, Card::default())), windows)
    });
    let mut sigma = [0.0; 3];
    let timing = time(iterations(2000), || {
        for (network, windows) in &mut networks {
            network.predict(windows, &mut sigma);
            std::hint::black_box(&sigma);
        }
    });
    dpn_bench::keep(&format!("inference {name}"), timing.wall_ms);
    println!("inference {name}: six windows, median {:.4} ms, cpu {:.4} ms", timing.wall_ms, timing.cpu_ms);
}
