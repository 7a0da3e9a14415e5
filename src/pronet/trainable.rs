//! The gradient of a loss: by the kernels of this crate, or by burn on a device of burn's.

use crate::config::ProNetConfig;
use crate::engine::Engine;
#[cfg(feature = "burn")]
use crate::module::{ProNet, floats};
#[cfg(feature = "burn")]
use burn::tensor::{Tensor, TensorData};
use dpn_core::config::{ConfigFaults, Validate};
use std::sync::Arc;

/// Where gradients are computed.
#[derive(Debug, Clone)]
pub enum Device {
    /// The processor, by the kernels of this crate.
    Cpu,
    /// A device of burn that records gradients, by the composition of its primitives.
    #[cfg(feature = "burn")]
    Burn(burn::tensor::Device),
}

#[cfg(feature = "ndarray")]
impl Device {
    /// burn's older CPU backend.
    #[allow(
        deprecated,
        reason = "burn has deprecated its ndarray backend; dpn offers it while it is published"
    )]
    pub fn ndarray() -> Self {
        Self::Burn(burn::tensor::Device::ndarray().autodiff())
    }
}

/// A network to be trained: parameters in, loss and gradient out.
#[derive(Debug)]
pub struct Trainable {
    #[cfg(feature = "burn")]
    config: ProNetConfig,
    device: Device,
    engine: Arc<Engine>,
}

impl Trainable {
    /// The network of `config` on `device`.
    ///
    /// # Errors
    /// The faults of the configuration.
    pub fn new(config: &ProNetConfig, device: &Device) -> Result<Self, ConfigFaults> {
        config.validate()?;
        Ok(Self {
            #[cfg(feature = "burn")]
            config: config.clone(),
            device: device.clone(),
            engine: Arc::new(Engine::new(config)),
        })
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
        match &self.device {
            Device::Cpu => {
                let (answers, saved) = self.engine.forward(parameters, windows);
                let (value, d_answers) = loss(&answers);
                (value, self.engine.backward(&saved, &d_answers))
            }
            #[cfg(feature = "burn")]
            Device::Burn(device) => {
                let network = ProNet::of(&self.config, parameters, device);
                let shape = [windows.len() / self.config.window, self.config.window];
                let answers =
                    network.answers(Tensor::from_data(TensorData::new(windows.to_vec(), shape), device)); // [batch, outputs]
                let (value, d_answers) = loss(&floats(answers.clone()));
                let d_answers = TensorData::new(d_answers, answers.dims());
                let gradients = (answers * Tensor::from_data(d_answers, device)).sum().backward();
                (value, network.flat_gradient(&gradients))
            }
        }
    }
}
