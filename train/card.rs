//! A training's steps and answers on a GPU.

use crate::config::{Loss, TrainConfig};
use crate::draw::DrawRule;
use crate::label::Label;
use crate::levels::LevelKind;
use crate::state::State;
use crate::windows::WindowSet;
use dpn_core::random::Stream;
use dpn_gpu::{Examples, Gpu, GpuError, LevelDraw, Source, Step, Training, Turns};
use dpn_pronet::Trainable;
use dpn_pronet::adam::{Adam, AdamConfig, clip_length};
use rand::Rng;
use std::sync::Arc;

/// Steps that are handed to the card at a time; a stop is heard between two lots.
const STEPS: usize = 32;
/// Samples of examples that lie on the card at a time.
const SAMPLES: usize = 1 << 24;
/// Largest difference between card and processor at the start, in units of the largest number: rounding is a thousandth of it.
const APART: f32 = 1e-2;
/// Longest window that examples are drawn from on the card: what cleans it is made sample by sample.
const LONGEST: usize = 1000;

/// A network on a card.
#[derive(Debug)]
pub(crate) struct OnCard {
    training: Training,
    /// Where the card draws its examples itself.
    source: Option<Arc<Source>>,
    batch: usize,
    adam: AdamConfig,
    /// The same on the processor.
    here: Trainable,
}

impl OnCard {
    /// Tries the card on a few windows against the processor, and brings there what examples are drawn from.
    pub(crate) fn new(
        gpu: &Gpu,
        here: Trainable,
        config: &TrainConfig,
        adam: AdamConfig,
        set: &WindowSet,
        weights: &[f32],
    ) -> Result<Self, GpuError> {
        let loss = match config.fit.loss {
            Loss::Mse => dpn_gpu::Loss::Mse,
            Loss::LogMse => dpn_gpu::Loss::LogMse,
            Loss::LogNll => dpn_gpu::Loss::LogNll,
        };
        let training = Training::new(gpu, &config.network, loss, adam, config.fit.clip_norm);
        let source = drawn(config, set).map(Arc::new);
        let card = Self { training, source, batch: config.fit.batch, adam, here };
        card.try_out(config, set, weights)?;
        Ok(card)
    }

    /// Batches that are handed over at a time.
    pub(crate) fn batches(&self, window: usize) -> usize {
        (SAMPLES / (self.batch * window)).clamp(1, STEPS)
    }

    /// Takes `state` through batches of the examples of `rows`, which `given` has drawn where the card does not; the mean loss of each.
    pub(crate) fn steps(
        &self,
        state: &mut State,
        rows: &[(usize, u64)],
        stream: &Stream,
        given: impl FnOnce() -> (Vec<f32>, Vec<f32>),
        step: impl Fn(u64) -> Step,
    ) -> Result<Vec<f32>, GpuError> {
        let examples = match &self.source {
            Some(source) => {
                let key: u64 = stream.rng().random();
                Examples::Drawn {
                    source: Arc::clone(source),
                    rows: rows.iter().map(|&(window, draw)| [window as u32, draw as u32]).collect(),
                    key: [key as u32, (key >> 32) as u32],
                }
            }
            None => {
                let (windows, labels) = given();
                Examples::Given(windows, labels)
            }
        };
        let first = state.adam.steps();
        let count = rows.len().div_ceil(self.batch) as u64;
        let steps: Vec<Step> = (first..first + count).map(step).collect();
        let [mean, square] = state.adam.state().map(<[f32]>::to_vec);
        let mut on_card =
            dpn_gpu::State { weights: state.weights.clone(), averaged: state.averaged.clone(), mean, square };
        let losses = self.training.steps(&mut on_card, examples, self.batch, &steps)?;
        state.weights = on_card.weights;
        state.averaged = on_card.averaged;
        state.adam = Adam::resumed(self.adam, [on_card.mean, on_card.square], first + count);
        Ok(losses)
    }

