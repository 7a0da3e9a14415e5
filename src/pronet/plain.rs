//! The network composed of burn's primitives: what it means, whatever the device.
//!
//! Shapes stand at every line that changes one. The kernels of this crate are held to this by tests.

use crate::config::{BlockOrder, Head, Input, Pool, ProNetConfig};
use crate::definition::{LOG_SIGMA_RANGE, LOG_SPREAD_RANGE, NORM_EPSILON, POOL_EPSILON};
use crate::module::ProNet;
use burn::module::Param;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Tensor, activation, module::conv1d};

impl ProNet {
    /// The deviation of each window, in the sensor's unit.
    ///
    /// # Shapes
    /// `windows`: `[batch, window]`; returns `[batch]`.
    ///
    /// # Units and frames
    /// Samples of one axis and their deviation, both in m/s^2 or rad/s.
    ///
    /// # Panics
    /// When a window has not the configuration's length.
    pub fn forward(&self, windows: Tensor<2>) -> Tensor<1> {
        let [batch, _] = windows.dims();
        self.answers(windows).slice([0..batch, 0..1]).squeeze_dim(1) // [batch]
    }

    /// All that the network says of each window: its deviation in the sensor's unit and, where the head has it, the deviation of that
    /// answer's logarithm.
    ///
    /// # Shapes
    /// `windows`: `[batch, window]`; returns `[batch, outputs]`, [`outputs`](crate::config::Head::outputs) of the head.
    ///
    /// # Panics
    /// When a window has not the configuration's length.
    pub fn answers(&self, windows: Tensor<2>) -> Tensor<2> {
        let config = self.config();
        let [_, window] = windows.dims();
        assert_eq!(window, config.window, "the network takes windows of {}", config.window);
        let mut x = prepare(config, windows); // [batch, 1, time]
        for i in 0..self.conv.len() {
            x = self.block(i, x); // [batch, channels, time / stride]
        }
        let mut features = match config.pool {
            Pool::Mean => x.mean_dim(2).squeeze_dim(2), // [batch, channels]
            Pool::LogRms => (x.square().mean_dim(2).squeeze_dim::<2>(2) + POOL_EPSILON).log() * 0.5, // [batch, channels]
            Pool::MeanAndRms => {
                let mean = x.clone().mean_dim(2).squeeze_dim::<2>(2); // [batch, channels]
                let rms = (x.square().mean_dim(2).squeeze_dim::<2>(2) + POOL_EPSILON).sqrt(); // [batch, channels]
                Tensor::cat(vec![mean, rms], 1) // [batch, 2 channels]
            }
        };
        for (i, layer) in self.fc.iter().enumerate() {
            features = features.matmul(layer.weight.val().transpose()) // [batch, features out]
                + layer.bias.val().unsqueeze();
            if i + 1 < self.fc.len() {
                features = activation::leaky_relu(features, config.leak);
            }
        }
        let positive = match config.head {
            Head::Softplus => activation::softplus(features, 1.0),
            Head::LeakyRelu => activation::leaky_relu(features, config.leak),
            Head::LogSigma => features.clamp(LOG_SIGMA_RANGE.0, LOG_SIGMA_RANGE.1).exp(),
            Head::LogSigmaAndSpread => {
                let [batch, _] = features.dims();
                let part = |k: usize, (low, high)| {
                    features.clone().slice([0..batch, k..k + 1]).clamp(low, high).exp() // [batch, 1]
                };
                let sigma = part(0, LOG_SIGMA_RANGE) * config.output_scale() as f32;
                return Tensor::cat(vec![sigma, part(1, LOG_SPREAD_RANGE)], 1); // [batch, 2]
            }
        };
        positive * config.output_scale() as f32 // [batch, 1]
    }

    fn block(&self, i: usize, x: Tensor<3>) -> Tensor<3> {
        let config = self.config();
        let options = ConvOptions::new([config.strides[i]], [config.paddings[i]], [1], 1);
        let conv = &self.conv[i];
        let bias = conv.bias.as_ref().map(Param::val);
        let x = conv1d(x, conv.weight.val(), bias, options); // [batch, channels out, time out]
        let act = |x| activation::leaky_relu(x, config.leak);
        match config.block_order {
            BlockOrder::ConvNormAct => act(self.normalise(i, x)),
            BlockOrder::ConvActNorm => self.normalise(i, act(x)),
        }
    }

    fn normalise(&self, i: usize, x: Tensor<3>) -> Tensor<3> {
        let Some(norm) = self.norm.get(i) else {
            return x;
        };
        let centred = x.clone() - x.mean_dim(1); // [batch, channels, time]
        let variance = centred.clone().square().mean_dim(1); // [batch, 1, time]
        let normal = centred / (variance + NORM_EPSILON).sqrt(); // [batch, channels, time]
        let per_channel = |p: &Param<Tensor<1>>| p.val().unsqueeze::<2>().unsqueeze_dim::<3>(2); // [1, channels, 1]
        normal * per_channel(&norm.weight) + per_channel(&norm.bias)
    }
}

