//! From a window in the sensor's unit to what the first convolution sees: the same arithmetic as [`crate::module`]'s, for one window.

use crate::config::{Edges, Input, ProNetConfig, Standardise};
use crate::definition::SCALE_EPSILON;

/// What preparing a window takes.
#[derive(Debug, Clone)]
pub(crate) struct Preparation {
    input: Input,
    standardise: Standardise,
    edges: Edges,
    window: usize,
    per_unit: f32,
    planes: usize,
    length: usize,
    padding: usize,
}

impl Preparation {
    pub(crate) fn new(config: &ProNetConfig) -> Self {
        Self {
            input: config.input,
            standardise: config.standardise,
            edges: config.edges,
            window: config.window,
            per_unit: (1.0 / config.input_scale()) as f32,
            planes: config.input_channels(),
            length: config.input_length(),
            padding: config.paddings[0],
        }
    }

    /// Whether windows are divided by a scale of their own.
    pub(crate) fn standardises(&self) -> bool {
        self.standardise != Standardise::None
    }

    /// Fills `out`, `[padding + length + padding, planes]`, and returns the window's own scale (1 where there is none).
    ///
    /// `scratch` has room for one window.
    #[inline(always)]
    pub(crate) fn run(&self, window: &[f32], scratch: &mut [f32], out: &mut [f32]) -> f32 {
        let x = &mut scratch[..self.window];
        for (x, w) in x.iter_mut().zip(window) {
            *x = w * self.per_unit;
        }
        if matches!(self.input, Input::Demeaned | Input::DemeanedAndSecondDifferences) {
            // Gravity may be three orders above the noise: the mean is taken in double precision.
            let mean = (x.iter().map(|v| f64::from(*v)).sum::<f64>() / x.len() as f64) as f32;
            for v in x.iter_mut() {
                *v -= mean;
            }
        }
        let scale = match self.standardise {
            Standardise::None => 1.0,
            Standardise::Rms => root_mean_square(x.iter().copied(), x.len()),
            Standardise::SecondDifferences => {
                root_mean_square(x.windows(3).map(second_difference), x.len() - 2)
            }
        };
        if self.standardise != Standardise::None {
            for v in x.iter_mut() {
                *v /= scale;
            }
        }
        let (planes, length, padding) = (self.planes, self.length, self.padding);
        let inner = &mut out[padding * planes..(padding + length) * planes];
        match self.input {
            Input::Demeaned | Input::Raw => inner.copy_from_slice(x),
            Input::Differences => {
                for (o, w) in inner.iter_mut().zip(x.windows(2)) {
                    *o = w[1] - w[0];
                }
            }
            Input::SecondDifferences => {
                for (o, w) in inner.iter_mut().zip(x.windows(3)) {
                    *o = second_difference(w);
                }
            }
            Input::BothDifferences => {
                for (o, w) in inner.chunks_exact_mut(2).zip(x.windows(3)) {
                    o[0] = w[1] - w[0];
                    o[1] = second_difference(w);
                }
            }
            Input::DemeanedAndSecondDifferences => {
                for (o, v) in inner.chunks_exact_mut(2).zip(x.iter()) {
                    (o[0], o[1]) = (*v, 0.0);
                }
                for (o, w) in inner.chunks_exact_mut(2).skip(1).zip(x.windows(3)) {
                    o[1] = second_difference(w);
                }
            }
        }
        match self.edges {
            Edges::Zero => {
                out[..padding * planes].fill(0.0);
                out[(padding + length) * planes..].fill(0.0);
            }
            Edges::Odd => {
                for plane in 0..planes {
                    let at = |t: usize| t * planes + plane;
                    let (first, last) = (padding, padding + length - 1);
                    for i in 1..=padding {
                        out[at(first - i)] = 2.0 * out[at(first)] - out[at(first + i)];
                        out[at(last + i)] = 2.0 * out[at(last)] - out[at(last - i)];
                    }
                }
            }
        }
        scale
    }
}

#[inline(always)]
fn second_difference(w: &[f32]) -> f32 {
    // As two first differences, like the module's.
    (w[2] - w[1]) - (w[1] - w[0])
}

#[inline(always)]
fn root_mean_square(values: impl Iterator<Item = f32>, count: usize) -> f32 {
    let mean = values.map(|v| f64::from(v) * f64::from(v)).sum::<f64>() / count as f64;
    (mean as f32 + SCALE_EPSILON).sqrt()
}
