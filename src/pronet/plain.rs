//! The network composed of burn's primitives: what it means, whatever the device.
//!
//! Shapes stand at every line that changes one. The fused kernels of this crate are held to this by tests.

use crate::config::{BlockOrder, Edges, Head, Input, NormAxes, Pool, ProNetConfig, Standardise};
use crate::definition::{LOG_SIGMA_RANGE, NORM_EPSILON, POOL_EPSILON, SCALE_EPSILON};
use crate::module::ProNet;
use burn::module::Param;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Tensor, activation, module::conv1d};

impl ProNet {
    /// The same as [`Self::forward`], composed of burn's primitives: the reference for the fused kernels.
    ///
    /// # Shapes
    /// `windows`: `[batch, window]`; returns `[batch]`.
    pub fn forward_plain(&self, windows: Tensor<2>) -> Tensor<1> {
        let config = self.config();
        let (mut x, scale) = prepare(config, windows); // [batch, input channels, time], [batch, 1]
        for i in 0..self.conv.len() {
            x = self.block(i, x); // [batch, channels, time / stride]
        }
        let mut features = match config.pool {
            Pool::Mean => x.mean_dim(2).squeeze_dim(2), // [batch, channels]
            Pool::MeanAndRms => {
                let mean = x.clone().mean_dim(2).squeeze_dim::<2>(2); // [batch, channels]
                let rms = (x.square().mean_dim(2).squeeze_dim::<2>(2) + POOL_EPSILON).sqrt(); // [batch, channels]
                Tensor::cat(vec![mean, rms], 1) // [batch, 2 channels]
            }
        };
        if let Some(scale) = &scale {
            features = Tensor::cat(vec![features, scale.clone().log()], 1); // [batch, features]
        }
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
            Head::Linear => features,
            Head::LogSigma => features.clamp(LOG_SIGMA_RANGE.0, LOG_SIGMA_RANGE.1).exp(),
        };
        let sigma = positive * config.output_scale() as f32; // [batch, 1]
        match scale {
            Some(scale) if config.rescale_output => (sigma * scale).squeeze_dim(1), // [batch]
            _ => sigma.squeeze_dim(1),                                              // [batch]
        }
    }

    fn block(&self, i: usize, x: Tensor<3>) -> Tensor<3> {
        let config = self.config();
        let padding = config.paddings[i];
        let (x, padding) = if i == 0 && config.edges == Edges::Odd && padding > 0 {
            (odd_extension(&x, padding), 0) // [batch, channels, padding + time + padding]
        } else {
            (x, padding)
        };
        let options = ConvOptions::new([config.strides[i]], [padding], [1], 1);
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
        let over = |x: Tensor<3>| match self.config().norm_axes {
            NormAxes::Channels => x.mean_dim(1),                    // [batch, 1, time]
            NormAxes::ChannelsAndTime => x.mean_dim(1).mean_dim(2), // [batch, 1, 1]
            NormAxes::None => x,
        };
        let Some(norm) = self.norm.get(i) else {
            return x;
        };
        let centred = x.clone() - over(x); // [batch, channels, time]
        let variance = over(centred.clone().square());
        let normal = centred / (variance + NORM_EPSILON).sqrt(); // [batch, channels, time]
        let per_channel = |p: &Param<Tensor<1>>| p.val().unsqueeze::<2>().unsqueeze_dim::<3>(2); // [1, channels, 1]
        normal * per_channel(&norm.weight) + per_channel(&norm.bias)
    }
}

/// What the first convolution sees, and each window's own scale where there is one.
///
/// # Shapes
/// `windows`: `[batch, window]`; returns `[batch, input channels, time]` and `[batch, 1]`.
fn prepare(config: &ProNetConfig, windows: Tensor<2>) -> (Tensor<3>, Option<Tensor<2>>) {
    let [batch, n] = windows.dims();
    let mut x = windows * (1.0 / config.input_scale()) as f32; // [batch, window]
    if matches!(config.input, Input::Demeaned | Input::DemeanedAndSecondDifferences) {
        x = x.clone() - x.mean_dim(1);
    }
    let first = |x: Tensor<2>| {
        let [_, n] = x.dims();
        x.clone().slice([0..batch, 1..n]) - x.slice([0..batch, 0..n - 1]) // [batch, n - 1]
    };
    let scale = match config.standardise {
        Standardise::None => None,
        Standardise::Rms => Some(x.clone()),
        Standardise::SecondDifferences => Some(first(first(x.clone()))),
    }
    .map(|of| (of.square().mean_dim(1) + SCALE_EPSILON).sqrt()); // [batch, 1]
    if let Some(scale) = &scale {
        x = x / scale.clone();
    }
    let planes = match config.input {
        Input::Demeaned | Input::Raw => vec![x],
        Input::Differences => vec![first(x)], // [batch, window - 1]
        Input::SecondDifferences => vec![first(first(x))], // [batch, window - 2]
        Input::BothDifferences => {
            let d = first(x); // [batch, window - 1]
            vec![d.clone().slice([0..batch, 0..n - 2]), first(d)] // 2 of [batch, window - 2]
        }
        Input::DemeanedAndSecondDifferences => {
            let zero = Tensor::zeros([batch, 1], &x.device());
            let d2 = Tensor::cat(vec![zero.clone(), first(first(x.clone())), zero], 1); // [batch, window]
            vec![x, d2]
        }
    };
    (Tensor::stack(planes, 1), scale) // [batch, input channels, time]
}

/// `[batch, channels, time]` turned about its end points: `[batch, channels, by + time + by]`.
fn odd_extension(x: &Tensor<3>, by: usize) -> Tensor<3> {
    let [b, c, n] = x.dims();
    let part = |from: usize, to: usize| x.clone().slice([0..b, 0..c, from..to]);
    let left = part(0, 1) * 2.0 - part(1, by + 1).flip([2]); // [batch, channels, by]
    let right = part(n - 1, n) * 2.0 - part(n - 1 - by, n - 1).flip([2]); // [batch, channels, by]
    Tensor::cat(vec![left, x.clone(), right], 2) // [batch, channels, by + time + by]
}
