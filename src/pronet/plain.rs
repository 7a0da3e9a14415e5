//! The network composed of burn's primitives: what it means, whatever the device.
//!
//! Shapes stand at every line that changes one. The fused kernels of this crate are held to this by tests.

use crate::config::{BlockOrder, Head, Input, Pool, ProNetConfig};
use crate::definition::{LOG_SIGMA_RANGE, LOG_SPREAD_RANGE, NORM_EPSILON, POOL_EPSILON};
use crate::module::{ProNet, deviations};
use burn::module::Param;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Tensor, activation, module::conv1d};

impl ProNet {
    /// The same as [`Self::forward`], composed of burn's primitives: the reference for the fused kernels.
    ///
    /// # Shapes
    /// `windows`: `[batch, window]`; returns `[batch]`.
    pub fn forward_plain(&self, windows: Tensor<2>) -> Tensor<1> {
        deviations(self.answers_plain(windows))
    }

    /// The same as [`Self::answers`], composed of burn's primitives.
    ///
    /// # Shapes
    /// `windows`: `[batch, window]`; returns `[batch, outputs]`.
    pub fn answers_plain(&self, windows: Tensor<2>) -> Tensor<2> {
        let config = self.config();
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
