//! The whole network as one operation of burn's CPU backend, with its backward pass.
//!
//! The operation takes the windows (constants) and the flat parameters (one tensor, joined by burn, which splits their gradient
//! again); its numbers come from [`crate::engine`]. Tensors of any other device, windows that want a gradient of their own, and
//! gradient checkpointing take the module's plain composition.

use crate::engine::{Engine, Saved};
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::NoCheckpointing;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind, unary};
use burn::backend::ops::FloatTensorOps;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Flex};
use burn::tensor::{Tensor, TensorData};
use std::sync::Arc;

type Differentiable = Autodiff<Flex, NoCheckpointing>;

/// The answer to each window by the kernels, window by window (`[batch * outputs]`); `flat` are the parameters. `None` where windows or parameters are not on burn's CPU backend, or
/// windows want a gradient.
pub(crate) fn forward(engine: &Arc<Engine>, flat: &Tensor<1>, windows: &Tensor<2>) -> Option<Tensor<1>> {
    if let (Ok(x), Ok(flat)) = (
        windows.clone().try_into_primitive::<Differentiable>(),
        flat.clone().try_into_primitive::<Differentiable>(),
    ) && !x.is_tracked()
    {
        let (flat, node) = flat.into_parts();
        let (sigma, saved) = engine.forward(&numbers(&flat), &numbers(x.primitive()));
        let sigma = tensor(sigma);
        let sigma = match Step.prepare::<NoCheckpointing>([node]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((Arc::clone(engine), Arc::new(saved)), sigma),
            OpsKind::UnTracked(prep) => prep.finish(sigma),
        };
        return Some(Tensor::from_primitive::<Differentiable>(sigma));
    }
    let x = windows.clone().try_into_primitive::<Flex>().ok()?;
    let flat = flat.clone().try_into_primitive::<Flex>().ok()?;
    Some(Tensor::from_primitive::<Flex>(tensor(engine.forward(&numbers(&flat), &numbers(&x)).0)))
}

/// The operation's step back: from the answers' gradient to the flat parameters'.
#[derive(Debug)]
struct Step;

impl Backward<Flex, 1> for Step {
    type State = (Arc<Engine>, Arc<Saved>);

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _: &mut Checkpointer) {
        let (engine, saved) = ops.state;
        unary::<Flex, _>(ops.parents, ops.node, grads, |d_sigma| {
            tensor(engine.backward(&saved, &numbers(&d_sigma)))
        });
    }
}

fn numbers(tensor: &FloatTensor<Flex>) -> Vec<f32> {
    tensor.to_contiguous().as_slice::<f32>().expect("the network is single precision").to_vec()
}

fn tensor(numbers: Vec<f32>) -> FloatTensor<Flex> {
    let len = numbers.len();
    Flex::float_from_data(TensorData::new(numbers, [len]), &Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{BlockOrder, Head, Input, NormAxes, Pool, ProNetConfig};
    use crate::module::ProNet;
    use burn::tensor::Device;
    use dpn_core::config::Validate;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand::seq::IndexedRandom;

    fn pick<T: Copy>(choices: &[T], rng: &mut impl Rng) -> T {
        *choices.choose(rng).unwrap()
    }

    /// A small network with every choice drawn.
    pub(crate) fn random_config(rng: &mut impl Rng) -> ProNetConfig {
        let blocks = rng.random_range(1..=3);
        let mut config = ProNetConfig {
            window: rng.random_range(30..60),
            input: pick(&Input::ALL, rng),
            block_order: pick(&BlockOrder::ALL, rng),
            norm_axes: pick(&NormAxes::ALL, rng),
            channels: (0..blocks).map(|_| pick(&[1, 3, 16, 19, 32, 48, 64], rng)).collect(),
            kernels: (0..blocks).map(|_| rng.random_range(1..8)).collect(),
            strides: (0..blocks).map(|_| rng.random_range(1..4)).collect(),
            paddings: vec![0; blocks],
            conv_bias: rng.random(),
            leak: pick(&[0.0, 0.01, 0.1, 1.0], rng),
            pool: pick(&Pool::ALL, rng),
            hidden: (0..rng.random_range(0..4)).map(|_| pick(&[1, 5, 16, 33], rng)).collect(),
            head: pick(&Head::ALL, rng),
            ..ProNetConfig::default()
        };
        for (p, k) in config.paddings.iter_mut().zip(&config.kernels) {
            *p = rng.random_range(0..*k);
        }
        config
    }

    fn windows(count: usize, length: usize, rng: &mut impl Rng) -> Vec<f32> {
        (0..count * length).map(|_| 0.2 * (rng.random::<f32>() - 0.5)).collect()
    }

    fn loss_gradient(net: &ProNet, answers: Tensor<2>) -> Vec<f32> {
        let [count, outputs] = answers.dims();
        let weights: Vec<f32> = (0..count * outputs).map(|i| 1.0 + i as f32 / count as f32).collect();
        let weights = Tensor::from_data(TensorData::new(weights, [count, outputs]), &answers.device());
        let loss = ((answers * 10.0 - 0.3).square() * weights).mean();
        net.flat_gradient(&loss.backward())
    }

    /// Largest difference in units of the largest number.
    fn relative(a: &[f32], b: &[f32]) -> f32 {
        assert_eq!(a.len(), b.len());
        assert!(a.iter().chain(b).all(|v| v.is_finite()), "not finite");
        let largest = a.iter().chain(b).fold(1e-30f32, |m, v| m.max(v.abs()));
        a.iter().zip(b).fold(0f32, |m, (x, y)| m.max((x - y).abs())) / largest
    }

    #[test]
    fn fused_and_plain_agree_in_values_and_gradients_for_any_configuration() {
        let device = Device::flex().autodiff();
        let mut cases = 0;
        for case in 0..60 {
            let stream = Stream::new(11).named("fused").index(case);
            let mut rng = stream.rng();
            let config = random_config(&mut rng);
            if config.validate().is_err() {
                continue;
            }
            let net = ProNet::new(&config, &stream.named("init"), &device).unwrap();
            // Gains and offsets away from one and zero.
            let flat: Vec<f32> =
                net.parameters().iter().map(|p| p + 0.2 * (rng.random::<f32>() - 0.5)).collect();
            let net = net.with_parameters(&flat);
            let count = rng.random_range(1..40);
            let x = windows(count, config.window, &mut rng);
            let x = Tensor::<2>::from_data(TensorData::new(x, [count, config.window]), &device);
            let (fused, plain) = (net.answers(x.clone()), net.answers_plain(x));
            let values = relative(
                &fused.clone().into_data().try_to_vec::<f32>().unwrap(),
                &plain.clone().into_data().try_to_vec::<f32>().unwrap(),
            );
            let (fused, plain) = (loss_gradient(&net, fused), loss_gradient(&net, plain));
            let gradients = relative(&fused, &plain);
            // With a slope of zero below zero a network may be dead: then both gradients are zero.
            cases += usize::from(plain.iter().any(|g| g.abs() > 1e-6));
            // The gradient of a logarithm is as large as what it is of is small: rounding in a channel that hardly swings counts more.
            let tolerance = if config.pool == Pool::LogRms { 3e-4 } else { 1e-5 };
            assert!(
                values < 1e-5 && gradients < tolerance,
                "case {case}: {values:e} {gradients:e} {config:?}"
            );
        }
        assert!(cases > 40, "only {cases} of the drawn networks are alive");
    }
}
