//! The gradient of a loss, by the kernels of this crate.

use crate::config::ProNetConfig;
use crate::engine::Engine;
use dpn_core::config::{ConfigFaults, Validate};
use std::sync::Arc;

/// A network to be trained: parameters in, loss and gradient out.
#[derive(Debug)]
pub struct Trainable {
    engine: Arc<Engine>,
}

impl Trainable {
    /// The network of `config`.
    ///
    /// # Errors
    /// The faults of the configuration.
    pub fn new(config: &ProNetConfig) -> Result<Self, ConfigFaults> {
        config.validate()?;
        Ok(Self { engine: Arc::new(Engine::new(config)) })
    }

    /// What `loss` says of the answers to a batch, and the gradient of that with respect to the parameters.
    ///
    /// # Shapes
    /// `parameters`: in the order of [`crate::shape::parameters`]; `windows`: `[batch, window]`. `loss` takes the answers, `[batch, outputs]`
    /// ([`outputs`](crate::config::Head::outputs) of the head), and returns its value with its derivatives with respect to them.
    ///
    /// # Units and frames
    /// Windows and the first answer of each, a deviation, in m/s^2 or rad/s.
    ///
    /// # Panics
    /// On another number of parameters than the network has.
    pub fn gradient(
        &self,
        parameters: &[f32],
        windows: &[f32],
        loss: impl FnOnce(&[f32]) -> (f64, Vec<f32>),
    ) -> (f64, Vec<f32>) {
        let (answers, saved) = self.engine.forward(parameters, windows);
        let (value, d_answers) = loss(&answers);
        (value, self.engine.backward(&saved, &d_answers))
    }
}
