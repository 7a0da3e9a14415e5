//! Batches through the networks: a workgroup takes every so many windows of one network forth and, to learn from, back.

use super::tail::Loss;
use super::{add, conv, norm, tail, window};
use crate::plan::{Plan, UNITS};
use cubecl::prelude::*;

/// What a pass is compiled for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Job {
    pub(crate) plan: Plan,
    /// What is minimised; nothing where answers are all that is wanted.
    pub(crate) loss: Option<Loss>,
    /// Whether the near arena is shared memory.
    pub(crate) shared: bool,
}

/// Windows `from..from + count` of `rows` that every network has.
///
/// # Shapes
/// `weights` and `turned`: `[networks, parameters]`; `windows`: `[networks, rows, window]`; `labels`: `[networks, rows]`; `units`: `[networks, 2]`, the inverse of the
/// input's scale and the scale of the answer. `near_room` and `far_room`: `[networks, workgroups, numbers]`. Out: `gradients`,
/// `[networks, workgroups, parameters + 1]`, sums over each workgroup's windows and after them of their losses; or `gradients` as answers, `[networks, rows, outputs]`.
#[cube(launch)]
pub(crate) fn pass(
    weights: &[f32],
    turned: &[f32],
    windows: &[f32],
    labels: &[f32],
    units: &[f32],
    near_room: &mut [f32],
    far_room: &mut [f32],
    out: &mut [f32],
    from: u32,
    count: u32,
    rows: u32,
    #[comptime] job: Job,
) {
    let network = CUBE_POS_Y as usize;
    let group = network * CUBE_COUNT_X as usize + CUBE_POS_X as usize;
    let parameters = comptime!(job.plan.parameters);
    let weights = &weights[network * parameters..(network + 1) * parameters];
    let turned = &turned[network * parameters..(network + 1) * parameters];
    let far = &mut far_room[group * comptime!(job.plan.far)..(group + 1) * comptime!(job.plan.far)];
    if comptime!(job.shared) {
        let mut near = Shared::<[f32]>::new_slice(comptime!(job.plan.near));
        windows_of(
            &mut near, far, weights, turned, windows, labels, units, out, from, count, rows, network, group,
            job,
        );
    } else {
        let near = &mut near_room[group * comptime!(job.plan.near)..(group + 1) * comptime!(job.plan.near)];
        windows_of(
            near, far, weights, turned, windows, labels, units, out, from, count, rows, network, group, job,
        );
    }
}

#[cube]
fn windows_of(
    near: &mut [f32],
    far: &mut [f32],
    weights: &[f32],
    turned: &[f32],
    windows: &[f32],
    labels: &[f32],
    units: &[f32],
    out: &mut [f32],
    from: u32,
    count: u32,
    rows: u32,
    network: usize,
    group: usize,
    #[comptime] job: Job,
) {
    let plan = comptime!(job.plan.clone());
    let mut at = UNIT_POS as usize;
    while at < comptime!(plan.near) {
        near[at] = 0.0f32;
        at += UNITS;
    }
    sync_storage();
    let (per_unit, unit) = (units[2 * network], units[2 * network + 1]);
    let last = comptime!(*plan.linears.last().expect("a network has a last layer"));
    let outputs = comptime!(last.outputs);
    let mut taken = CUBE_POS_X;
    while taken < count {
        let row = network * rows as usize + (from + taken) as usize;
        let one = &windows[row * comptime!(plan.window)..(row + 1) * comptime!(plan.window)];
        window::prepare(near, one, per_unit, comptime!(plan.clone()));
        blocks(near, far, weights, 0usize, comptime!(plan.clone()));
        tail::pool(near, comptime!(plan.clone()));
        linears(near, weights, 0usize, comptime!(plan.clone()));
        if comptime!(job.loss.is_none()) {
            if UNIT_POS == 0 {
                let z = near[comptime!(last.to)];
                out[row * outputs] = tail::sigma(z, unit, comptime!(plan.head), comptime!(plan.leak));
                if comptime!(outputs == 2) {
                    out[row * outputs + 1] = tail::spread(near[comptime!(last.to + 1)]);
                }
            }
            sync_storage();
        } else {
            let first = taken == CUBE_POS_X;
            let length = comptime!(plan.parameters + 1);
            let gradient = &mut out[group * length..(group + 1) * length];
            if UNIT_POS == 0 {
                let share = 1.0 / f32::cast_from(count);
                let kind = comptime!(job.loss.expect("asked above"));
                let value = tail::loss(
                    near,
                    labels[row],
                    unit,
                    share,
                    comptime!(last.to),
                    kind,
                    comptime!(plan.head),
                    comptime!(plan.leak),
                );
                add(gradient, comptime!(plan.parameters), value, first);
            }
            sync_storage();
            linears_back(
                near,
                turned,
                gradient,
                first,
                comptime!(plan.linears.len()),
                comptime!(plan.clone()),
            );
            tail::pool_back(near, far, weights, comptime!(plan.clone()));
            blocks_back(
                near,
                far,
                weights,
                turned,
                gradient,
                first,
                comptime!(plan.blocks.len()),
                comptime!(plan.clone()),
            );
        }
        taken += CUBE_COUNT_X;
    }
}

/// Blocks from number `i` on.
#[cube]
fn blocks(near: &mut [f32], far: &mut [f32], weights: &[f32], #[comptime] i: usize, #[comptime] plan: Plan) {
    if comptime!(i < plan.blocks.len()) {
        let block = comptime!(plan.blocks[i]);
        conv::convolve(near, weights, block);
        norm::finish(near, far, weights, block, comptime!(plan.leak));
        blocks(near, far, weights, comptime!(i + 1), plan);
    }
}

/// Linear layers from number `i` on.
#[cube]
fn linears(near: &mut [f32], weights: &[f32], #[comptime] i: usize, #[comptime] plan: Plan) {
    if comptime!(i < plan.linears.len()) {
        tail::linear(near, weights, comptime!(plan.linears[i]), comptime!(plan.leak));
        linears(near, weights, comptime!(i + 1), plan);
    }
}

/// Back through the first `n` linear layers, to the features.
#[cube]
fn linears_back(
    near: &mut [f32],
    turned: &[f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] n: usize,
    #[comptime] plan: Plan,
) {
    if comptime!(n > 0) {
        let features = comptime!((n == 1).then_some(plan.d_features));
        tail::linear_back(
            near,
            turned,
            gradient,
            first,
            comptime!(plan.linears[n - 1]),
            features,
            comptime!(plan.leak),
        );
        linears_back(near, turned, gradient, first, comptime!(n - 1), plan);
    }
}

/// Back through the first `n` blocks; the gradient of the last one's output stands in its place.
#[cube]
fn blocks_back(
    near: &mut [f32],
    far: &mut [f32],
    weights: &[f32],
    turned: &[f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] n: usize,
    #[comptime] plan: Plan,
) {
    let block = comptime!(plan.blocks[n - 1]);
    norm::back(near, far, weights, gradient, first, comptime!(plan.sums), block, comptime!(plan.leak));
    conv::convolve_weights(near, gradient, first, block);
    if comptime!(n > 1) {
        norm::enter_from(
            near,
            far,
            weights,
            turned,
            comptime!(plan.blocks[n - 2]),
            block,
            comptime!(plan.leak),
        );
        blocks_back(near, far, weights, turned, gradient, first, comptime!(n - 1), plan);
    }
}
