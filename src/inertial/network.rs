//! The network: causal convolutions over six axes, 6-16-32-64-128-3 channels, kernels of 7 and a last one of 1, dilations 1 1 4 16, the first with a stride of 4.
//!
//! An answer looks at 511 samples and holds for the newest of them and the three that follow. Between layers `x sigmoid(1.702 x)` (GELU in its quick form: Hendrycks and
//! Gimpel 2016). Columns of a matrix are instants, rows channels, so that a kernel's tap is a product of matrices over columns at a distance, without a copy; products are nalgebra's
//! (`matrixmultiply`). Parameters lie flat: a layer's taps, each a matrix of outputs by inputs column by column, then its biases.

use dpn_core::random::Stream;
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, Dyn, MatrixView};
use rand::Rng;

/// Channels from layer to layer.
const CHANNELS: [usize; 6] = [6, 16, 32, 64, 128, 3];
/// Taps of each layer's kernel.
const TAPS: [usize; 5] = [7, 7, 7, 7, 1];
/// Between taps.
const DILATIONS: [usize; 5] = [1, 1, 4, 16, 1];
/// Samples to an answer.
pub(crate) const STRIDE: usize = 4;
/// Samples that an answer looks at.
pub(crate) const PAST: usize = 511;
/// Layers.
const LAYERS: usize = 5;
/// GELU's quick form: `x sigmoid(GELU x)`.
pub(crate) const GELU: f32 = 1.702;

/// Names, shapes and places of the parameters: taps `[tap, input, output]`, biases.
pub(crate) fn parameters() -> Vec<(String, Vec<usize>, std::ops::Range<usize>)> {
    let mut at = 0;
    let mut all = Vec::new();
    let mut next = |name: String, shape: Vec<usize>| {
        let count: usize = shape.iter().product();
        all.push((name, shape, at..at + count));
        at += count;
    };
    for layer in 0..LAYERS {
        let (input, output) = (CHANNELS[layer], CHANNELS[layer + 1]);
        next(format!("conv{layer}.taps"), vec![TAPS[layer], input, output]);
        next(format!("conv{layer}.bias"), vec![output]);
    }
    all
}

/// How many parameters there are.
pub(crate) fn count() -> usize {
    parameters().last().map_or(0, |(_, _, place)| place.end)
}

/// Parameters before training: uniform within the root of the inputs' number (PyTorch's), the last layer nothing, so that the first answer is no correction.
pub(crate) fn initial(stream: &Stream) -> Vec<f32> {
    let mut rng = stream.named("init").rng();
    let mut all = Vec::with_capacity(count());
    for (index, (.., place)) in parameters().into_iter().enumerate() {
        let layer = index / 2;
        let bound =
            if layer + 1 == LAYERS { 0.0 } else { 1.0 / ((TAPS[layer] * CHANNELS[layer]) as f32).sqrt() };
        all.extend(place.map(|_| bound * rng.random_range(-1.0..1.0f32)));
    }
    all
}

/// Samples that are needed for so many answers.
pub(crate) fn samples_for(answers: usize) -> usize {
    STRIDE * (answers - 1) + PAST
}

/// What the way back needs: every layer's input, and what its activation was given.
pub(crate) struct Trace {
    inputs: Vec<DMatrix<f32>>,
    sums: Vec<DMatrix<f32>>,
}

/// A layer as numbers: for each tap a matrix of outputs by inputs, column by column, then what is added to each output.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layer<'a> {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) taps: &'a [f32],
    pub(crate) bias: &'a [f32],
    pub(crate) stride: usize,
    pub(crate) dilation: usize,
    /// Whether [`activation`] follows.
    pub(crate) is_last: bool,
}

impl Layer<'_> {
    /// Inputs from the first tap's to the last's.
    pub(crate) fn span(&self) -> usize {
        (self.taps.len() / (self.inputs * self.outputs) - 1) * self.dilation + 1
    }
}

/// The layers of these parameters, from the samples on.
pub(crate) fn layers(parameters: &[f32]) -> impl Iterator<Item = Layer<'_>> {
    let mut rest = parameters;
    (0..LAYERS).map(move |layer| {
        let (inputs, outputs) = (CHANNELS[layer], CHANNELS[layer + 1]);
        let (taps, after) = rest.split_at(TAPS[layer] * inputs * outputs);
        let (bias, after) = after.split_at(outputs);
        rest = after;
        Layer {
            inputs,
            outputs,
            taps,
            bias,
            stride: stride(layer),
            dilation: DILATIONS[layer],
            is_last: layer + 1 == LAYERS,
        }
    })
}

