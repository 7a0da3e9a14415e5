//! From a window in the sensor's unit to what the first convolution sees: the same arithmetic as [`crate::module`]'s, for one window.

use crate::config::{Input, ProNetConfig};

/// What preparing a window takes.
#[derive(Debug, Clone)]
pub(crate) struct Preparation {
    input: Input,
    window: usize,
    per_unit: f32,
    length: usize,
    padding: usize,
}

impl Preparation {
    pub(crate) fn new(config: &ProNetConfig) -> Self {
        Self {
            input: config.input,
            window: config.window,
            per_unit: (1.0 / config.input_scale()) as f32,
            length: config.input_length(),
            padding: config.paddings[0],
        }
    }

    /// Fills `out`, `[padding + length + padding]`. `scratch` has room for one window.
    #[inline(always)]
    pub(crate) fn run(&self, window: &[f32], scratch: &mut [f32], out: &mut [f32]) {
        let x = &mut scratch[..self.window];
        for (x, w) in x.iter_mut().zip(window) {
            *x = w * self.per_unit;
        }
        if self.input == Input::Demeaned {
            // Gravity may be three orders above the noise: the mean is taken in double precision.
            let mean = (x.iter().map(|v| f64::from(*v)).sum::<f64>() / x.len() as f64) as f32;
            for v in x.iter_mut() {
                *v -= mean;
            }
        }
        let (before, rest) = out.split_at_mut(self.padding);
        let (inner, after) = rest.split_at_mut(self.length);
        before.fill(0.0);
        after.fill(0.0);
        match self.input {
            Input::Demeaned | Input::Raw => inner.copy_from_slice(x),
            Input::SecondDifferences => {
                for (o, w) in inner.iter_mut().zip(x.windows(3)) {
                    // As two first differences, like the module's.
                    *o = (w[2] - w[1]) - (w[1] - w[0]);
                }
            }
        }
    }
}
