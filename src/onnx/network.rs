//! One network as a graph: the arithmetic of its configuration, step by step.

use crate::graph::{Graph, Setting, value};
use crate::proto::GraphProto;
use dpn_pronet::config::{BlockOrder, Head, Input, NormAxes, Pool, ProNetConfig};
use dpn_pronet::definition::{LOG_SIGMA_RANGE, LOG_SPREAD_RANGE, NORM_EPSILON, POOL_EPSILON};
use dpn_pronet::shape::parameters;
use dpn_pronet::weights::Weights;

/// Name of what goes in.
pub(crate) const INPUT: &str = "window";
/// Name of what comes out.
pub(crate) const OUTPUT: &str = "sigma";
/// Name of what comes out besides, where the network says it.
pub(crate) const SPREAD: &str = "log_spread";

/// The graph of a network: `window` `[batch, window]` in, `sigma` `[batch]` out, both in the sensor's unit; a network that says how sure it is has a
/// second output, `log_spread` `[batch]`, the deviation of sigma's logarithm.
pub(crate) fn graph(weights: &Weights) -> GraphProto {
    let config = weights.config();
    let mut graph = Graph::default();
    for p in parameters(config) {
        graph.floats(
            p.name,
            &p.shape,
            &weights.parameters()[p.offset..p.offset + p.shape.iter().product::<usize>()],
        );
    }
    let mut writer = Writer { graph, config };
    let mut x = writer.prepare();
    for block in 1..=config.channels.len() {
        x = writer.block(block, &x);
    }
    let mut features = writer.pool(&x);
    let linears = config.hidden.len() + 1;
    for layer in 1..=linears {
        features = writer.linear(layer, &features);
        if layer < linears {
            features = writer.leaky_relu(&format!("fc{layer}"), &features);
        }
    }
    writer.head(&features);
    let unit = config.sensor.unit();
    let windows =
        format!("windows of {} samples of one axis of the {} [{unit}]", config.window, config.sensor);
    let sigma = format!("standard deviation of the white noise in each window [{unit}]");
    let mut outputs = vec![value(OUTPUT, &[], sigma)];
    if config.head == Head::LogSigmaAndSpread {
        outputs.push(value(SPREAD, &[], "standard deviation of sigma's natural logarithm".to_owned()));
    }
    writer.graph.finish("pronet", value(INPUT, &[config.window], windows), outputs)
}

/// What is being written, and of what.
struct Writer<'a> {
    graph: Graph,
    config: &'a ProNetConfig,
}

