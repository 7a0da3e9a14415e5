//! Where everything lies: the layout of packed weights, of what a window leaves behind, and of gradients.
//!
//! Channels are the fastest index and are padded with zeros to a multiple of [`LANE`], so that a time step is a whole number of
//! vectors. A block's input is stored with its time padding; the matrix of a convolution, `[time out, kernel * channels in]`, is
//! then a view of it whose rows begin `stride * channels in` apart and overlap: nothing is copied.

use crate::config::{NormAxes, Pool, ProNetConfig};
use crate::shape::{ParameterShape, features, parameters};

/// Channels are padded to a multiple of this; it is a multiple of every vector length in use.
pub(crate) const LANE: usize = 16;

pub(crate) fn padded(channels: usize) -> usize {
    channels.next_multiple_of(LANE)
}

/// One matrix stored in column panels: `inner` rows of `columns` numbers, cut in panels of `2 * lanes` columns (the last may
/// be narrower), each panel row by row.
#[derive(Debug, Clone)]
pub(crate) struct Panels {
    /// First number in the packed weights.
    pub(crate) at: usize,
    /// Rows.
    pub(crate) inner: usize,
    /// Columns, a multiple of [`LANE`].
    pub(crate) columns: usize,
}

/// The rows `u = first, first + stride, ..` of a convolution's input gradient: one product with every `stride`-th tap.
#[derive(Debug, Clone)]
pub(crate) struct Phase {
    /// First time step of the input.
    pub(crate) first: usize,
    /// How many time steps.
    pub(crate) count: usize,
    /// Row of the padded output gradient where the first product's row begins.
    pub(crate) from: usize,
    /// The taps, last first: `[taps * channels out, channels in]`.
    pub(crate) weights: Panels,
}

/// One block.
#[derive(Debug, Clone)]
pub(crate) struct BlockPlan {
    /// Numbers of one time step of the input: planes of the first block, padded channels of the others.
    pub(crate) width_in: usize,
    /// Padded channels out.
    pub(crate) width_out: usize,
    /// True channels out.
    pub(crate) channels: usize,
    pub(crate) kernel: usize,
    pub(crate) stride: usize,
    pub(crate) padding: usize,
    pub(crate) time_in: usize,
    pub(crate) time_out: usize,
    /// `[kernel * width in, width out]`.
    pub(crate) weights: Panels,
    /// Rows of [`LANE`]-padded channel numbers in the packed weights: bias, gain, offset, one for every true channel.
    pub(crate) bias: usize,
    pub(crate) gain: usize,
    pub(crate) offset: usize,
    pub(crate) mask: usize,
    /// Of the input gradient; none for the first block.
    pub(crate) phases: Vec<Phase>,
    /// Zero rows before the output gradient.
    pub(crate) lead: usize,
    /// Rows of the padded output gradient.
    pub(crate) gradient_rows: usize,
    /// In what a window leaves behind: padded input, convolution's output, mean and reciprocal deviation of every row.
    pub(crate) saved_input: usize,
    pub(crate) saved_conv: usize,
    pub(crate) saved_stats: usize,
    /// In the gradients: weights `[kernel * width in, width out]`.
    pub(crate) d_weights: usize,
    /// In the gradients: bias, and right behind it gain and offset, each `[width out]`.
    pub(crate) d_bias: usize,
}

impl BlockPlan {
    /// Numbers of the padded input.
    pub(crate) fn input_len(&self) -> usize {
        (self.time_in + 2 * self.padding) * self.width_in
    }
}

/// One linear layer.
#[derive(Debug, Clone)]
pub(crate) struct LinearPlan {
    pub(crate) width_in: usize,
    pub(crate) width_out: usize,
    /// `[width in, width out]`.
    pub(crate) weights: Panels,
    /// `[width out, width in]`, for the input gradient.
    pub(crate) transposed: Panels,
    pub(crate) bias: usize,
    pub(crate) d_weights: usize,
    pub(crate) d_bias: usize,
}

