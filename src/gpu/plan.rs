//! Where everything of one network lies on the card: parameters, activations, what the backward pass keeps.
//!
//! Parameters lie *packed* there: as the flat vector of [`dpn_pronet::shape`], but every convolution turned to `[in, kernel, out]` and every linear layer to
//! `[in, out]`, so that neighbouring units, which compute neighbouring outputs, read neighbouring numbers. The optimiser's state and gradients lie so too.
//! What goes back to inputs reads a second copy, `[kernel, out, in]` and `[out, in]`: the *turned* one.
//!
//! A workgroup has two arenas. *Near* holds what inner loops read: the prepared window and each block's output, rows of one time step with the next block's
//! padding about them, the features, the linear layers' outputs. It is the workgroup's shared memory where that is large enough. *Far* holds what is written once and
//! read once: each block's numbers before gain and offset. Gradients take the place of what they are with respect to.

use dpn_pronet::ProNetConfig;
use dpn_pronet::config::{BlockOrder, Head, Input, NormAxes, Pool};
use dpn_pronet::shape::{ParameterShape, features, layers, parameters};

/// Units of a workgroup.
pub(crate) const UNITS: usize = 256;
/// Time steps that a unit convolves at a time.
pub(crate) const TILE: usize = 4;

/// One convolution with what follows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Block {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) kernel: usize,
    pub(crate) stride: usize,
    pub(crate) padding: usize,
    /// Time steps out of it.
    pub(crate) length: usize,
    pub(crate) order: BlockOrder,
    pub(crate) norm: bool,
    /// First parameters, packed; `bias` where it has one, `gain` and `offset` where it normalises.
    pub(crate) weight: usize,
    pub(crate) bias: Option<usize>,
    pub(crate) gain: usize,
    pub(crate) offset: usize,
    /// In *near*: the first padded row of its input, the first row of its output behind the next block's padding, and the numbers between two rows of each.
    pub(crate) from: usize,
    pub(crate) from_pitch: usize,
    pub(crate) to: usize,
    pub(crate) to_pitch: usize,
    /// In *near*: mean and inverse deviation of every time step, `[2, length]`.
    pub(crate) moments: usize,
    /// In *far*: `[length, outputs]`.
    pub(crate) kept: usize,
}

/// One linear layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Linear {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) weight: usize,
    pub(crate) bias: usize,
    /// In *near*: its inputs and its outputs.
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Whether a leaky ReLU follows.
    pub(crate) leaky: bool,
}

/// A network's places, for which kernels are compiled.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Plan {
    pub(crate) window: usize,
    pub(crate) input: Input,
    /// Samples of the prepared window.
    pub(crate) length: usize,
    pub(crate) blocks: Vec<Block>,
    pub(crate) linears: Vec<Linear>,
    pub(crate) pool: Pool,
    pub(crate) head: Head,
    /// Bits of the slope below zero.
    pub(crate) leak: u32,
    pub(crate) parameters: usize,
    /// In *near*: gradients of the features; room for two numbers a unit, or two a time step.
    pub(crate) d_features: usize,
    pub(crate) sums: usize,
    /// Numbers of each arena.
    pub(crate) near: usize,
    pub(crate) far: usize,
}

