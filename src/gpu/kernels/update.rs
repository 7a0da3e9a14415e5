//! From workgroups' gradients to the next weights.

use crate::plan::UNITS;
use cubecl::prelude::*;

/// Numbers a step has in the table of steps: those of [`crate::Step`].
pub(crate) const STEP: usize = 4;

/// Adam's constants, as bits of single precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Constants {
    pub(crate) parameters: usize,
    pub(crate) keep: [u32; 2],
    pub(crate) take: [u32; 2],
    pub(crate) epsilon: u32,
}

/// Sums the gradients of `groups` workgroups in their order, and the squares of these sums over every workgroup of this kernel.
///
/// # Shapes
/// `partial`: `[networks, groups, parameters + 1]`; out: `gradient`, `[networks, parameters]`; `squares`, `[networks, workgroups]`; `losses`, `[networks, steps]`, of
/// which number `step` is filled with the mean over `count` windows.
#[cube(launch)]
pub(crate) fn gather(
    partial: &[f32],
    gradient: &mut [f32],
    squares: &mut [f32],
    losses: &mut [f32],
    groups: u32,
    step: u32,
    steps: u32,
    count: u32,
    #[comptime] parameters: usize,
) {
    let network = CUBE_POS_Y as usize;
    let at = CUBE_POS_X as usize * UNITS + UNIT_POS as usize;
    let mut sum = 0.0f32;
    if at <= parameters {
        for group in 0..groups as usize {
            sum += partial[(network * groups as usize + group) * comptime!(parameters + 1) + at];
        }
        if at < parameters {
            gradient[network * parameters + at] = sum;
        } else {
            losses[network * steps as usize + step as usize] = sum / f32::cast_from(count);
        }
    }
    let mut shared = Shared::<[f32]>::new_slice(UNITS);
    shared[UNIT_POS as usize] = select(at < parameters, sum * sum, 0.0f32);
    sync_cube();
    if UNIT_POS == 0 {
        let mut all = 0.0f32;
        for i in 0..UNITS {
            all += shared[i];
        }
        squares[network * CUBE_COUNT_X as usize + CUBE_POS_X as usize] = all;
    }
}

/// One step of Adam with a clip over the whole gradient, and the running mean of the weights.
///
/// # Shapes
/// `gradient`, `weights`, `turned`, `averaged`, `mean`, `square`: `[networks, parameters]`; `squares`: `[networks, parts]`; `order`: `[parameters]`, places in the turned
/// copy; `table`: `[networks, steps, STEP]`.
#[cube(launch)]
pub(crate) fn adam(
    gradient: &[f32],
    squares: &[f32],
    order: &[u32],
    table: &[f32],
    weights: &mut [f32],
    turned: &mut [f32],
    averaged: &mut [f32],
    mean: &mut [f32],
    square: &mut [f32],
    parts: u32,
    step: u32,
    steps: u32,
    clip: f32,
    #[comptime] constants: Constants,
) {
    let parameters = comptime!(constants.parameters);
    let network = CUBE_POS_Y as usize;
    let own = CUBE_POS_X as usize * UNITS + UNIT_POS as usize;
    if own < parameters {
        let mut length = 0.0f32;
        for part in 0..parts as usize {
            length += squares[network * parts as usize + part];
        }
        length = length.sqrt();
        let scale = select(clip > 0.0 && length > clip, clip / (length + 1e-6), 1.0f32);
        let at = network * parameters + own;
        let g = gradient[at] * scale;
        let m = comptime!(f32::from_bits(constants.keep[0])) * mean[at]
            + comptime!(f32::from_bits(constants.take[0])) * g;
        let v = comptime!(f32::from_bits(constants.keep[1])) * square[at]
            + comptime!(f32::from_bits(constants.take[1])) * (g * g);
        let of = (network * steps as usize + step as usize) * STEP;
        let root = v.sqrt() * table[of + 2] + comptime!(f32::from_bits(constants.epsilon));
        let w = weights[at] * table[of] - table[of + 1] * m / root;
        mean[at] = m;
        square[at] = v;
        weights[at] = w;
        turned[network * parameters + order[own] as usize] = w;
        averaged[at] = table[of + 3] * averaged[at] + (1.0 - table[of + 3]) * w;
    }
}
