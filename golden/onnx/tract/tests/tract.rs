//! tract, a runtime in Rust, against ours: on every choice of the configuration, and on shipped networks and some of the study.
#![allow(clippy::unwrap_used)]

#[path = "../../../../src/onnx/tests/windows.rs"]
mod windows;

use dpn_core::Sensor;
use dpn_core::random::Stream;
use dpn_onnx::{Convolution, Convolutions};
use dpn_pronet::config::{BlockOrder, Head, Input, NormAxes, Pool, ProNetConfig};
use dpn_pronet::init::initial_parameters;
use dpn_pronet::{Card, Predictor, Weights};
use dpn_testing::repository;
use rand::Rng;
use std::io::Cursor;
use tract_onnx::prelude::*;
use windows::{real, same};

/// The deviations that tract makes of the model of these weights.
fn tract(weights: &Weights, windows: &[f32]) -> Vec<f32> {
    outputs(weights, windows).swap_remove(0)
}

/// Everything that it makes of it.
fn outputs(weights: &Weights, windows: &[f32]) -> Vec<Vec<f32>> {
    let bytes = dpn_onnx::to_bytes(weights).unwrap();
    let window = weights.config().window;
    let shape = [windows.len() / window, window];
    let model = tract_onnx::onnx().model_for_read(&mut Cursor::new(bytes)).unwrap();
    let model = model.with_input_fact(0, f32::fact(shape).into()).unwrap();
    let input = Tensor::from_shape(&shape, windows).unwrap();
    let outputs = model.into_optimized().unwrap().into_runnable().unwrap().run(tvec!(input.into())).unwrap();
    outputs.iter().map(|o| o.to_plain_array_view::<f32>().unwrap().iter().copied().collect()).collect()
}

fn ours(weights: &Weights, windows: &[f32]) -> Vec<f32> {
    let mut sigma = vec![0.0; windows.len() / weights.config().window];
    Predictor::new(weights).predict(windows, &mut sigma);
    sigma
}

#[test]
fn shipped_networks_say_the_same() {
    for (sensor, names) in [
        (Sensor::Accel, ["sg11-s0", "wide-s0", "paper-s0", "raw-s0"]),
        (Sensor::Gyro, ["sg51-s1", "wide-s0", "paper-s1", "total-s0"]),
    ] {
        let windows = real(sensor, 200);
        for name in names {
            let path = ["models", "papers/networks"]
                .map(|folder| repository().join(format!("{folder}/{sensor}/{name}.safetensors")))
                .into_iter()
                .find(|path| path.is_file());
            let weights = Weights::load(path.unwrap()).unwrap();
            same(&tract(&weights, &windows), &ours(&weights, &windows), &format!("{sensor} {name}"));
        }
    }
}

#[test]
fn how_sure_a_network_is_comes_out_second() {
    for sensor in Sensor::ALL {
        let windows = real(sensor, 200);
        let path = repository().join(format!("models/{sensor}/effective-s0.safetensors"));
        let weights = Weights::load(&path).unwrap();
        let theirs = outputs(&weights, &windows);
        let [mut sigma, mut spread] = [(); 2].map(|()| vec![0.0; windows.len() / 200]);
        Predictor::new(&weights).predict_with_spread(&windows, &mut sigma, &mut spread);
        assert_eq!(theirs.len(), 2);
        same(&theirs[0], &sigma, &format!("{sensor} sigma"));
        same(&theirs[1], &spread, &format!("{sensor} spread"));
    }
}

