//! The network as a burn module, in primitives that every device of burn knows: what the kernels of this crate are held to, and what learns on
//! other devices than the processor.
//!
//! Blocks of convolution, layer normalisation and leaky ReLU (or the paper's other order), pooling over time, linear layers with
//! leaky ReLU, and a head that turns the last number into a deviation (`plain`).
//!
//! Source: VIO-DualProNet (arXiv 2308.11228), sec. III-B; the open choices are keys of [`ProNetConfig`].

use crate::config::ProNetConfig;
use crate::init::initial_parameters;
use crate::shape::{ParameterShape, parameters};
use burn::module::{Module, Param, ParamId};
use burn::tensor::{Device, Gradients, Tensor, TensorData};
use dpn_core::config::{ConfigFaults, Validate};
use dpn_core::random::Stream;

/// Convolution over time.
#[derive(Module, Debug)]
pub struct Conv {
    /// `[channels out, channels in, kernel]`
    pub weight: Param<Tensor<3>>,
    /// `[channels out]`
    pub bias: Option<Param<Tensor<1>>>,
}

/// Gain and offset of a normalisation.
#[derive(Module, Debug)]
pub struct Norm {
    /// Gain, `[channels]`
    pub weight: Param<Tensor<1>>,
    /// Offset, `[channels]`
    pub bias: Param<Tensor<1>>,
}

/// Linear layer in PyTorch's layout.
#[derive(Module, Debug)]
pub struct Linear {
    /// `[features out, features in]`
    pub weight: Param<Tensor<2>>,
    /// `[features out]`
    pub bias: Param<Tensor<1>>,
}

/// Accel-ProNet or Gyro-ProNet: windows of one axis in, one deviation a window out.
#[derive(Module, Debug)]
pub struct ProNet {
    /// Convolutions, first block first.
    pub conv: Vec<Conv>,
    /// Normalisations, one a block; empty with `norm_axes = "none"`.
    pub norm: Vec<Norm>,
    /// Linear layers, the last with one output.
    pub fc: Vec<Linear>,
    /// What it was made from.
    #[module(skip)]
    config: ProNetConfig,
}

impl ProNet {
    /// A network with the starting weights of `stream` on `device`.
    ///
    /// # Errors
    /// The faults of the configuration.
    pub fn new(config: &ProNetConfig, stream: &Stream, device: &Device) -> Result<Self, ConfigFaults> {
        config.validate()?;
        Ok(Self::of(config, &initial_parameters(config, stream), device))
    }

    /// The network of a checked configuration with flat parameters.
    ///
    /// # Panics
    /// When `flat` has not as many numbers as the network has parameters.
    pub(crate) fn of(config: &ProNetConfig, flat: &[f32], device: &Device) -> Self {
        let list = parameters(config);
        let count: usize = list.iter().map(ParameterShape::len).sum();
        assert_eq!(flat.len(), count, "the network has {count} parameters, not {}", flat.len());
        let find = |name: String| list.iter().enumerate().find(|(_, p)| p.name == name);
        let conv = (1..=config.channels.len())
            .map(|i| Conv {
                weight: find(format!("conv{i}.weight"))
                    .map_or_else(|| unreachable!("every block has a kernel"), |p| param(p, flat, device)),
                bias: find(format!("conv{i}.bias")).map(|p| param(p, flat, device)),
            })
            .collect();
        let norm = (1..=config.channels.len())
            .filter_map(|i| {
                Some(Norm {
                    weight: param(find(format!("norm{i}.weight"))?, flat, device),
                    bias: param(find(format!("norm{i}.bias"))?, flat, device),
                })
            })
            .collect();
        let fc = (1..=config.hidden.len() + 1)
            .filter_map(|i| {
                Some(Linear {
                    weight: param(find(format!("fc{i}.weight"))?, flat, device),
                    bias: param(find(format!("fc{i}.bias"))?, flat, device),
                })
            })
            .collect();
        Self { conv, norm, fc, config: config.clone() }
    }

    /// What the network was made from.
    pub fn config(&self) -> &ProNetConfig {
        &self.config
    }

    /// The device its weights are on.
    pub fn device(&self) -> Device {
        self.fc[0].bias.val().device()
    }

    /// All parameters as numbers, in the order of [`crate::shape::parameters`].
    pub fn parameters(&self) -> Vec<f32> {
        let mut parts = Vec::new();
        for (i, conv) in self.conv.iter().enumerate() {
            parts.push(conv.weight.val().reshape([-1])); // [out * in * kernel]
            parts.extend(conv.bias.iter().map(Param::val)); // [out]
            if let Some(norm) = self.norm.get(i) {
                parts.extend([norm.weight.val(), norm.bias.val()]); // [out], [out]
            }
        }
        for layer in &self.fc {
            parts.push(layer.weight.val().reshape([-1])); // [out * in]
            parts.push(layer.bias.val()); // [out]
        }
        floats(Tensor::cat(parts, 0)) // [parameter count]
    }