    /// What `weights` say of windows, `[rows, window]`: `[rows, outputs]`.
    pub(crate) fn answers(&self, weights: &[f32], windows: Vec<f32>) -> Result<Vec<f32>, GpuError> {
        self.training.answers(weights, windows)
    }

    /// Holds answers and gradients of a few windows to the processor's.
    pub(crate) fn try_out(
        &self,
        config: &TrainConfig,
        set: &WindowSet,
        weights: &[f32],
    ) -> Result<(), GpuError> {
        let rows = set.len().min(self.batch).min(8);
        let windows: Vec<f32> = (0..rows).flat_map(|index| set.raw(index, 0)).map(|v| *v as f32).collect();
        let labels = vec![config.levels().high as f32; rows];
        let mut here = Vec::new();
        let (_, mut gradient) = self.here.gradient(weights, &windows, |answers| {
            here = answers.to_vec();
            crate::loss::loss(config.fit.loss, config.network.output_scale(), answers, &labels)
        });
        if config.fit.clip_norm > 0.0 {
            clip_length(&mut gradient, config.fit.clip_norm);
        }
        let there = self.answers(weights, windows.clone())?;
        self.compare("answers", &here, &there)?;
        let mut state = dpn_gpu::State::new(weights.to_vec());
        let step = [Step { number: 1, rate: 0.0, keep: 0.0 }];
        self.training.steps(&mut state, Examples::Given(windows, labels), rows, &step)?;
        // A first step's mean gradient is a share of the gradient.
        let share = (1.0 - self.adam.beta1) as f32;
        let there: Vec<f32> = state.mean.iter().map(|mean| mean / share).collect();
        self.compare("gradients", &gradient, &there)
    }

    fn compare(&self, what: &'static str, here: &[f32], there: &[f32]) -> Result<(), GpuError> {
        let apart = apart(here, there);
        if apart <= APART || here.iter().any(|v| !v.is_finite()) {
            return Ok(());
        }
        let adapter = self.training.gpu().adapter().to_owned();
        Err(GpuError::Wrong { adapter, what, apart: format!("{apart:.1e}") })
    }
}

/// Largest difference in units of the largest number `here`; what is no number there is far off.
fn apart(here: &[f32], there: &[f32]) -> f32 {
    let largest = here.iter().fold(f32::MIN_POSITIVE, |most, v| most.max(v.abs()));
    let each = here.iter().zip(there).map(|(a, b)| (a - b).abs() / largest);
    each.map(|apart| if apart.is_nan() { f32::INFINITY } else { apart }).fold(0.0, f32::max)
}

/// What the card draws from, where its kernel knows all that the rule asks for: recorded windows, cleaned and turned about, under white noise that alone is labelled.
fn drawn(config: &TrainConfig, set: &WindowSet) -> Option<Source> {
    let DrawRule { levels, label, vibration: _, sensor, span: _, rate: _, augment } = config.draw_rule();
    if label != Label::Injected
        || sensor.is_some()
        || set.window() > LONGEST
        || config.fit.draws_per_window > 1 << 16
    {
        return None;
    }
    let kind = match levels.kind {
        LevelKind::Grid => LevelDraw::Grid(levels.steps as u32),
        LevelKind::Uniform => LevelDraw::Uniform,
        LevelKind::LogUniform => LevelDraw::LogUniform,
    };
    let turns = Turns {
        offset: augment.offset,
        sign: augment.sign,
        reverse: augment.reverse,
        grow_share: augment.grow_share,
        factors: [augment.shrink, augment.grow],
    };
    let (samples, places) = set.recorded();
    Some(Source::new(set.window(), samples, places, &set.filters(), (kind, [levels.low, levels.high]), turns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_none_is_far_off_wherever_it_stands() {
        let here = [1.0, -4.0, 2.0];
        assert_eq!(apart(&here, &[1.0, -4.0, 3.0]), 0.25);
        for at in 0..3 {
            let mut there = here;
            there[at] = f32::NAN;
            assert_eq!(apart(&here, &there), f32::INFINITY);
        }
    }
}