#[test]
fn every_choice_says_the_same() {
    let base = ProNetConfig {
        window: 40,
        channels: vec![3, 5],
        kernels: vec![5, 4],
        strides: vec![1, 3],
        paddings: vec![2, 0],
        hidden: vec![6],
        ..ProNetConfig::for_sensor(Sensor::Gyro)
    };
    let mut configs = vec![base.clone()];
    configs.extend(Input::ALL.map(|input| ProNetConfig { input, ..base.clone() }));
    configs.extend(NormAxes::ALL.map(|norm_axes| ProNetConfig { norm_axes, ..base.clone() }));
    configs.extend(Head::ALL.map(|head| ProNetConfig { head, ..base.clone() }));
    configs.extend(Pool::ALL.map(|pool| ProNetConfig {
        pool,
        conv_bias: false,
        hidden: vec![],
        ..base.clone()
    }));
    configs.extend(BlockOrder::ALL.map(|block_order| ProNetConfig {
        block_order,
        leak: 0.2,
        ..base.clone()
    }));
    let windows = real(Sensor::Gyro, 40);
    for config in configs {
        let flat = initial_parameters(&config, &Stream::new(3).named("onnx"));
        let weights = Weights::new(&config, flat, Card::default());
        same(&tract(&weights, &windows), &ours(&weights, &windows), &format!("{config:?}"));
    }
}

#[test]
fn a_stack_of_convolutions_says_what_its_definition_does() {
    let mut rng = Stream::new(5).named("convolutions").rng();
    let mut some = |count: usize| (0..count).map(|_| rng.random_range(-0.5..0.5f32)).collect::<Vec<_>>();
    let mut layer = |inputs: usize, outputs: usize, taps: usize, stride, dilation| Convolution {
        weights: some(outputs * inputs * taps),
        bias: some(outputs),
        inputs,
        stride,
        dilation,
    };
    let stack = Convolutions {
        layers: vec![layer(6, 4, 5, 3, 1), layer(4, 5, 3, 1, 2), layer(5, 3, 1, 1, 1)],
        samples: 17,
        mean: vec![0.1, -0.2, 0.3, 0.0, 9.8, 0.5],
        deviation: vec![0.5, 0.6, 0.7, 1.0, 2.0, 3.0],
        activation: 1.702,
        unit: 0.01,
        offset: vec![0.001, 0.002, -0.003],
        summary: String::new(),
        metadata: [("usage".to_owned(), "none".to_owned())].into(),
    };
    let window = some(6 * 17);
    let model = tract_onnx::onnx().model_for_read(&mut Cursor::new(stack.to_bytes())).unwrap();
    let model = model.with_input_fact(0, f32::fact([1, 6, 17]).into()).unwrap();
    let input = Tensor::from_shape(&[1, 6, 17], &window).unwrap();
    let outputs = model.into_optimized().unwrap().into_runnable().unwrap().run(tvec!(input.into())).unwrap();
    let theirs: Vec<f32> = outputs[0].to_plain_array_view::<f32>().unwrap().iter().copied().collect();

    let seen = |t: usize, axis: usize| (window[axis * 17 + t] - stack.mean[axis]) / stack.deviation[axis];
    let mut x: Vec<Vec<f32>> = (0..17).map(|t| (0..6).map(|axis| seen(t, axis)).collect()).collect();
    for (number, layer) in stack.layers.iter().enumerate() {
        let taps = layer.weights.len() / (layer.inputs * layer.bias.len());
        let answers = (x.len() - (taps - 1) * layer.dilation - 1) / layer.stride + 1;
        let sum = |t: usize, o: usize| -> f32 {
            let of = |i: usize, tap: usize| {
                layer.weights[(o * layer.inputs + i) * taps + tap] * x[t * layer.stride + tap * layer.dilation][i]
            };
            layer.bias[o] + (0..layer.inputs).map(|i| (0..taps).map(|tap| of(i, tap)).sum::<f32>()).sum::<f32>()
        };
        let out = |y: f32| if number == 2 { y } else { y / (1.0 + (-stack.activation * y).exp()) };
        x = (0..answers).map(|t| (0..layer.bias.len()).map(|o| out(sum(t, o))).collect()).collect();
    }
    assert_eq!(x.len(), 1);
    let ours: Vec<f32> = x[0].iter().zip(&stack.offset).map(|(y, offset)| stack.unit * y + offset).collect();
    same(&theirs, &ours, "convolutions");
}