    /// The gradient of whatever `gradients` was computed from, in the order of [`Self::parameters`]; zeros for parameters that
    /// it does not depend on.
    pub fn flat_gradient(&self, gradients: &Gradients) -> Vec<f32> {
        fn push<const D: usize>(flat: &mut Vec<f32>, param: &Param<Tensor<D>>, gradients: &Gradients) {
            let value = param.val();
            match value.grad(gradients) {
                Some(gradient) => flat.extend(floats(gradient)),
                None => flat.extend(std::iter::repeat_n(0.0, value.shape().num_elements())),
            }
        }
        let mut flat = Vec::new();
        for (i, conv) in self.conv.iter().enumerate() {
            push(&mut flat, &conv.weight, gradients);
            if let Some(bias) = &conv.bias {
                push(&mut flat, bias, gradients);
            }
            if let Some(norm) = self.norm.get(i) {
                push(&mut flat, &norm.weight, gradients);
                push(&mut flat, &norm.bias, gradients);
            }
        }
        for layer in &self.fc {
            push(&mut flat, &layer.weight, gradients);
            push(&mut flat, &layer.bias, gradients);
        }
        flat
    }

    /// The same network with other flat parameters.
    ///
    /// # Panics
    /// When `flat` has not as many numbers as the network has parameters.
    #[must_use]
    pub fn with_parameters(&self, flat: &[f32]) -> Self {
        Self::of(&self.config, flat, &self.device())
    }
}

/// Numbers of a float tensor, row by row.
pub(crate) fn floats<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data_as::<f32>().iter::<f32>().collect()
}

fn param<const D: usize>(
    (index, p): (usize, &ParameterShape),
    flat: &[f32],
    device: &Device,
) -> Param<Tensor<D>> {
    let numbers = flat[p.offset..p.offset + p.len()].to_vec();
    let tensor = Tensor::from_data(TensorData::new(numbers, p.shape.clone()), device);
    // Numbered, not drawn: burn's own optimiser records then fit any network of the same configuration.
    let tensor = if device.is_autodiff() { tensor.require_grad() } else { tensor };
    Param::initialized(ParamId::from(index as u64), tensor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_go_in_and_come_out_in_their_order() {
        let config = ProNetConfig::default();
        let flat: Vec<f32> = (0..crate::shape::parameter_count(&config)).map(|i| i as f32).collect();
        let net = ProNet::new(&config, &Stream::new(0), &Device::flex()).unwrap().with_parameters(&flat);
        assert_eq!(net.parameters(), flat);
        assert_eq!(net.num_params(), flat.len());
        let other: Vec<f32> = flat.iter().map(|v| -v).collect();
        assert_eq!(net.with_parameters(&other).parameters(), other);
    }

    #[test]
    fn a_configuration_with_faults_makes_no_network() {
        let config = ProNetConfig { kernels: vec![], ..ProNetConfig::default() };
        assert!(ProNet::new(&config, &Stream::new(1), &Device::flex()).is_err());
    }

    /// Layer normalisation over channels divides the amplitude out of the block, so without biases and offsets before it the
    /// network cannot see it (decision 5 of the paper's open points).
    #[test]
    fn over_channels_and_without_biases_amplitude_is_lost() {
        let ratio = |conv_bias| {
            let config = ProNetConfig { conv_bias, ..ProNetConfig::default() };
            let net = ProNet::new(&config, &Stream::new(1), &Device::flex()).unwrap();
            let window: Vec<f32> = (0..200).map(|i| ((i * 37 % 101) as f32 / 50.0 - 1.0) * 0.3).collect();
            let louder: Vec<f32> = window.iter().map(|v| 3.0 * v).collect();
            let both =
                Tensor::<2>::from_data(TensorData::new([window, louder].concat(), [2, 200]), &net.device());
            let sigma = floats(net.forward(both));
            (sigma[1] / sigma[0] - 1.0).abs()
        };
        assert!(ratio(false) < 1e-4 && ratio(true) > 10.0 * ratio(false), "{} {}", ratio(false), ratio(true));
    }

    #[cfg(feature = "ndarray")]
    #[test]
    #[allow(
        deprecated,
        reason = "burn has deprecated its ndarray backend; dpn offers it while it is published"
    )]
    fn flex_and_ndarray_agree_on_a_small_batch() {
        let config = ProNetConfig { window: 60, ..ProNetConfig::default() };
        let run = |device: Device| {
            let device = device.autodiff();
            let net = ProNet::new(&config, &Stream::new(8), &device).unwrap();
            let x: Vec<f32> = (0..5 * 60).map(|i| ((i * 31 % 89) as f32 / 44.0 - 1.0) * 0.2).collect();
            let sigma = net.forward(Tensor::<2>::from_data(TensorData::new(x, [5, 60]), &device));
            let loss = ((sigma.clone() - 0.1) * 10.0).square().mean();
            (floats(sigma), net.flat_gradient(&loss.backward()))
        };
        let (flex, ndarray) = (run(Device::flex()), run(Device::ndarray()));
        for (a, b) in [(flex.0, ndarray.0), (flex.1, ndarray.1)] {
            let largest = a.iter().fold(0f32, |m, v| m.max(v.abs()));
            assert!(largest > 1e-3);
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5 * largest));
        }
    }
}
