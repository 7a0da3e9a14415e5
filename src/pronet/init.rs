//! Weights before training: a function of one named random stream.

use crate::band_pass::band_pass_kernels;
use crate::config::{FirstKernels, ProNetConfig};
use crate::shape::{Start, parameters};
use dpn_core::random::Stream;
use rand::Rng;

/// The flat parameters of a network before training, as PyTorch would draw them (uniform, fan-in), but from `stream`.
///
/// Every parameter has a branch of its own, named as it is, so that another width in one layer moves no other layer's draw.
pub fn initial_parameters(config: &ProNetConfig, stream: &Stream) -> Vec<f32> {
    let band_pass = config.first_kernels == FirstKernels::BandPass;
    let mut flat = Vec::new();
    for parameter in parameters(config) {
        let len = parameter.len();
        match (parameter.name.as_str(), parameter.start) {
            (name @ "conv1.weight", _) if band_pass => {
                flat.extend(band_pass_kernels(config, &stream.named(name)));
            }
            ("conv1.bias", _) if band_pass => flat.extend(std::iter::repeat_n(0.0, len)),
            (_, Start::One) => flat.extend(std::iter::repeat_n(1.0, len)),
            (_, Start::Zero) => flat.extend(std::iter::repeat_n(0.0, len)),
            (name, Start::Uniform { fan_in }) => {
                let bound = 1.0 / (fan_in as f64).sqrt();
                let mut rng = stream.named(name).rng();
                flat.extend((0..len).map(|_| ((2.0 * rng.random::<f64>() - 1.0) * bound) as f32));
            }
        }
    }
    flat
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::parameter_count;

    #[test]
    fn the_same_stream_gives_the_same_bits_and_another_does_not() {
        let config = ProNetConfig::default();
        let draw = |seed| initial_parameters(&config, &Stream::new(seed).named("init"));
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
        assert_eq!(draw(1).len(), parameter_count(&config));
    }

    #[test]
    fn a_wider_second_layer_leaves_the_first_as_it_was() {
        let narrow = ProNetConfig::default();
        let wide = ProNetConfig { channels: vec![16, 48, 64], ..narrow.clone() };
        let stream = Stream::new(3);
        assert_eq!(initial_parameters(&narrow, &stream)[..128], initial_parameters(&wide, &stream)[..128]);
    }

    #[test]
    fn draws_fill_the_uniform_interval_of_their_fan_in() {
        let config = ProNetConfig::default();
        let flat = initial_parameters(&config, &Stream::new(5));
        let conv3 = parameters(&config).into_iter().find(|p| p.name == "conv3.weight").unwrap();
        let draws = &flat[conv3.offset..conv3.offset + conv3.len()];
        let bound = 1.0 / 224f32.sqrt();
        let largest = draws.iter().fold(0f32, |m, v| m.max(v.abs()));
        assert!(largest <= bound && largest > 0.999 * bound);
        // Variance of a uniform: bound^2 / 3, with a relative deviation of sqrt(4/5 / 14336) = .75 % at this count.
        let variance = draws.iter().map(|v| v * v).sum::<f32>() / draws.len() as f32;
        assert!((variance / (bound * bound / 3.0) - 1.0).abs() < 0.03);
    }
}
