//! Models of every kind that is exported, with real or random windows and what ours makes of them.

use crate::windows::real;
use dpn_core::Sensor;
use dpn_core::random::Stream;
use dpn_onnx::{Convolution, Convolutions};
use dpn_pronet::config::{BlockOrder, Head, Input, NormAxes, Pool, ProNetConfig};
use dpn_pronet::init::initial_parameters;
use dpn_pronet::{Card, Predictor, Weights};
use dpn_testing::repository;
use rand::Rng;

/// A model, what is put in, and what has to come out.
pub(crate) struct Model {
    pub name: String,
    pub bytes: Vec<u8>,
    /// Shape of the input; its first size counts the answers.
    pub shape: Vec<usize>,
    pub input: Vec<f32>,
    /// By output: sigma, and the spread where the network says one.
    pub ours: Vec<Vec<f32>>,
}

/// Every model.
pub(crate) fn all() -> Vec<Model> {
    let mut models = vec![convolutions()];
    for (sensor, names) in [
        (Sensor::Accel, ["sg11-s0", "wide-s0", "paper-s0", "raw-s0", "effective-s0"]),
        (Sensor::Gyro, ["sg51-s1", "wide-s0", "paper-s1", "total-s0", "effective-s0"]),
    ] {
        models.extend(names.map(|name| {
            let path = ["models", "papers/networks"]
                .map(|folder| repository().join(format!("{folder}/{sensor}/{name}.safetensors")))
                .into_iter()
                .find(|path| path.is_file());
            network(format!("{sensor} {name}"), &Weights::load(path.unwrap()).unwrap(), real(sensor, 200))
        }));
    }
    models.extend(choices().into_iter().map(|config| {
        let flat = initial_parameters(&config, &Stream::new(3).named("onnx"));
        let mut windows = real(Sensor::Gyro, 40);
        windows.truncate(20 * 40);
        network(format!("{config:?}"), &Weights::new(&config, flat, Card::default()), windows)
    }));
    models
}

fn network(name: String, weights: &Weights, input: Vec<f32>) -> Model {
    let window = weights.config().window;
    let count = input.len() / window;
    let [mut sigma, mut spread] = [(); 2].map(|()| vec![0.0; count]);
    let ours = if weights.config().head == Head::LogSigmaAndSpread {
        Predictor::new(weights).predict_with_spread(&input, &mut sigma, &mut spread);
        vec![sigma, spread]
    } else {
        Predictor::new(weights).predict(&input, &mut sigma);
        vec![sigma]
    };
    Model { name, bytes: dpn_onnx::to_bytes(weights).unwrap(), shape: vec![count, window], input, ours }
}

/// Every choice of a configuration, one away from a small one.
fn choices() -> Vec<ProNetConfig> {
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
    configs
}

/// A stack of dilated convolutions, as the inertial model has, and its definition in loops.
fn convolutions() -> Model {
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

    let seen = |t: usize, axis: usize| (window[axis * 17 + t] - stack.mean[axis]) / stack.deviation[axis];
    let mut x: Vec<Vec<f32>> = (0..17).map(|t| (0..6).map(|axis| seen(t, axis)).collect()).collect();
    for (number, layer) in stack.layers.iter().enumerate() {
        let taps = layer.weights.len() / (layer.inputs * layer.bias.len());
        let answers = (x.len() - (taps - 1) * layer.dilation - 1) / layer.stride + 1;
        let sum = |t: usize, o: usize| -> f32 {
            let of = |i: usize, tap: usize| {
                layer.weights[(o * layer.inputs + i) * taps + tap]
                    * x[t * layer.stride + tap * layer.dilation][i]
            };
            layer.bias[o]
                + (0..layer.inputs).map(|i| (0..taps).map(|tap| of(i, tap)).sum::<f32>()).sum::<f32>()
        };
        let out = |y: f32| if number == 2 { y } else { y / (1.0 + (-stack.activation * y).exp()) };
        x = (0..answers).map(|t| (0..layer.bias.len()).map(|o| out(sum(t, o))).collect()).collect();
    }
    assert_eq!(x.len(), 1);
    let ours = x[0].iter().zip(&stack.offset).map(|(y, offset)| stack.unit * y + offset).collect();
    Model {
        name: "convolutions".into(),
        bytes: stack.to_bytes(),
        shape: vec![1, 6, 17],
        input: window,
        ours: vec![ours],
    }
}