/// Between layers.
pub(crate) fn activation(x: f32) -> f32 {
    x / (1.0 + (-GELU * x).exp())
}

/// A layer's stride.
fn stride(layer: usize) -> usize {
    if layer == 0 { STRIDE } else { 1 }
}

/// Places of a layer's taps and biases.
fn places(layer: usize) -> [std::ops::Range<usize>; 2] {
    let all = parameters();
    [all[2 * layer].2.clone(), all[2 * layer + 1].2.clone()]
}

/// A matrix over numbers that lie elsewhere, with its steps from row to row and from column to column.
fn strided(
    data: &[f32],
    rows: usize,
    columns: usize,
    row: usize,
    column: usize,
) -> MatrixView<'_, f32, Dyn, Dyn, Dyn, Dyn> {
    MatrixView::from_slice_with_strides_generic(data, Dyn(rows), Dyn(columns), Dyn(row), Dyn(column))
}

/// Answers (3 rows) to samples (6 rows, normalised).
pub(crate) fn forward(parameters: &[f32], samples: DMatrix<f32>) -> (DMatrix<f32>, Trace) {
    let mut trace = Trace { inputs: Vec::with_capacity(LAYERS), sums: Vec::with_capacity(LAYERS) };
    let mut input = samples;
    for layer in layers(parameters) {
        let Layer { inputs: rows, outputs, stride: step, dilation, .. } = layer;
        let answers = (input.ncols() - layer.span()) / step + 1;
        let mut sum = DMatrix::from_fn(outputs, answers, |row, _| layer.bias[row]);
        for (tap, weights) in layer.taps.chunks_exact(rows * outputs).enumerate() {
            let weights = DMatrixView::from_slice(weights, outputs, rows);
            let from = tap * dilation * rows;
            sum.gemm(1.0, &weights, &strided(&input.as_slice()[from..], rows, answers, 1, step * rows), 1.0);
        }
        trace.inputs.push(input);
        if layer.is_last {
            return (sum, trace);
        }
        input = sum.map(activation);
        trace.sums.push(sum);
    }
    unreachable!("the last layer returns")
}

