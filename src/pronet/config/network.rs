//! The typed configuration of one network.

use super::{BlockOrder, FirstKernels, Head, Input, NormAxes, Pool};
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::{Sensor, imu};

dpn_core::settings!(
    /// Everything that fixes a network's shape and arithmetic; its weights aside.
    ///
    /// Blocks `1..n` are convolution, normalisation and leaky ReLU; their channels are pooled over time and go through the
    /// linear layers `1..m`, of which the last has one output or, where the head says its own uncertainty, two. `channels`, `kernels`, `strides` and `paddings` have one
    /// entry a block. Windows go in and deviations come out in the sensor's unit: m/s^2 or rad/s.
    pub struct ProNetConfig {
        /// Which sensor the network is for: `"accel"` or `"gyro"`.
        pub sensor: Sensor = Sensor::Accel,
        /// Samples in a window \[8 to 100,000\].
        pub window: usize = 200,
        /// What of the window is seen.
        pub input: Input = Input::Demeaned,
        /// Number the window is divided by first \[the sensor's unit\]; the sensor's own (.1 m/s^2, .007 rad/s) when not given.
        pub input_scale: Option<f64> = None,
        /// Order of a block's steps.
        pub block_order: BlockOrder = BlockOrder::ConvNormAct,
        /// Over what a block normalises.
        pub norm_axes: NormAxes = NormAxes::Channels,
        /// Channels out of each block \[1 to 1024\].
        pub channels: Vec<usize> = vec![16, 32, 64],
        /// Kernel width of each block \[1 or more samples\].
        pub kernels: Vec<usize> = vec![7, 7, 7],
        /// Stride of each block \[1 or more samples\].
        pub strides: Vec<usize> = vec![1, 2, 2],
        /// Samples added at both ends before each block's convolution \[below its kernel\].
        pub paddings: Vec<usize> = vec![3, 3, 3],
        /// Whether convolutions have a bias.
        pub conv_bias: bool = true,
        /// What the first convolution's kernels start from.
        pub first_kernels: FirstKernels = FirstKernels::Uniform,
        /// Slope of the leaky ReLU below zero \[0 to 1\].
        pub leak: f64 = 0.01,
        /// How the channels are pooled over time.
        pub pool: Pool = Pool::Mean,
        /// Widths of the linear layers but the last \[1 to 1024\].
        pub hidden: Vec<usize> = vec![64, 32, 16],
        /// How the last layer's number becomes a deviation.
        pub head: Head = Head::Softplus,
        /// Number the head's value is multiplied by \[the sensor's unit\]; the input scale when not given.
        pub output_scale: Option<f64> = None,
    }
);

impl ProNetConfig {
    /// The default network of `sensor`.
    pub fn for_sensor(sensor: Sensor) -> Self {
        Self { sensor, ..Self::default() }
    }

    /// The number a window is divided by first \[the sensor's unit\].
    pub fn input_scale(&self) -> f64 {
        self.input_scale.unwrap_or(match self.sensor {
            imu::Sensor::Accel => 0.1,
            imu::Sensor::Gyro => 0.007,
        })
    }

    /// The number the head's value is multiplied by \[the sensor's unit\].
    pub fn output_scale(&self) -> f64 {
        self.output_scale.unwrap_or_else(|| self.input_scale())
    }

    /// The same configuration with every default that depends on other keys written out.
    #[must_use]
    pub fn resolved(&self) -> Self {
        Self {
            input_scale: Some(self.input_scale()),
            output_scale: Some(self.output_scale()),
            ..self.clone()
        }
    }

    /// Samples of the first convolution's input, its padding not counted.
    pub(crate) fn input_length(&self) -> usize {
        match self.input {
            Input::Demeaned | Input::Raw => self.window,
            Input::SecondDifferences => self.window.saturating_sub(2),
        }
    }

    /// Number (from 1) of the first block whose padded input is shorter than its kernel.
    fn first_block_without_output(&self) -> Option<usize> {
        let mut length = self.input_length();
        for (block, ((kernel, stride), padding)) in
            self.kernels.iter().zip(&self.strides).zip(&self.paddings).enumerate()
        {
            if length + 2 * padding < *kernel {
                return Some(block + 1);
            }
            length = (length + 2 * padding - kernel) / stride + 1;
        }
        None
    }
}

