//! A stack of convolutions over samples of several axes, as the learned correction of a gyroscope is one.

use crate::graph::{Graph, Setting, value};
use crate::{metadata, model};
use std::collections::BTreeMap;

/// What goes in.
const INPUT: &str = "window";
/// What comes out.
const OUTPUT: &str = "bias";

/// What has to be known to use a model rightly, text each.
pub type Metadata = BTreeMap<String, String>;

/// A layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Convolution {
    /// `[output, input, tap]`.
    pub weights: Vec<f32>,
    /// What is added to each output.
    pub bias: Vec<f32>,
    /// Channels that go in.
    pub inputs: usize,
    /// Inputs from one output to the next.
    pub stride: usize,
    /// Inputs from one tap to the next.
    pub dilation: usize,
}

/// Layers with `x sigmoid(activation x)` between them, over samples less their mean by their deviation; of the last layer's one instant `unit` times it and `offset` come out.
#[derive(Debug, Clone, PartialEq)]
pub struct Convolutions {
    /// From the samples on.
    pub layers: Vec<Convolution>,
    /// How many samples make one answer.
    pub samples: usize,
    /// Taken from each axis,
    pub mean: Vec<f32>,
    /// which is divided by this.
    pub deviation: Vec<f32>,
    /// Between layers.
    pub activation: f32,
    /// One unit of an answer.
    pub unit: f32,
    /// Added to it.
    pub offset: Vec<f32>,
    /// What it is, in a sentence or two.
    pub summary: String,
    /// Keys and values.
    pub metadata: Metadata,
}

impl Convolutions {
    /// The bytes of its model: input `window`, `f32` `[batch, axes, samples]`, output `bias`, `f32` `[batch, outputs]`.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut graph = Graph::default();
        let axes = self.mean.len();
        let mean = graph.floats("mean", &[axes, 1], &self.mean);
        let deviation = graph.floats("deviation", &[axes, 1], &self.deviation);
        let centred = graph.node("Sub", "centred", &[INPUT, &mean], &[]);
        let mut x = graph.node("Div", "normal", &[&centred, &deviation], &[]);
        let steepness = graph.float("steepness", self.activation);
        for (number, layer) in self.layers.iter().enumerate() {
            let (inputs, outputs) = (layer.inputs, layer.bias.len());
            let taps = layer.weights.len() / (inputs * outputs);
            let name = |part: &str| format!("conv{number}.{part}");
            let weights = graph.floats(name("weight"), &[outputs, inputs, taps], &layer.weights);
            let bias = graph.floats(name("bias"), &[outputs], &layer.bias);
            let settings = [
                ("kernel_shape", Setting::Ints(&[taps as i64])),
                ("strides", Setting::Ints(&[layer.stride as i64])),
                ("dilations", Setting::Ints(&[layer.dilation as i64])),
            ];
            x = graph.node("Conv", name("sum"), &[&x, &weights, &bias], &settings);
            if number + 1 < self.layers.len() {
                let steep = graph.node("Mul", name("steep"), &[&x, &steepness], &[]);
                let share = graph.node("Sigmoid", name("share"), &[&steep], &[]);
                x = graph.node("Mul", name("out"), &[&x, &share], &[]);
            }
        }
        let time = graph.ints("time_axis", &[2]);
        let last = graph.node("Squeeze", "last", &[&x, &time], &[]);
        let unit = graph.float("unit", self.unit);
        let scaled = graph.node("Mul", "scaled", &[&last, &unit], &[]);
        let offset = graph.floats("offset", &[self.offset.len()], &self.offset);
        graph.node("Add", OUTPUT, &[&scaled, &offset], &[]);
        let window =
            value(INPUT, &[axes, self.samples], format!("the last {} samples of {axes} axes", self.samples));
        let bias = value(OUTPUT, &[self.offset.len()], "what is to be added".to_owned());
        let entries = self.metadata.iter().map(|(key, value)| metadata::entry(key, value.clone())).collect();
        model(graph.finish("correction", window, vec![bias]), self.summary.clone(), entries)
    }
}
