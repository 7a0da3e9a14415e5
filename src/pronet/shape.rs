//! The shapes a configuration implies: a table of layers (for texts and figures) and the list of parameters.
//!
//! Parameters are listed in the order and with the names and shapes of a PyTorch `state_dict`: for every block `conv1.weight`
//! `[out, in, kernel]`, `conv1.bias` `[out]`, `norm1.weight` `[out]`, `norm1.bias` `[out]`; then `fc1.weight` `[out, in]`,
//! `fc1.bias` `[out]`, and so on. Joined end to end in that order they are the *flat parameters*: one vector of `f32` that the
//! fused kernels, the optimiser and the weight files share.

use crate::config::{NormAxes, Pool, ProNetConfig};

/// One parameter: its name, shape and place in the flat vector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterShape {
    /// Name in the PyTorch state dictionary, for example `"conv1.weight"`.
    pub name: String,
    /// Sizes, PyTorch's order.
    pub shape: Vec<usize>,
    /// Index of its first number in the flat parameters.
    pub offset: usize,
    /// What it starts from.
    pub start: Start,
}

impl ParameterShape {
    /// How many numbers it has.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Never: a parameter has a number at least.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a parameter starts from before training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Uniform on plus minus `1 / sqrt(fan_in)`: PyTorch's default for convolutions and linear layers, biases included.
    Uniform {
        /// Inputs of one output.
        fan_in: usize,
    },
    /// All ones: the gain of a normalisation.
    One,
    /// All zeros: the offset of a normalisation.
    Zero,
}

/// What kind of layer a row of the table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerKind {
    /// The prepared window.
    Input,
    /// Convolution with normalisation and leaky ReLU.
    Block {
        /// Kernel width \[samples\].
        kernel: usize,
        /// Stride \[samples\].
        stride: usize,
        /// Padding at both ends \[samples\].
        padding: usize,
    },
    /// Pooling over time.
    Pool,
    /// Linear layer.
    Linear,
}

/// One row of the table of layers: what comes out of it and what it costs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LayerShape {
    /// `"input"`, `"block1"`, .., `"pool"`, `"fc1"`, ..
    pub name: String,
    /// What it is.
    pub kind: LayerKind,
    /// Channels (or features) out of it.
    pub channels: usize,
    /// Time steps out of it; 1 after the pooling.
    pub length: usize,
    /// Parameters in it.
    pub parameters: usize,
    /// Multiplications of its convolution or linear map for one window.
    pub multiplications: usize,
}

/// Features that reach the first linear layer.
pub fn features(config: &ProNetConfig) -> usize {
    let channels = *config.channels.last().expect("a checked configuration has a block");
    match config.pool {
        Pool::Mean | Pool::LogRms => channels,
        Pool::MeanAndRms => 2 * channels,
    }
}

/// The table of layers, input first.
pub fn layers(config: &ProNetConfig) -> Vec<LayerShape> {
    let mut length = config.input_length();
    let mut channels = 1;
    let row = |name: String, kind, channels, length, parameters, multiplications| LayerShape {
        name,
        kind,
        channels,
        length,
        parameters,
        multiplications,
    };
    let mut rows = vec![row("input".to_owned(), LayerKind::Input, channels, length, 0, 0)];
    for (i, &out) in config.channels.iter().enumerate() {
        let (kernel, stride, padding) = (config.kernels[i], config.strides[i], config.paddings[i]);
        length = (length + 2 * padding - kernel) / stride + 1;
        let weights = out * channels * kernel;
        let norm = if config.norm_axes == NormAxes::None { 0 } else { 2 * out };
        let parameters = weights + usize::from(config.conv_bias) * out + norm;
        let kind = LayerKind::Block { kernel, stride, padding };
        rows.push(row(format!("block{}", i + 1), kind, out, length, parameters, weights * length));
        channels = out;
    }
    let mut inputs = features(config);
    rows.push(row("pool".to_owned(), LayerKind::Pool, inputs, 1, 0, 0));
    for (i, out) in config.hidden.iter().copied().chain([config.head.outputs()]).enumerate() {
        let (parameters, weights) = (out * inputs + out, out * inputs);
        rows.push(row(format!("fc{}", i + 1), LayerKind::Linear, out, 1, parameters, weights));
        inputs = out;
    }
    rows
}

/// All parameters in the order of the flat vector.
pub fn parameters(config: &ProNetConfig) -> Vec<ParameterShape> {
    let mut list: Vec<ParameterShape> = Vec::new();
    let mut offset = 0;
    let mut push = |name: String, shape: Vec<usize>, start| {
        let len: usize = shape.iter().product();
        list.push(ParameterShape { name, shape, offset, start });
        offset += len;
    };
    let mut inputs = 1;
    for (i, &out) in config.channels.iter().enumerate() {
        let kernel = config.kernels[i];
        let start = Start::Uniform { fan_in: inputs * kernel };
        push(format!("conv{}.weight", i + 1), vec![out, inputs, kernel], start);
        if config.conv_bias {
            push(format!("conv{}.bias", i + 1), vec![out], start);
        }
        if config.norm_axes != NormAxes::None {
            push(format!("norm{}.weight", i + 1), vec![out], Start::One);
            push(format!("norm{}.bias", i + 1), vec![out], Start::Zero);
        }
        inputs = out;
    }
    inputs = features(config);
    for (i, out) in config.hidden.iter().copied().chain([config.head.outputs()]).enumerate() {
        let start = Start::Uniform { fan_in: inputs };
        push(format!("fc{}.weight", i + 1), vec![out, inputs], start);
        push(format!("fc{}.bias", i + 1), vec![out], start);
        inputs = out;
    }
    list
}

/// How many numbers a network learns.
pub fn parameter_count(config: &ProNetConfig) -> usize {
    parameters(config).iter().map(ParameterShape::len).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_network_has_the_counted_shapes() {
        let config = ProNetConfig::default();
        let rows = layers(&config);
        let shapes: Vec<_> = rows.iter().map(|r| (r.name.as_str(), r.channels, r.length)).collect();
        assert_eq!(
            shapes,
            [
                ("input", 1, 200),
                ("block1", 16, 200),
                ("block2", 32, 100),
                ("block3", 64, 50),
                ("pool", 64, 1),
                ("fc1", 64, 1),
                ("fc2", 32, 1),
                ("fc3", 16, 1),
                ("fc4", 1, 1),
            ]
        );
        // 16*7+16+32, 32*16*7+32+64, 64*32*7+64+128, then 64*64+64, 64*32+32, 32*16+16, 16+1.
        let counts: Vec<_> = rows.iter().map(|r| r.parameters).collect();
        assert_eq!(counts, [0, 160, 3680, 14528, 0, 4160, 2080, 528, 17]);
        assert_eq!(parameter_count(&config), 25_153);
        assert_eq!(rows[3].multiplications, 50 * 7 * 32 * 64);
    }

    #[test]
    fn the_table_and_the_list_count_the_same_for_every_choice() {
        for norm_axes in NormAxes::ALL {
            for pool in Pool::ALL {
                for conv_bias in [true, false] {
                    let config = ProNetConfig { norm_axes, pool, conv_bias, ..ProNetConfig::default() };
                    let table: usize = layers(&config).iter().map(|r| r.parameters).sum();
                    assert_eq!(table, parameter_count(&config));
                }
            }
        }
    }

    #[test]
    fn offsets_leave_no_gap() {
        let list = parameters(&ProNetConfig::default());
        for pair in list.windows(2) {
            assert_eq!(pair[0].offset + pair[0].len(), pair[1].offset);
        }
    }
}