impl Writer<'_> {
    /// What the first convolution sees, `[batch, 1, time]`.
    fn prepare(&mut self) -> String {
        let window = self.config.window as i64;
        let per_unit = self.graph.float("per_unit", (1.0 / self.config.input_scale()) as f32);
        let scaled = self.graph.node("Mul", "scaled", &[INPUT, &per_unit], &[]);
        let prepared = match self.config.input {
            Input::Raw => scaled,
            Input::Demeaned => {
                // The first sample goes out first: gravity may be three orders above the noise, and the mean is taken in single precision.
                let first = self.between("first", &scaled, 0, 1);
                let moved = self.graph.node("Sub", "from_first", &[&scaled, &first], &[]);
                let mean = self.mean("window_mean", &moved, &[1], true);
                self.graph.node("Sub", "demeaned", &[&moved, &mean], &[])
            }
            Input::SecondDifferences => {
                let first = self.difference("difference", &scaled, window);
                self.difference("second_difference", &first, window - 1)
            }
        };
        let axes = self.graph.ints("channel_axis", &[1]);
        self.graph.node("Unsqueeze", "input", &[&prepared, &axes], &[])
    }

    /// `x[t + 1] - x[t]` of `[batch, len]`.
    fn difference(&mut self, name: &str, x: &str, len: i64) -> String {
        let later = self.between(&format!("{name}.later"), x, 1, len);
        let sooner = self.between(&format!("{name}.sooner"), x, 0, len - 1);
        self.graph.node("Sub", name, &[&later, &sooner], &[])
    }

    /// Samples `from..to` of `[batch, time]`.
    fn between(&mut self, name: &str, x: &str, from: i64, to: i64) -> String {
        let [from, to, axes] = [("from", from), ("to", to), ("axis", 1)]
            .map(|(what, number)| self.graph.ints(format!("{name}.{what}"), &[number]));
        self.graph.node("Slice", name, &[x, &from, &to, &axes], &[])
    }

    fn mean(&mut self, name: &str, x: &str, axes: &[i64], keep: bool) -> String {
        let settings = [("axes", Setting::Ints(axes)), ("keepdims", Setting::Int(i64::from(keep)))];
        self.graph.node("ReduceMean", name, &[x], &settings)
    }

    fn leaky_relu(&mut self, of: &str, x: &str) -> String {
        let alpha = ("alpha", Setting::Float(self.config.leak as f32));
        self.graph.node("LeakyRelu", format!("{of}.activated"), &[x], &[alpha])
    }

    /// Block `number` (from 1): `[batch, channels in, time]` to `[batch, channels out, time out]`.
    fn block(&mut self, number: usize, x: &str) -> String {
        let config = self.config;
        let name = format!("block{number}");
        let [kernel, stride, padding] =
            [&config.kernels, &config.strides, &config.paddings].map(|list| list[number - 1] as i64);
        let settings = [
            ("kernel_shape", Setting::Ints(&[kernel])),
            ("strides", Setting::Ints(&[stride])),
            ("pads", Setting::Ints(&[padding, padding])),
        ];
        let (weight, bias) = (format!("conv{number}.weight"), format!("conv{number}.bias"));
        let with_bias = [x, &weight, &bias];
        let inputs = if config.conv_bias { &with_bias[..] } else { &with_bias[..2] };
        let x = self.graph.node("Conv", format!("{name}.conv"), inputs, &settings);
        match config.block_order {
            BlockOrder::ConvNormAct => {
                let x = self.normalise(number, &x);
                self.leaky_relu(&name, &x)
            }
            BlockOrder::ConvActNorm => {
                let x = self.leaky_relu(&name, &x);
                self.normalise(number, &x)
            }
        }
    }

    fn normalise(&mut self, number: usize, x: &str) -> String {
        if self.config.norm_axes == NormAxes::None {
            return x.to_owned();
        }
        let name = |part: &str| format!("norm{number}.{part}");
        let mean = self.mean(&name("mean"), x, &[1], true);
        let centred = self.graph.node("Sub", name("centred"), &[x, &mean], &[]);
        let square = self.graph.node("Mul", name("square"), &[&centred, &centred], &[]);
        let variance = self.mean(&name("variance"), &square, &[1], true);
        let epsilon = self.graph.float(name("epsilon"), NORM_EPSILON);
        let above_zero = self.graph.node("Add", name("above_zero"), &[&variance, &epsilon], &[]);
        let deviation = self.graph.node("Sqrt", name("deviation"), &[&above_zero], &[]);
        let normal = self.graph.node("Div", name("normal"), &[&centred, &deviation], &[]);
        // [channels] beside [batch, channels, time].
        let axes = self.graph.ints(name("axis"), &[1]);
        let [gain, offset] = ["weight", "bias"]
            .map(|of| self.graph.node("Unsqueeze", name(&format!("{of}.column")), &[&name(of), &axes], &[]));
        let scaled = self.graph.node("Mul", name("scaled"), &[&normal, &gain], &[]);
        self.graph.node("Add", name("out"), &[&scaled, &offset], &[])
    }

    /// `[batch, channels, time]` to `[batch, features]`.
    fn pool(&mut self, x: &str) -> String {
        match self.config.pool {
            Pool::Mean => self.mean("pool.mean", x, &[2], false),
            Pool::LogRms => {
                let above_zero = self.mean_square(x);
                let log = self.graph.node("Log", "pool.log", &[&above_zero], &[]);
                let half = self.graph.float("pool.half", 0.5);
                self.graph.node("Mul", "pool.log_rms", &[&log, &half], &[])
            }
            Pool::MeanAndRms => {
                let mean = self.mean("pool.mean", x, &[2], false);
                let above_zero = self.mean_square(x);
                let rms = self.graph.node("Sqrt", "pool.rms", &[&above_zero], &[]);
                self.graph.node("Concat", "pool.both", &[&mean, &rms], &[("axis", Setting::Int(1))])
            }
        }
    }

    /// Mean squares over time, a little above zero: `[batch, channels, time]` to `[batch, channels]`.
    fn mean_square(&mut self, x: &str) -> String {
        let square = self.graph.node("Mul", "pool.square", &[x, x], &[]);
        let mean_square = self.mean("pool.mean_square", &square, &[2], false);
        let epsilon = self.graph.float("pool.epsilon", POOL_EPSILON);
        self.graph.node("Add", "pool.above_zero", &[&mean_square, &epsilon], &[])
    }

    /// Linear layer `number` (from 1): `[batch, features in]` to `[batch, features out]`.
    fn linear(&mut self, number: usize, x: &str) -> String {
        let (weight, bias) = (format!("fc{number}.weight"), format!("fc{number}.bias"));
        self.graph.node("Gemm", format!("fc{number}"), &[x, &weight, &bias], &[("transB", Setting::Int(1))])
    }

    /// From the last layer's numbers, `[batch, outputs]`, to deviations, `[batch]`, and what else the head says.
    fn head(&mut self, z: &str) {
        let positive = match self.config.head {
            Head::Softplus => self.graph.node("Softplus", "head", &[z], &[]),
            Head::LeakyRelu => self.leaky_relu("head", z),
            Head::LogSigma => self.clamped_exp("head", z, LOG_SIGMA_RANGE),
            Head::LogSigmaAndSpread => {
                let spread = self.between("spread.number", z, 1, 2);
                let spread = self.clamped_exp("spread", &spread, LOG_SPREAD_RANGE);
                let axes = self.graph.ints("spread.axis", &[1]);
                self.graph.node("Squeeze", SPREAD, &[&spread, &axes], &[]);
                let z = self.between("head.number", z, 0, 1);
                self.clamped_exp("head", &z, LOG_SIGMA_RANGE)
            }
        };
        let unit = self.graph.float("output_unit", self.config.output_scale() as f32);
        let scaled = self.graph.node("Mul", "deviation", &[&positive, &unit], &[]);
        let axes = self.graph.ints("feature_axis", &[1]);
        self.graph.node("Squeeze", OUTPUT, &[&scaled, &axes], &[]);
    }

    /// `exp` of `z` clamped to `range`.
    fn clamped_exp(&mut self, name: &str, z: &str, range: (f32, f32)) -> String {
        let least = self.graph.float(format!("{name}.least"), range.0);
        let most = self.graph.float(format!("{name}.most"), range.1);
        let clamped = self.graph.node("Clip", format!("{name}.clamped"), &[z, &least, &most], &[]);
        self.graph.node("Exp", name, &[&clamped], &[])
    }
}