impl Validate for ProNetConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        let positive = |faults: &mut ConfigFaults, key: &str, scale: Option<f64>| {
            if let Some(s) = scale {
                faults.check(s.is_finite() && (s as f32) > 0.0, key, s, "a positive number");
            }
        };
        let all = |list: &[usize], least, most| list.iter().all(|v| (least..=most).contains(v));
        let blocks = self.channels.len();

        faults.check((8..=100_000).contains(&self.window), "window", self.window, "8 to 100000 samples");
        positive(&mut faults, "input_scale", self.input_scale);
        faults.check(
            (1..=8).contains(&blocks) && all(&self.channels, 1, 1024),
            "channels",
            format!("{:?}", self.channels),
            "1 to 8 numbers from 1 to 1024",
        );
        for (key, list, least) in
            [("kernels", &self.kernels, 1), ("strides", &self.strides, 1), ("paddings", &self.paddings, 0)]
        {
            let shown = format!("{list:?}");
            let one_each = format!("one entry a block, {blocks} as in `channels`");
            faults.check(list.len() == blocks, key, &shown, one_each);
            let bound = format!("{least} to 10000 in every entry");
            faults.check(all(list, least, 10_000), key, &shown, bound);
        }
        let paddings = format!("{:?}", self.paddings);
        faults.check(
            self.paddings.iter().zip(&self.kernels).all(|(p, k)| p < k),
            "paddings",
            &paddings,
            "below the kernel of the same block",
        );
        faults.within("leak", self.leak, 0.0, 1.0);
        faults.check(
            self.hidden.len() <= 8 && all(&self.hidden, 1, 1024),
            "hidden",
            format!("{:?}", self.hidden),
            "at most 8 numbers from 1 to 1024",
        );
        positive(&mut faults, "output_scale", self.output_scale);
        if faults.0.is_empty()
            && let Some(block) = self.first_block_without_output()
        {
            let bound = format!("no longer than what reaches block {block} with its padding");
            faults.check(false, "kernels", format!("{:?}", self.kernels), bound);
        }
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_reads_back_from_toml_unchanged() {
        for sensor in Sensor::ALL {
            let config = ProNetConfig::for_sensor(sensor).resolved();
            let text = toml::to_string(&config).unwrap();
            assert_eq!(toml::from_str::<ProNetConfig>(&text).unwrap(), config);
            config.validate().unwrap();
        }
    }

    #[test]
    fn an_unknown_key_is_an_error_that_names_it() {
        let error = toml::from_str::<ProNetConfig>("sensor = \"gyro\"\nkernel = [3]\n").unwrap_err();
        assert!(error.to_string().contains("`kernel`"), "{error}");
    }

    #[test]
    fn choices_are_spelt_as_their_names() {
        let text =
            "block_order = \"conv-act-norm\"\nnorm_axes = \"none\"\nhead = \"log-sigma\"\ninput = \"raw\"\n";
        let config: ProNetConfig = toml::from_str(text).unwrap();
        assert_eq!(config.block_order, BlockOrder::ConvActNorm);
        assert_eq!(config.norm_axes, NormAxes::None);
        assert_eq!(config.head, Head::LogSigma);
        assert_eq!(config.input, Input::Raw);
        for head in Head::ALL {
            assert_eq!(serde_json::to_string(&head).unwrap(), format!("\"{head}\""));
        }
    }

    #[test]
    fn all_faults_are_reported_at_once() {
        let config = ProNetConfig {
            window: 3,
            leak: 2.0,
            kernels: vec![7, 7],
            input_scale: Some(f64::NAN),
            ..ProNetConfig::default()
        };
        let keys: Vec<_> = config.faults().into_iter().map(|fault| fault.key).collect();
        assert_eq!(keys, ["window", "input_scale", "kernels", "leak"]);
    }

    #[test]
    fn a_kernel_longer_than_what_reaches_it_is_refused() {
        let config = ProNetConfig {
            window: 20,
            strides: vec![4, 4, 4],
            paddings: vec![0, 0, 0],
            ..ProNetConfig::default()
        };
        let error = config.validate().unwrap_err();
        assert_eq!(error.0[0].key, "kernels");
        assert!(error.0[0].bound.contains("block 2"), "{error}");
    }

    #[test]
    fn each_sensor_has_its_own_scale_unless_one_is_given() {
        assert_eq!(ProNetConfig::for_sensor(Sensor::Gyro).input_scale(), 0.007);
        let config = ProNetConfig { input_scale: Some(0.5), ..ProNetConfig::default() };
        assert_eq!(config.output_scale(), 0.5);
    }
}