/// The whole network.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) blocks: Vec<BlockPlan>,
    pub(crate) linears: Vec<LinearPlan>,
    /// Numbers a window leaves behind.
    pub(crate) saved_len: usize,
    /// In what a window leaves behind: the last block's output `[time, width]`.
    pub(crate) saved_last: usize,
    /// For every packed number the flat parameter it is; `parameters` stands for zero, `parameters + 1` for one.
    pub(crate) packed: Vec<u32>,
    /// For every flat parameter its place in the gradients.
    pub(crate) gradient: Vec<u32>,
    /// Numbers in the gradients.
    pub(crate) gradient_len: usize,
    /// Numbers in the flat parameters.
    pub(crate) parameters: usize,
}

/// Collects the packed weights' sources.
struct Packer {
    lanes: usize,
    packed: Vec<u32>,
    zero: u32,
}

impl Packer {
    fn align(&mut self) {
        let len = self.packed.len().next_multiple_of(LANE);
        self.packed.resize(len, self.zero);
    }

    fn panels(
        &mut self,
        inner: usize,
        columns: usize,
        source: impl Fn(usize, usize) -> Option<usize>,
    ) -> Panels {
        self.align();
        let at = self.packed.len();
        let mut column = 0;
        while column < columns {
            let width = (2 * self.lanes).min(columns - column);
            for row in 0..inner {
                for c in column..column + width {
                    self.packed.push(source(row, c).map_or(self.zero, |s| s as u32));
                }
            }
            column += width;
        }
        Panels { at, inner, columns }
    }

    fn row(&mut self, width: usize, source: impl Fn(usize) -> Option<u32>) -> usize {
        self.align();
        let at = self.packed.len();
        self.packed.extend((0..width).map(|c| source(c).unwrap_or(self.zero)));
        at
    }
}

/// Hands out places.
#[derive(Default)]
struct Places(usize);

impl Places {
    fn take(&mut self, len: usize) -> usize {
        let at = self.0;
        self.0 = (at + len).next_multiple_of(LANE);
        at
    }
}