/// What the first convolution sees.
///
/// # Shapes
/// `windows`: `[batch, window]`; returns `[batch, 1, time]`.
fn prepare(config: &ProNetConfig, windows: Tensor<2>) -> Tensor<3> {
    let [batch, _] = windows.dims();
    let x = windows * (1.0 / config.input_scale()) as f32; // [batch, window]
    let difference = |x: Tensor<2>| {
        let [_, n] = x.dims();
        x.clone().slice([0..batch, 1..n]) - x.slice([0..batch, 0..n - 1]) // [batch, n - 1]
    };
    let x = match config.input {
        Input::Raw => x,
        Input::Demeaned => x.clone() - x.mean_dim(1),
        Input::SecondDifferences => difference(difference(x)), // [batch, window - 2]
    };
    x.unsqueeze_dim(1) // [batch, 1, time]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::NormAxes;
    use crate::init::initial_parameters;
    use crate::trainable::Trainable;
    use burn::tensor::Device;
    use dpn_core::config::Validate;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand::seq::IndexedRandom;

    fn pick<T: Copy>(choices: &[T], rng: &mut impl Rng) -> T {
        *choices.choose(rng).unwrap()
    }

    /// A small network with every choice drawn.
    fn random_config(rng: &mut impl Rng) -> ProNetConfig {
        let blocks = rng.random_range(1..=3);
        let mut config = ProNetConfig {
            window: rng.random_range(30..60),
            input: pick(&Input::ALL, rng),
            block_order: pick(&BlockOrder::ALL, rng),
            norm_axes: pick(&NormAxes::ALL, rng),
            channels: (0..blocks).map(|_| pick(&[1, 3, 16, 19, 32, 48, 64], rng)).collect(),
            kernels: (0..blocks).map(|_| rng.random_range(1..8)).collect(),
            strides: (0..blocks).map(|_| rng.random_range(1..4)).collect(),
            paddings: vec![0; blocks],
            conv_bias: rng.random(),
            leak: pick(&[0.0, 0.01, 0.1, 1.0], rng),
            pool: pick(&Pool::ALL, rng),
            hidden: (0..rng.random_range(0..4)).map(|_| pick(&[1, 5, 16, 33], rng)).collect(),
            head: pick(&Head::ALL, rng),
            ..ProNetConfig::default()
        };
        // Without a slope below zero a channel may not swing at all, and the gradient of its logarithm is rounding alone.
        if config.pool == Pool::LogRms {
            config.leak = config.leak.max(0.01);
        }
        for (p, k) in config.paddings.iter_mut().zip(&config.kernels) {
            *p = rng.random_range(0..*k);
        }
        config
    }

    fn windows(count: usize, length: usize, rng: &mut impl Rng) -> Vec<f32> {
        (0..count * length).map(|_| 0.2 * (rng.random::<f32>() - 0.5)).collect()
    }

    /// The loss's gradient with respect to `answers`, a few outputs each of `count` windows.
    fn d_answers(answers: &[f32], count: usize) -> Vec<f32> {
        let weight = |i| (1.0 + i as f32 / count as f32) / answers.len() as f32;
        answers.iter().enumerate().map(|(i, answer)| weight(i) * 20.0 * (answer * 10.0 - 0.3)).collect()
    }

    /// Largest difference in units of the largest number.
    fn relative(a: &[f32], b: &[f32]) -> f32 {
        assert_eq!(a.len(), b.len());
        assert!(a.iter().chain(b).all(|v| v.is_finite()), "not finite");
        let largest = a.iter().chain(b).fold(1e-30f32, |m, v| m.max(v.abs()));
        a.iter().zip(b).fold(0f32, |m, (x, y)| m.max((x - y).abs())) / largest
    }

    #[test]
    fn kernels_and_plain_agree_in_values_and_gradients_for_any_configuration() {
        let device = Device::flex().autodiff();
        let mut cases = 0;
        for case in 0..60 {
            let stream = Stream::new(11).named("fused").index(case);
            let mut rng = stream.rng();
            let config = random_config(&mut rng);
            if config.validate().is_err() {
                continue;
            }
            // Gains and offsets away from one and zero.
            let flat: Vec<f32> = initial_parameters(&config, &stream.named("init"))
                .iter()
                .map(|p| p + 0.2 * (rng.random::<f32>() - 0.5))
                .collect();
            let count = rng.random_range(1..40);
            let x = windows(count, config.window, &mut rng);
            let [kernels, plain] = [crate::Device::Cpu, crate::Device::Burn(device.clone())].map(|device| {
                let mut said = Vec::new();
                let gradient = Trainable::new(&config, &device).unwrap().gradient(&flat, &x, |answers| {
                    said = answers.to_vec();
                    (0.0, d_answers(answers, count))
                });
                (said, gradient.1)
            });
            let (values, gradients) = (relative(&kernels.0, &plain.0), relative(&kernels.1, &plain.1));
            let plain = plain.1;
            // With a slope of zero below zero a network may be dead: then both gradients are zero.
            cases += usize::from(plain.iter().any(|g| g.abs() > 1e-6));
            // The gradient of a logarithm is as large as what it is of is small: rounding in a channel that hardly swings counts more.
            let tolerance = if config.pool == Pool::LogRms { 3e-4 } else { 1e-5 };
            assert!(
                values < 1e-5 && gradients < tolerance,
                "case {case}: {values:e} {gradients:e} {config:?}"
            );
        }
        assert!(cases > 40, "only {cases} of the drawn networks are alive");
    }
}
