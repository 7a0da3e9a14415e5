//! A network for other runtimes.

use crate::model::{Model, UNIT, USE};
use crate::network::{self, GELU};
use dpn_onnx::{Convolution, Convolutions, Metadata};

/// What an exported model lacks.
const NO_GRAVITY: &str = "what gravity tells of the bias beside it is not in this file: dpn's C, C++ and Python interfaces say both";

impl Model {
    /// The bytes of its ONNX model: the last 511 samples as the IMU gives them in, what is to be added to `matrix * reading` out. Its metadata say how it is to be used.
    ///
    /// # Shapes
    /// Input `window`, `f32` `[batch, 6, 511]`, gyroscope first; output `bias`, `f32` `[batch, 3]`.
    ///
    /// # Units and frames
    /// rad/s and m/s^2 of the body in, rad/s out.
    pub fn to_onnx(&self) -> Vec<u8> {
        self.convolutions().to_bytes()
    }

    fn convolutions(&self) -> Convolutions {
        let card = &self.card;
        let layers = network::layers(&self.parameters).map(|layer| {
            let taps = layer.taps.len() / (layer.inputs * layer.outputs);
            let at = |output: usize, input: usize, tap: usize| {
                layer.taps[(tap * layer.inputs + input) * layer.outputs + output]
            };
            let of_output =
                |output| (0..layer.inputs).flat_map(move |i| (0..taps).map(move |tap| at(output, i, tap)));
            Convolution {
                weights: (0..layer.outputs).flat_map(of_output).collect(),
                bias: layer.bias.to_vec(),
                inputs: layer.inputs,
                stride: layer.stride,
                dilation: layer.dilation,
            }
        });
        let single = |values: &[f64]| values.iter().map(|v| *v as f32).collect();
        let words = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        Convolutions {
            layers: layers.collect(),
            samples: network::PAST,
            mean: single(&card.mean),
            deviation: single(&card.deviation),
            activation: GELU,
            unit: UNIT as f32,
            offset: single(card.affine.bias.as_slice()),
            summary: format!(
                "Bias of a gyroscope [rad/s]: `matrix * reading + bias` is the rate. In go the last {} samples at {} Hz as this IMU gives them (rad/s, m/s^2). {USE}. {NO_GRAVITY}.",
                network::PAST,
                card.rate.hz(),
            ),
            metadata: Metadata::from([
                ("usage".to_owned(), format!("{}; {NO_GRAVITY}", card.usage)),
                ("rate_hz".to_owned(), card.rate.hz().to_string()),
                ("window".to_owned(), network::PAST.to_string()),
                ("average_s".to_owned(), card.config.average_s.to_string()),
                ("matrix".to_owned(), words(card.affine.matrix.transpose().as_slice())),
                ("trained_on_sha256".to_owned(), card.data.join(" ")),
                (
                    "training".to_owned(),
                    serde_json::to_string(&card.config).expect("numbers and names are JSON"),
                ),
            ]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::DMatrix;
    use rand::Rng;

    /// ONNX Runtime is held to [`Convolutions`]; here those are held to the network.
    #[test]
    fn the_layers_that_are_exported_are_the_networks() {
        let course =
            crate::course::simulated(6.0, nalgebra::Matrix3::identity(), [0.01, 0.0, 0.02].into(), 0.01);
        let mut rng = Stream::new(4).named("case").rng();
        let parameters = (0..network::count()).map(|_| rng.random_range(-0.1..0.1f32)).collect();
        let fitted = crate::fit(&[&course], crate::Unknown::All).unwrap();
        let model = Model::new(&Default::default(), &fitted, std::slice::from_ref(&course), parameters);
        let exported = model.convolutions();
        let readings = DMatrix::from_fn(6, network::PAST, |row, i| {
            f64::from((if row < 3 { course.gyro[i][row] } else { course.accel[i][row - 3] }) as f32)
        });
        let seen = readings.map_with_location(|row, _, x| {
            ((x - f64::from(exported.mean[row])) / f64::from(exported.deviation[row])) as f32
        });
        let mut x: Vec<Vec<f64>> =
            seen.column_iter().map(|c| c.iter().map(|v| f64::from(*v)).collect()).collect();
        for (number, layer) in exported.layers.iter().enumerate() {
            let outputs = layer.bias.len();
            let taps = layer.weights.len() / (layer.inputs * outputs);
            let answers = (x.len() - (taps - 1) * layer.dilation - 1) / layer.stride + 1;
            let at = |t: usize, o: usize| {
                let of_tap = |(i, tap): (usize, usize)| {
                    let weight = layer.weights[(o * layer.inputs + i) * taps + tap];
                    f64::from(weight) * x[t * layer.stride + tap * layer.dilation][i]
                };
                let pairs = (0..layer.inputs).flat_map(|i| (0..taps).map(move |tap| (i, tap)));
                let sum = f64::from(layer.bias[o]) + pairs.map(of_tap).sum::<f64>();
                if number + 1 == exported.layers.len() {
                    sum
                } else {
                    sum / (1.0 + (-f64::from(exported.activation) * sum).exp())
                }
            };
            x = (0..answers).map(|t| (0..outputs).map(|o| at(t, o)).collect()).collect();
        }
        let (ours, _) = network::forward(&model.parameters, seen);
        assert_eq!((x.len(), ours.ncols()), (1, 1));
        for (theirs, ours) in x[0].iter().zip(ours.iter()) {
            assert!(
                (theirs - f64::from(*ours)).abs() < 1e-4 * f64::from(ours.abs().max(0.1)),
                "{theirs} {ours}"
            );
        }
    }
}