impl Plan {
    /// The plan of a checked configuration for vectors of `lanes` numbers.
    pub(crate) fn new(config: &ProNetConfig, lanes: usize) -> Self {
        let list = parameters(config);
        let count: usize = list.iter().map(ParameterShape::len).sum();
        let find = |name: String| list.iter().find(|p| p.name == name).map(|p| p.offset);
        let (zero, one) = (count as u32, count as u32 + 1);
        let mut packer = Packer { lanes, packed: Vec::new(), zero };
        let mut saved = Places::default();
        let mut gradients = Places::default();
        let mut gradient = vec![0u32; count];

        let mut blocks = Vec::new();
        let (mut width_in, mut channels_in, mut time_in) = (1, 1, config.input_length());
        for (i, &channels) in config.channels.iter().enumerate() {
            let (kernel, stride, padding) = (config.kernels[i], config.strides[i], config.paddings[i]);
            let width_out = padded(channels);
            let time_out = (time_in + 2 * padding - kernel) / stride + 1;
            let w = find(format!("conv{}.weight", i + 1)).expect("every block has kernels");
            let source = |channel_out: usize, channel_in: usize, tap: usize| {
                (channel_out < channels && channel_in < channels_in)
                    .then_some(w + (channel_out * channels_in + channel_in) * kernel + tap)
            };
            let weights = packer
                .panels(kernel * width_in, width_out, |row, c| source(c, row % width_in, row / width_in));
            let channel_row = |at: Option<usize>, none: u32| {
                move |c: usize| (c < channels).then(|| at.map_or(none, |at| (at + c) as u32))
            };
            let bias_at = find(format!("conv{}.bias", i + 1));
            let gain_at = find(format!("norm{}.weight", i + 1));
            let offset_at = find(format!("norm{}.bias", i + 1));
            let bias = packer.row(width_out, channel_row(bias_at, zero));
            let gain = packer.row(width_out, channel_row(gain_at, one));
            let offset = packer.row(width_out, channel_row(offset_at, zero));
            let mask = packer.row(width_out, channel_row(None, one));

            let lead = kernel.div_ceil(stride) - 1;
            let (mut phases, mut last_row) = (Vec::new(), time_out - 1);
            if i > 0 {
                for r in 0..stride.min(kernel) {
                    let taps = (kernel - r).div_ceil(stride);
                    let q_first = padding.saturating_sub(r).div_ceil(stride);
                    let Some(q_last) = (time_in - 1 + padding).checked_sub(r).map(|d| d / stride) else {
                        continue;
                    };
                    if q_last < q_first {
                        continue;
                    }
                    last_row = last_row.max(q_last);
                    phases.push(Phase {
                        first: q_first * stride + r - padding,
                        count: q_last - q_first + 1,
                        from: q_first + lead + 1 - taps,
                        weights: packer.panels(taps * width_out, width_in, |row, c| {
                            source(row % width_out, c, r + stride * (taps - 1 - row / width_out))
                        }),
                    });
                }
            }
            let d_weights = gradients.take(kernel * width_in * width_out);
            let d_bias = gradients.take(width_out);
            let d_gain = gradients.take(width_out);
            let d_offset = gradients.take(width_out);
            for channel_out in 0..channels {
                for channel_in in 0..channels_in {
                    for tap in 0..kernel {
                        gradient[w + (channel_out * channels_in + channel_in) * kernel + tap] =
                            (d_weights + (tap * width_in + channel_in) * width_out + channel_out) as u32;
                    }
                }
                for (at, place) in [(bias_at, d_bias), (gain_at, d_gain), (offset_at, d_offset)] {
                    if let Some(at) = at {
                        gradient[at + channel_out] = (place + channel_out) as u32;
                    }
                }
            }
            blocks.push(BlockPlan {
                width_in,
                width_out,
                channels,
                kernel,
                stride,
                padding,
                time_in,
                time_out,
                weights,
                bias,
                gain,
                offset,
                mask,
                phases,
                lead,
                gradient_rows: lead + last_row + 1,
                saved_input: saved.take((time_in + 2 * padding) * width_in),
                saved_conv: saved.take(time_out * width_out),
                saved_stats: saved.take(match config.norm_axes {
                    NormAxes::Channels => 2 * time_out,
                    NormAxes::None => 0,
                }),
                d_weights,
                d_bias,
            });
            (width_in, channels_in, time_in) = (width_out, channels, time_out);
        }
        let saved_last = saved.take(time_in * width_in);

        let pools = match config.pool {
            Pool::Mean | Pool::LogRms => 1,
            Pool::MeanAndRms => 2,
        };
        // A true feature's place among the stored ones: pools are padded apart.
        let place = |feature: usize| feature / channels_in * width_in + feature % channels_in;
        let mut places: Vec<usize> = (0..features(config)).map(place).collect();
        let mut width_in = padded(pools * width_in);
        let mut linears = Vec::new();
        for (i, outputs) in config.hidden.iter().copied().chain([config.head.outputs()]).enumerate() {
            let width_out = padded(outputs);
            let inputs = places.len();
            let w = find(format!("fc{}.weight", i + 1)).expect("every layer has weights");
            let b = find(format!("fc{}.bias", i + 1)).expect("every layer has a bias");
            let mut true_input = vec![None; width_in];
            for (feature, &place) in places.iter().enumerate() {
                true_input[place] = Some(feature);
            }
            let source = |output: usize, stored: usize| {
                true_input[stored].filter(|_| output < outputs).map(|f| w + output * inputs + f)
            };
            let weights = packer.panels(width_in, width_out, |row, c| source(c, row));
            let transposed = packer.panels(width_out, width_in, source);
            let bias = packer.row(width_out, |c| (c < outputs).then_some((b + c) as u32));
            let d_weights = gradients.take(width_in * width_out);
            let d_bias = gradients.take(width_out);
            for output in 0..outputs {
                for (feature, place) in places.iter().enumerate() {
                    gradient[w + output * inputs + feature] = (d_weights + place * width_out + output) as u32;
                }
                gradient[b + output] = (d_bias + output) as u32;
            }
            linears.push(LinearPlan { width_in, width_out, weights, transposed, bias, d_weights, d_bias });
            places = (0..outputs).collect();
            width_in = width_out;
        }
        packer.align();
        Self {
            blocks,
            linears,
            saved_len: saved.0,
            saved_last,
            packed: packer.packed,
            gradient,
            gradient_len: gradients.0,
            parameters: count,
        }
    }
}
