//! Weights that dpn wrote, loaded by PyTorch, must give PyTorch's deviations and gradients (`golden/pronet_pytorch/make.py`).

#![allow(clippy::unwrap_used)]

use dpn_core::random::Stream;
use dpn_pronet::adam::{Adam, AdamConfig};
use dpn_pronet::config::{Input, Pool, ProNetConfig};
use dpn_pronet::init::initial_parameters;
use dpn_pronet::shape::parameters;
use dpn_pronet::{Card, Device, Predictor, Trainable, Weights};
use rand::Rng;
use serde_json::Value;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../golden/pronet_pytorch")
}

/// The three networks whose files are committed: small, and between them every choice that changes a shape.
fn networks() -> [(&'static str, ProNetConfig); 3] {
    let base = ProNetConfig {
        window: 40,
        channels: vec![3, 4, 5],
        kernels: vec![5, 3, 3],
        strides: vec![1, 2, 2],
        paddings: vec![2, 1, 1],
        hidden: vec![6, 5, 4],
        leak: 0.1,
        ..ProNetConfig::default()
    };
    let wide = ProNetConfig {
        input: Input::SecondDifferences,
        pool: Pool::MeanAndRms,
        conv_bias: false,
        channels: vec![4, 18],
        kernels: vec![7, 4],
        strides: vec![2, 3],
        paddings: vec![6, 0],
        hidden: vec![],
        ..base.clone()
    };
    // Some samples of the second block are seen by no tap.
    let strided = ProNetConfig { input: Input::Raw, strides: vec![3, 4, 1], ..base.clone() };
    [("base", base), ("wide", wide), ("strided", strided)]
}

fn weights(name: &str, config: &ProNetConfig) -> Weights {
    let stream = Stream::new(1).named("golden").named(name);
    let mut rng = stream.named("jitter").rng();
    // Gains and offsets away from one and zero.
    let flat =
        initial_parameters(config, &stream).iter().map(|p| p + 0.4 * (rng.random::<f32>() - 0.5)).collect();
    Weights::new(config, flat, Card::default())
}

#[test]
#[ignore = "writes the committed weight files; run it when the file format changes, then make.py"]
fn write_the_weight_files() {
    for (name, config) in networks() {
        let bytes = weights(name, &config).to_bytes().unwrap();
        std::fs::write(folder().join(format!("{name}.safetensors")), bytes).unwrap();
    }
}

#[test]
fn the_committed_weight_files_are_what_dpn_writes_today() {
    for (name, config) in networks() {
        let committed = std::fs::read(folder().join(format!("{name}.safetensors"))).unwrap();
        assert_eq!(committed, weights(name, &config).to_bytes().unwrap(), "{name}");
    }
}

fn expected() -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("expected.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// The network of one case: a committed file's numbers under a changed configuration.
fn network(case: &Value) -> (ProNetConfig, Vec<f32>) {
    let loaded = Weights::load(folder().join(case["file"].as_str().unwrap())).unwrap();
    let mut config = serde_json::to_value(loaded.config()).unwrap();
    for (key, value) in case["changes"].as_object().unwrap() {
        config[key] = value.clone();
    }
    let config: ProNetConfig = serde_json::from_value(config).unwrap();
    let there = parameters(loaded.config());
    let flat = parameters(&config)
        .iter()
        .flat_map(|p| {
            let from = there.iter().find(|q| q.name == p.name).unwrap();
            loaded.parameters()[from.offset..from.offset + from.len()].to_vec()
        })
        .collect();
    (config, flat)
}

/// The kernels, and with burn the composition in its primitives.
fn devices() -> Vec<(&'static str, Device)> {
    #[cfg_attr(not(feature = "burn"), expect(unused_mut, reason = "one way alone"))]
    let mut devices = vec![("kernels", Device::Cpu)];
    #[cfg(feature = "burn")]
    devices.push(("plain", Device::Burn(burn::tensor::Device::flex().autodiff())));
    devices
}

/// Asserts agreement to `tolerance` of the largest number.
fn agree(ours: &[f32], theirs: &[f64], tolerance: f64, what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let largest = theirs.iter().fold(0f64, |m, v| m.max(v.abs()));
    assert!(largest > 0.0, "{what}: nothing to compare");
    for (a, b) in ours.iter().zip(theirs) {
        assert!((f64::from(*a) - b).abs() <= tolerance * largest, "{what}: {a} is not {b}");
    }
}

#[test]
fn deviations_are_pytorchs_for_every_order_axes_and_head() {
    let expected = expected();
    let mut seen = 0;
    for case in expected["cases"].as_array().unwrap() {
        let (config, flat) = network(case);
        let rows = expected["windows"][case["windows"].as_u64().unwrap() as usize].as_array().unwrap();
        let windows: Vec<f32> = rows.iter().flat_map(numbers).map(|v| v as f32).collect();
        let sigma = numbers(&case["sigma"]);
        let what = format!("{} {}", case["file"], case["changes"]);
        for (way, device) in devices() {
            let mut ours = Vec::new();
            Trainable::new(&config, &device).unwrap().gradient(&flat, &windows, |sigma| {
                ours = sigma.to_vec();
                (0.0, vec![0.0; sigma.len()])
            });
            agree(&ours, &sigma, 1e-5, &format!("{way} {what}"));
        }
        let mut streamed = vec![0.0; rows.len()];
        Predictor::new(&Weights::new(&config, flat, Card::default())).predict(&windows, &mut streamed);
        agree(&streamed, &sigma, 1e-5, &format!("predictor {what}"));
        seen += 1;
    }
    assert_eq!(seen, 2 * 2 * 3 + 2 + 2);
}

#[test]
fn loss_gradients_are_pytorchs_for_every_parameter() {
    let expected = expected();
    let mut seen = 0;
    for case in expected["cases"].as_array().unwrap() {
        let Some(gradient) = case["gradient"].as_object() else {
            continue;
        };
        let (config, flat) = network(case);
        let rows = expected["windows"][case["windows"].as_u64().unwrap() as usize].as_array().unwrap();
        let windows: Vec<f32> = rows.iter().flat_map(numbers).map(|v| v as f32).collect();
        let theirs: Vec<f64> = parameters(&config).iter().flat_map(|p| numbers(&gradient[&p.name])).collect();
        let count = rows.len() as f32;
        for (way, device) in devices() {
            let (_, ours) = Trainable::new(&config, &device).unwrap().gradient(&flat, &windows, |sigma| {
                // Of the mean of (10 (sigma - 0.1))^2.
                (0.0, sigma.iter().map(|sigma| (sigma - 0.1) * 200.0 / count).collect())
            });
            agree(&ours, &theirs, 2e-5, &format!("{way} {} {}", case["file"], case["changes"]));
        }
        seen += 1;
    }
    assert_eq!(seen, 2 * 2 + 2);
}

#[test]
fn adam_is_pytorchs_with_and_without_decoupled_decay() {
    let expected = expected();
    for case in expected["adam"].as_array().unwrap() {
        let config =
            AdamConfig { weight_decay: case["weight_decay"].as_f64().unwrap(), ..AdamConfig::default() };
        let mut p: Vec<f32> = numbers(&case["start"]).iter().map(|v| *v as f32).collect();
        let mut adam = Adam::new(config, p.len());
        let (gradients, after) = (case["gradients"].as_array().unwrap(), case["after"].as_array().unwrap());
        for (gradient, after) in gradients.iter().zip(after) {
            let gradient: Vec<f32> = numbers(gradient).iter().map(|v| *v as f32).collect();
            adam.step(&mut p, &gradient, 0.01);
            agree(&p, &numbers(after), 1e-6, "adam");
        }
        assert_eq!(adam.steps(), 5);
    }
}