/// The gradient by the parameters, from that by the answers.
pub(crate) fn backward(parameters: &[f32], trace: &Trace, by_answers: DMatrix<f32>) -> Vec<f32> {
    let mut gradient = vec![0.0; parameters.len()];
    let mut by_sum = by_answers;
    for layer in (0..LAYERS).rev() {
        let (rows, outputs, step) = (CHANNELS[layer], CHANNELS[layer + 1], stride(layer));
        let (input, answers) = (&trace.inputs[layer], by_sum.ncols());
        let [taps, bias] = places(layer);
        gradient[bias].copy_from_slice(by_sum.column_sum().as_slice());
        let mut by_input = DMatrix::zeros(if layer == 0 { 0 } else { rows }, input.ncols());
        if layer + 1 == LAYERS {
            // nalgebra's way with products of five rows and fewer reads past the end of a view.
            for ((x, by), mut back) in
                input.column_iter().zip(by_sum.column_iter()).zip(by_input.column_iter_mut())
            {
                for i in 0..rows {
                    for o in 0..outputs {
                        let at = taps.start + i * outputs + o;
                        gradient[at] += by[o] * x[i];
                        back[i] += parameters[at] * by[o];
                    }
                }
            }
        }
        for tap in 0..if layer + 1 == LAYERS { 0 } else { TAPS[layer] } {
            let place = taps.start + tap * rows * outputs..taps.start + (tap + 1) * rows * outputs;
            let at = tap * DILATIONS[layer];
            let turned = strided(&input.as_slice()[at * rows..], answers, rows, step * rows, 1);
            DMatrixViewMut::from_slice(&mut gradient[place.clone()], outputs, rows)
                .gemm(1.0, &by_sum, &turned, 1.0);
            if layer > 0 {
                let weights = strided(&parameters[place], rows, outputs, outputs, 1);
                by_input.columns_mut(at, answers).gemm(1.0, &weights, &by_sum, 1.0);
            }
        }
        if layer > 0 {
            by_sum = by_input.zip_map(&trace.sums[layer - 1], |by, x| {
                let share = 1.0 / (1.0 + (-GELU * x).exp());
                by * share * (1.0 + GELU * x * (1.0 - share))
            });
        }
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, a number at a time.
    fn plain(parameters: &[f64], samples: &DMatrix<f64>) -> Vec<[f64; 3]> {
        let mut x: Vec<Vec<f64>> = samples.column_iter().map(|c| c.iter().copied().collect()).collect();
        for layer in 0..LAYERS {
            let (rows, outputs) = (CHANNELS[layer], CHANNELS[layer + 1]);
            let [taps, bias] = places(layer);
            let span = (TAPS[layer] - 1) * DILATIONS[layer];
            let answers = (x.len() - span - 1) / stride(layer) + 1;
            let at = |t: usize, o: usize| {
                let mut sum = parameters[bias.start + o];
                for tap in 0..TAPS[layer] {
                    for i in 0..rows {
                        let weight = parameters[taps.start + (tap * rows + i) * outputs + o];
                        sum += weight * x[t * stride(layer) + tap * DILATIONS[layer]][i];
                    }
                }
                if layer + 1 == LAYERS { sum } else { sum / (1.0 + (-f64::from(GELU) * sum).exp()) }
            };
            x = (0..answers).map(|t| (0..outputs).map(|o| at(t, o)).collect()).collect();
        }
        x.iter().map(|y| [y[0], y[1], y[2]]).collect()
    }

    fn case() -> (Vec<f32>, DMatrix<f32>) {
        let mut rng = Stream::new(3).named("case").rng();
        let mut parameters = initial(&Stream::new(3));
        let last = parameters.len() - 387;
        parameters[last..].iter_mut().for_each(|p| *p = rng.random_range(-0.3..0.3));
        (parameters, DMatrix::from_fn(6, samples_for(8), |_, _| rng.random_range(-2.0..2.0)))
    }

    #[test]
    fn it_has_77_thousand_weights_and_511_samples_of_past() {
        assert_eq!(count(), 76_563);
        let spans: usize = (1..LAYERS).map(|layer| (TAPS[layer] - 1) * DILATIONS[layer]).sum();
        assert_eq!(STRIDE * spans + TAPS[0], PAST);
    }

    #[test]
    fn answers_are_the_definitions_and_the_gradient_is_their_derivative() {
        let (parameters, samples) = case();
        let exact: Vec<f64> = parameters.iter().map(|p| f64::from(*p)).collect();
        let (answers, trace) = forward(&parameters, samples.clone());
        let wide: DMatrix<f64> = samples.clone().cast();
        let wanted = plain(&exact, &wide);
        assert_eq!(answers.ncols(), wanted.len());
        for (column, wanted) in answers.column_iter().zip(&wanted) {
            for (a, w) in column.iter().zip(wanted) {
                assert!((f64::from(*a) - w).abs() < 1e-5, "{a} {w}");
            }
        }
        let weigh = |t: usize, o: usize| 1.0 + 0.5 * t as f64 - 0.7 * o as f64;
        let gradient = backward(&parameters, &trace, DMatrix::from_fn(3, 8, |o, t| weigh(t, o) as f32));
        let sum = |parameters: &[f64]| -> f64 {
            let answers = plain(parameters, &wide);
            let rows = answers.iter().enumerate();
            rows.map(|(t, y)| (0..3).map(|o| weigh(t, o) * y[o]).sum::<f64>()).sum::<f64>()
        };
        // Some of every layer.
        let (sum, exact) = (&sum, &exact);
        for (_, _, place) in super::parameters() {
            for i in [place.start, (place.start + place.end) / 2, place.end - 1] {
                let moved = |step: f64| -> f64 {
                    let mut p = exact.to_vec();
                    p[i] += step;
                    sum(&p)
                };
                let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let scale = slope.abs().max(0.1);
                assert!(
                    (f64::from(gradient[i]) - slope).abs() < 1e-3 * scale,
                    "{i}: {} {slope}",
                    gradient[i]
                );
            }
        }
    }
}
