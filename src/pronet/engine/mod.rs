//! The network without burn: flat parameters in, answers (deviations, and how sure the network is of them) and gradients out, on this machine's vectors.
//!
//! One pass takes a window through all blocks while it is in the cache. Rows are time steps and channels are contiguous, so that layer
//! normalisation over channels reads one row, and a convolution is a matrix product whose left factor is a view of its padded input
//! ([`kernel`]). The backward pass is written out by hand: weight gradients are one product with that same view, input gradients one
//! product for every phase of the stride ([`plan::Phase`]).
//!
//! Results are the same bits for any number of threads, but not across machines: wider vectors sum in another order.

#[cfg(feature = "train")]
mod backward;
#[cfg(feature = "train")]
mod batch;
mod buffer;
mod chunk;
mod forward;
mod head;
mod input;
mod kernel;
mod norm;
mod plan;
mod pool;
#[cfg(feature = "train")]
mod rooms;

use crate::config::ProNetConfig;
pub(crate) use buffer::Buffer;
use chunk::Arithmetic;
pub(crate) use chunk::Chunk;
use forward::Forward;
use head::HeadKind;
use input::Preparation;
use norm::NormKind;
use plan::Plan;
use pulp::{Arch, Simd, WithSimd};

/// Runs one configuration's network.
#[derive(Debug)]
pub(crate) struct Engine {
    arch: Arch,
    of: Arithmetic,
    #[cfg(feature = "train")]
    rooms: rooms::Rooms,
}

struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

impl Engine {
    /// The engine of a checked configuration.
    pub(crate) fn new(config: &ProNetConfig) -> Self {
        Self::on(config, Arch::new())
    }

    fn on(config: &ProNetConfig, arch: Arch) -> Self {
        Self {
            arch,
            of: Arithmetic {
                plan: Plan::new(config, arch.dispatch(Lanes)),
                preparation: Preparation::new(config),
                norm: NormKind {
                    order: config.block_order,
                    axes: config.norm_axes,
                    leak: config.leak as f32,
                },
                head: HeadKind::new(config),
                pool: config.pool,
                window: config.window,
            },
            #[cfg(feature = "train")]
            rooms: rooms::Rooms::default(),
        }
    }

    /// Arranges flat parameters for the kernels.
    pub(crate) fn pack(&self, flat: &[f32], packed: &mut Buffer) {
        let plan = &self.of.plan;
        let mut numbers = flat[..plan.parameters].to_vec();
        numbers.extend([0.0, 1.0]);
        packed.resize(plan.packed.len());
        for (to, from) in packed.iter_mut().zip(&plan.packed) {
            *to = numbers[*from as usize];
        }
    }

    /// Answers to a few windows with packed weights, on this thread, leaving nothing behind.
    ///
    /// # Shapes
    /// `windows`: `[count, window]`; `answers`: `[count, outputs]`.
    pub(crate) fn infer(&self, packed: &Buffer, windows: &[f32], chunk: &mut Chunk, answers: &mut [f32]) {
        chunk.fit(&self.of, windows.len() / self.of.window, false);
        self.arch.dispatch(Forward { of: &self.of, packed, windows, keep: false, chunk, answers });
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::init::initial_parameters;
    use dpn_core::random::Stream;
    use rand::Rng;
    use std::sync::Arc;

    fn config() -> ProNetConfig {
        ProNetConfig {
            kernels: vec![9, 5, 3],
            strides: vec![1, 4, 2],
            paddings: vec![4, 2, 1],
            channels: vec![20, 32, 64],
            ..ProNetConfig::default()
        }
    }

    fn windows(count: usize) -> Vec<f32> {
        let mut rng = Stream::new(3).rng();
        (0..count * 200).map(|_| rng.random::<f32>() - 0.5).collect()
    }

    /// Deviations, and their gradient with weights 1, 2, ..
    fn pass(engine: &Arc<Engine>, count: usize) -> (Vec<f32>, Vec<f32>) {
        let flat = initial_parameters(&config(), &Stream::new(1));
        let (sigma, saved) = engine.forward(&flat, &windows(count));
        let d: Vec<f32> = (0..count).map(|i| 1.0 + i as f32).collect();
        let gradient = engine.backward(&saved, &d);
        (sigma, gradient)
    }

    #[test]
    fn vectors_of_any_width_give_the_same_to_rounding() {
        let (sigma, gradient) = pass(&Arc::new(Engine::on(&config(), Arch::Scalar)), 17);
        let (s, g) = pass(&Arc::new(Engine::new(&config())), 17);
        let largest = gradient.iter().fold(0f32, |m, v| m.max(v.abs()));
        assert!(largest > 0.1);
        assert!(sigma.iter().zip(&s).all(|(a, b)| (a - b).abs() < 1e-6 * a.abs()));
        assert!(gradient.iter().zip(&g).all(|(a, b)| (a - b).abs() < 1e-5 * largest));
    }

    #[test]
    fn a_used_room_leaves_no_trace_in_the_next_pass() {
        let engine = Arc::new(Engine::new(&config()));
        let fresh = pass(&engine, 30);
        for count in [1, 100, 9, 30] {
            let again = pass(&engine, count);
            let common = count.min(30);
            assert_eq!(again.0[..common], fresh.0[..common]);
        }
        assert_eq!(pass(&engine, 30), fresh);
    }

    #[test]
    fn one_state_goes_back_twice_to_the_same_bits() {
        let engine = Arc::new(Engine::new(&config()));
        let flat = initial_parameters(&config(), &Stream::new(1));
        let (_, saved) = engine.forward(&flat, &windows(20));
        assert_eq!(engine.backward(&saved, &[1.0; 20]), engine.backward(&saved, &[1.0; 20]));
    }

    #[test]
    fn no_windows_are_no_deviations_and_no_gradient() {
        let (sigma, gradient) = pass(&Arc::new(Engine::new(&config())), 0);
        assert!(sigma.is_empty());
        assert!(gradient.iter().all(|g| *g == 0.0));
    }
}
