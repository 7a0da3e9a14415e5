//! What a chunk of windows, which one thread takes, needs and leaves behind; the passes are [`forward`](super::forward) and
//! [`backward`](super::backward).

use super::buffer::{Buffer, zeros};
use super::head::HeadKind;
use super::input::Preparation;
use super::norm::NormKind;
use super::plan::Plan;
use crate::config::Pool;

/// What a forward pass needs besides the weights.
#[derive(Debug, Clone)]
pub(crate) struct Arithmetic {
    pub(crate) plan: Plan,
    pub(crate) preparation: Preparation,
    pub(crate) norm: NormKind,
    pub(crate) head: HeadKind,
    pub(crate) pool: Pool,
    pub(crate) window: usize,
}

/// What a forward pass over a chunk leaves behind for the backward pass.
#[derive(Debug, Clone, Default)]
pub(crate) struct Chunk {
    count: usize,
    pub(super) saved: Buffer,
    /// Features, then every linear layer's output (after its leaky ReLU): `[count, width]` each.
    pub(super) levels: Vec<Buffer>,
    pub(super) scratch: Vec<f32>,
}

impl Chunk {
    /// Makes room for `count` windows; `keep` says whether each window keeps what the backward pass needs.
    pub(crate) fn fit(&mut self, of: &Arithmetic, count: usize, keep: bool) {
        let plan = &of.plan;
        let slots = if keep { count } else { 1 };
        let room = slots * plan.saved_len;
        if self.saved.len() < room {
            // Time paddings inside are zero here and are never written.
            self.saved = zeros(room);
        }
        if self.count != count || self.levels.is_empty() {
            let widths = plan.linears.iter().map(|l| l.width_out);
            let first = plan.linears[0].width_in;
            self.levels = std::iter::once(first).chain(widths).map(|w| zeros(count * w)).collect();
            self.scratch = vec![0.0; of.window];
            self.count = count;
        }
    }
}