impl Plan {
    /// The places of a checked configuration.
    pub(crate) fn new(config: &ProNetConfig) -> Self {
        let list = parameters(config);
        let place = |name: String| list.iter().find(|p| p.name == name).map(|p| p.offset);
        let rows: Vec<usize> = layers(config).iter().map(|row| row.length).collect();
        let count = config.channels.len();
        let (mut near, mut far) = (0, 0);
        let mut take = |numbers: usize| {
            near += numbers;
            near - numbers
        };
        // Odd, so that a column of rows lies in different banks.
        let pitch = |channels: usize| channels | 1;
        // Rows that hold `length` steps, the padding of the block they go into, and what its last tile reads beyond.
        let padded = |length: usize, into: usize| {
            if into == count {
                return length;
            }
            let (kernel, stride, padding) =
                (config.kernels[into], config.strides[into], config.paddings[into]);
            let tiles = rows[into + 1].div_ceil(TILE) * TILE;
            (length + 2 * padding).max((tiles - 1) * stride + kernel)
        };
        let mut from = take(padded(rows[0], 0));
        let mut inputs = 1;
        let mut blocks = Vec::new();
        for i in 0..count {
            let (outputs, length) = (config.channels[i], rows[i + 1]);
            let room = take(padded(length, i + 1) * pitch(outputs));
            let to = room + config.paddings.get(i + 1).copied().unwrap_or(0) * pitch(outputs);
            let norm = config.norm_axes == NormAxes::Channels;
            let layer = i + 1;
            blocks.push(Block {
                inputs,
                outputs,
                kernel: config.kernels[i],
                stride: config.strides[i],
                padding: config.paddings[i],
                length,
                order: config.block_order,
                norm,
                weight: place(format!("conv{layer}.weight")).expect("every block has a kernel"),
                bias: place(format!("conv{layer}.bias")),
                gain: place(format!("norm{layer}.weight")).unwrap_or(0),
                offset: place(format!("norm{layer}.bias")).unwrap_or(0),
                from,
                from_pitch: pitch(inputs),
                to,
                to_pitch: pitch(outputs),
                moments: take(if norm { 2 * length } else { 0 }),
                kept: far,
            });
            far += length * outputs;
            (from, inputs) = (room, outputs);
        }
        let mut inputs = features(config);
        let mut from = take(inputs);
        let d_features = take(inputs);
        let mut linears = Vec::new();
        for (i, outputs) in config.hidden.iter().copied().chain([config.head.outputs()]).enumerate() {
            let to = take(outputs);
            linears.push(Linear {
                inputs,
                outputs,
                weight: place(format!("fc{}.weight", i + 1)).expect("every layer has weights"),
                bias: place(format!("fc{}.bias", i + 1)).expect("every layer has a bias"),
                from,
                to,
                leaky: i < config.hidden.len(),
            });
            (from, inputs) = (to, outputs);
        }
        let longest = rows[1..=count].iter().copied().max().expect("a network has a block");
        let sums = take(2 * longest.max(UNITS));
        Self {
            window: config.window,
            input: config.input,
            length: rows[0],
            blocks,
            linears,
            pool: config.pool,
            head: config.head,
            leak: (config.leak as f32).to_bits(),
            parameters: list.iter().map(ParameterShape::len).sum(),
            d_features,
            sums,
            near,
            far,
        }
    }

    /// Numbers of an answer.
    pub(crate) fn outputs(&self) -> usize {
        self.head.outputs()
    }

    /// For every packed parameter its place in the flat vector, and its place in the turned copy.
    pub(crate) fn orders(&self) -> (Vec<u32>, Vec<u32>) {
        let mut flat: Vec<u32> = (0..self.parameters as u32).collect();
        let mut turned = flat.clone();
        let mut of = |weight: usize, inputs: usize, kernel: usize, outputs: usize| {
            for c in 0..inputs {
                for k in 0..kernel {
                    for o in 0..outputs {
                        let packed = weight + (c * kernel + k) * outputs + o;
                        flat[packed] = (weight + (o * inputs + c) * kernel + k) as u32;
                        turned[packed] = (weight + (k * outputs + o) * inputs + c) as u32;
                    }
                }
            }
        };
        for block in &self.blocks {
            of(block.weight, block.inputs, block.kernel, block.outputs);
        }
        for layer in &self.linears {
            of(layer.weight, layer.inputs, 1, layer.outputs);
        }
        (flat, turned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Sensor;

    #[test]
    fn orders_are_permutations_that_move_a_known_weight_where_it_belongs() {
        let plan = Plan::new(&ProNetConfig::for_sensor(Sensor::Gyro));
        let (flat, turned) = plan.orders();
        for order in [&flat, &turned] {
            let mut seen = order.clone();
            seen.sort_unstable();
            assert!(seen.iter().enumerate().all(|(i, at)| i == *at as usize));
        }
        // conv2.weight[o = 5, c = 3, k = 2] of [32, 16, 7].
        let at = plan.blocks[1].weight;
        let packed = at + (3 * 7 + 2) * 32 + 5;
        assert_eq!(
            (flat[packed] as usize, turned[packed] as usize),
            (at + (5 * 16 + 3) * 7 + 2, at + (2 * 32 + 5) * 16 + 3)
        );
    }
}
