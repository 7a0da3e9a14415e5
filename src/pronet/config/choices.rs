//! The choices the paper leaves open, each an enum: the spelling in a TOML file is the variant's name in kebab case.

use dpn_core::named;
use serde::{Deserialize, Serialize};

named!(
    /// In which order a block's steps come (decision 4).
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum BlockOrder {
        /// Convolution, layer normalisation, leaky ReLU.
        #[default]
        ConvNormAct = "conv-norm-act",
        /// Convolution, leaky ReLU, layer normalisation: the paper's text.
        ConvActNorm = "conv-act-norm",
    }
);

named!(
    /// Over what a block normalises (decision 5). Gain and offset are per channel.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum NormAxes {
        /// Over the channels, at each time step.
        #[default]
        Channels = "channels",
        /// Not at all; the block has no gain and no offset.
        None = "none",
    }
);

named!(
    /// How the last linear layer's number `z` becomes a deviation, before the output scale (decision 7).
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Head {
        /// `ln(1 + exp(z))`: positive.
        #[default]
        Softplus = "softplus",
        /// `z` for `z > 0`, `leak * z` below: the paper; may give a negative deviation.
        LeakyRelu = "leaky-relu",
        /// `exp(z)`, with `z` clamped to \[-10, 5\].
        LogSigma = "log-sigma",
        /// The same of the first of two numbers, and of the second, clamped to \[-5, 2\], the deviation of the answer's logarithm: how far
        /// off the network takes itself to be.
        LogSigmaAndSpread = "log-sigma-and-spread",
    }
);

impl Head {
    /// Numbers the last layer gives a window.
    pub fn outputs(self) -> usize {
        match self {
            Self::LogSigmaAndSpread => 2,
            Self::Softplus | Self::LeakyRelu | Self::LogSigma => 1,
        }
    }
}

named!(
    /// What of a window the first convolution sees, after division by the input scale (decision 8).
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Input {
        /// The window minus its mean.
        #[default]
        Demeaned = "demeaned",
        /// The window as it is: the paper. Gravity included.
        Raw = "raw",
        /// `x[t+2] - 2 x[t+1] + x[t]`: two samples shorter.
        SecondDifferences = "second-differences",
    }
);

named!(
    /// How the last block's channels are pooled over time.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Pool {
        /// Their means.
        #[default]
        Mean = "mean",
        /// Their means and, after these, their root mean squares: twice as many features.
        MeanAndRms = "mean-and-rms",
        /// The logarithms of their root mean squares: a factor in the window is a shift of the features, over any range of levels.
        LogRms = "log-rms",
    }
);

named!(
    /// What the first convolution's kernels start from; training moves them like any others.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum FirstKernels {
        /// Uniform draws, like every other layer's.
        #[default]
        Uniform = "uniform",
        /// Windowed cosines from .03 to .5 cycles a sample, each of unit gain on white noise in the window; their biases start at
        /// zero. The network begins as a bank of band-pass filters.
        BandPass = "band-pass",
    }
);
