//! From a window in the sensor's unit to what the first convolution sees.

use crate::plan::{Plan, UNITS};
use cubecl::prelude::*;
use dpn_pronet::config::Input;

/// Units that sum up a window for its mean.
const SUMMING: usize = 32;

/// Fills the first block's input, behind its padding.
///
/// # Shapes
/// `window`: `[window]`.
#[cube]
pub(crate) fn prepare(near: &mut [f32], window: &[f32], per_unit: f32, #[comptime] plan: Plan) {
    let unit = UNIT_POS as usize;
    let to = comptime!(plan.blocks[0].from + plan.blocks[0].padding);
    let length = comptime!(plan.length);
    match comptime!(plan.input) {
        Input::Raw => {
            let mut t = unit;
            while t < length {
                near[to + t] = window[t] * per_unit;
                t += UNITS;
            }
        }
        Input::SecondDifferences => {
            let mut t = unit;
            while t < length {
                let middle = window[t + 1] * per_unit;
                near[to + t] = (window[t + 2] * per_unit - middle) - (middle - window[t] * per_unit);
                t += UNITS;
            }
        }
        Input::Demeaned => {
            // Gravity may be three orders above the noise: what is summed is the distance from the first sample.
            let sums = comptime!(plan.sums);
            let first = window[0] * per_unit;
            if unit < SUMMING {
                let mut sum = 0.0f32;
                let mut t = unit;
                while t < length {
                    sum += window[t] * per_unit - first;
                    t += SUMMING;
                }
                near[sums + unit] = sum;
            }
            sync_storage();
            let mut mean = 0.0f32;
            for i in 0..SUMMING {
                mean += near[sums + i];
            }
            mean /= comptime!(length as f32);
            let mut t = unit;
            while t < length {
                near[to + t] = (window[t] * per_unit - first) - mean;
                t += UNITS;
            }
        }
    }
    sync_storage();
}
