//! A GPU through wgpu computes what the CPU does. Not part of the default build: it needs a Vulkan driver, Mesa's lavapipe at least.
//! `cargo test -p dpn-train --features wgpu gpu -- --nocapture` prints the time of a step as well.

use super::resume::corpus;
use dpn_core::Sensor;
use dpn_pronet::Device;
use dpn_train::config::TrainConfig;
use dpn_train::trainer::Trainer;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Updates that are compared.
const STEPS: u64 = 10;

/// The default network of `sensor`, and batches so large that an epoch has `STEPS` updates.
fn config(sensor: Sensor) -> TrainConfig {
    let mut config = TrainConfig::for_sensor(sensor);
    config.fit.epochs = 2;
    config.fit.batch = 100;
    config.fit.draws_per_window = 20;
    config.fit.validate_every = 2;
    config
}

/// Weights before and after `STEPS` updates on `device`, and the median time of a step \[s\].
fn trained(sensor: Sensor, device: &Device) -> (Vec<f32>, Vec<f32>, f64) {
    let trainer = Trainer::new(&config(sensor), &corpus(), device).unwrap();
    let mut state = trainer.start();
    let before = state.weights.clone();
    let mut ends = vec![Instant::now()];
    trainer.epoch(&mut state, &AtomicBool::new(false), &mut |_, _| ends.push(Instant::now())).unwrap();
    assert_eq!(state.adam.steps(), STEPS);
    let mut steps: Vec<f64> = ends.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64()).collect();
    steps.sort_by(f64::total_cmp);
    (before, state.weights, steps[steps.len() / 2])
}

fn length(values: impl Iterator<Item = f32>) -> f64 {
    values.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn weights_after_ten_steps_are_the_processors() {
    for sensor in Sensor::ALL {
        let (before, cpu, cpu_s) = trained(sensor, &Device::Cpu);
        let (_, gpu, gpu_s) = trained(sensor, &Device::named("wgpu").unwrap());
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
