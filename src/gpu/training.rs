//! One network's training on a card, from the side of whoever trains it.

use crate::card::Gpu;
use crate::engine::{Asked, Shape, Steps, Wanted};
use crate::error::GpuError;
use crate::kernels::pass::Job;
use crate::kernels::tail::Loss;
use crate::kernels::update::Constants;
use crate::plan::Plan;
use crate::state::{Examples, State, Step};
use dpn_pronet::{AdamConfig, ProNetConfig};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, channel};

/// A training on a card. Those that are there at the same time and of one shape take their steps together.
#[derive(Debug)]
pub struct Training {
    gpu: Gpu,
    shape: Arc<Shape>,
    adam: AdamConfig,
    units: [f32; 2],
}

impl Training {
    /// A training of the checked `config`; `clip` is the longest gradient, 0 for any.
    pub fn new(gpu: &Gpu, config: &ProNetConfig, loss: Loss, adam: AdamConfig, clip: f64) -> Self {
        let plan = Plan::new(config);
        let (flat, turned) = plan.orders();
        let bits = |number: f64| (number as f32).to_bits();
        let constants = Constants {
            parameters: plan.parameters,
            keep: [adam.beta1, adam.beta2].map(bits),
            take: [adam.beta1, adam.beta2].map(|beta| bits(1.0 - beta)),
            epsilon: bits(adam.epsilon),
        };
        let job = Job { plan, loss: Some(loss), shared: false };
        gpu.trainings.fetch_add(1, Ordering::Relaxed);
        Self {
            gpu: gpu.clone(),
            shape: Arc::new(Shape { job, constants, flat, turned, clip: clip as f32 }),
            adam,
            units: [(1.0 / config.input_scale()) as f32, config.output_scale() as f32],
        }
    }

    /// The card.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Takes `state` one step further a batch of the examples; the mean loss of each batch.
    ///
    /// # Shapes
    /// `steps`: one a batch of `batch` examples, the last of which may be smaller.
    ///
    /// # Errors
    /// A card that fails; then `state` is as before.
    pub fn steps(
        &self,
        state: &mut State,
        examples: Examples,
        batch: usize,
        steps: &[Step],
    ) -> Result<Vec<f32>, GpuError> {
        assert_eq!(examples.rows().div_ceil(batch), steps.len(), "a step a batch");
        let table = steps.iter().flat_map(|step| self.row(step)).collect();
        let (reply, answer) = channel();
        self.gpu.want(Wanted::Steps(Box::new(Steps {
            shape: Arc::clone(&self.shape),
            units: self.units,
            state: state.clone(),
            examples,
            batch,
            table,
            reply,
        })))?;
        let (next, losses) = self.wait(&answer)?;
        *state = next;
        Ok(losses)
    }

    /// What the network says of `windows`, `[rows, window]`: `[rows, outputs]`.
    ///
    /// # Errors
    /// A card that fails.
    pub fn answers(&self, weights: &[f32], windows: Vec<f32>) -> Result<Vec<f32>, GpuError> {
        let (reply, answer) = channel();
        let shape = Arc::clone(&self.shape);
        let asked = Asked { shape, units: self.units, weights: weights.to_vec(), windows, reply };
        self.gpu.want(Wanted::Answers(asked))?;
        self.wait(&answer)
    }

    fn wait<T>(&self, answer: &Receiver<Result<T, GpuError>>) -> Result<T, GpuError> {
        answer.recv().map_err(|_| self.gpu.lost())?
    }

    /// A step as the kernel of [`Adam`](dpn_pronet::Adam) reads it: what weights keep, the step's size, the correction of the root, what the running mean keeps.
    fn row(&self, step: &Step) -> [f32; 4] {
        let correction = |beta: f64| 1.0 - beta.powf(step.number as f64);
        [
            (1.0 - step.rate * self.adam.weight_decay) as f32,
            (step.rate / correction(self.adam.beta1)) as f32,
            (1.0 / correction(self.adam.beta2).sqrt()) as f32,
            step.keep as f32,
        ]
    }
}

impl Drop for Training {
    fn drop(&mut self) {
        self.gpu.trainings.fetch_sub(1, Ordering::Relaxed);
    }
}
