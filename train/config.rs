//! Everything that decides a training run, as one typed TOML file.

use crate::base::Base;
use crate::draw::{Augment, DrawRule};
use crate::label::Label;
use crate::levels::{LevelKind, Levels};
use crate::sensor::SensorDraw;
use crate::vibration::VibrationDraw;
use dpn_core::config::{ConfigFault, ConfigFaults, Limit, Validate};
use dpn_core::{SampleRate, Sensor};
use dpn_io::config::{self, ConfigError};
use dpn_pronet::ProNetConfig;
use dpn_pronet::config::{FirstKernels, Head, Input};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Configuration of `dpn train`. Keys that do not stand in the file have the defaults documented here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainConfig {
    /// Name of the estimator in tables.
    pub name: String,
    /// Seed of initial weights, noise, and order of windows.
    pub seed: u64,
    /// Rate that recordings are brought to \[Hz, 20 to 8000\].
    pub rate_hz: SampleRate,
    /// The signal noise is injected into.
    pub base: BaseConfig,
    /// What is injected and asked for.
    pub noise: NoiseConfig,
    /// Changes to a window that leave its noise the same.
    pub augment: Augment,
    /// How the weights are fitted.
    pub fit: FitConfig,
    /// The network.
    pub network: ProNetConfig,
}

dpn_core::settings!(
    /// Decision 2.
    #[derive(Copy)]
    pub struct BaseConfig {
        /// What cleans the signal.
        pub filter: FilterKind = FilterKind::SavitzkyGolay,
        /// Samples of the Savitzky-Golay filter, odd.
        pub window: usize = 11,
        /// Degree of its polynomial, below `window`.
        pub order: usize = 2,
    }
);

/// What cleans the signal before noise is injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterKind {
    /// Savitzky-Golay.
    SavitzkyGolay,
    /// Gaussian smoothing of several widths.
    Gaussian,
    /// Nothing: the raw signal.
    None,
}

impl BaseConfig {
    /// The base these keys mean.
    pub fn base(&self) -> Base {
        match self.filter {
            FilterKind::SavitzkyGolay => Base::SavitzkyGolay { window: self.window, order: self.order },
            FilterKind::Gaussian => Base::Gaussian,
            FilterKind::None => Base::Raw,
        }
    }

    /// Sets filter, window and order from `base`.
    pub fn set(&mut self, base: Base) {
        match base {
            Base::Raw => self.filter = FilterKind::None,
            Base::Gaussian => self.filter = FilterKind::Gaussian,
            Base::SavitzkyGolay { window, order } => {
                (self.filter, self.window, self.order) = (FilterKind::SavitzkyGolay, window, order);
            }
        }
    }
}

dpn_core::settings!(
    /// Decisions 9 and 10. `low` and `high` that do not stand in the file are the paper's for the sensor, at other rates than 200 Hz those of the same density.
    pub struct NoiseConfig {
        /// How injected deviations are chosen.
        pub levels: LevelKind = LevelKind::Grid,
        /// Smallest injected deviation \[m/s^2 or rad/s\].
        pub low: Option<f64> = None,
        /// Largest injected deviation \[m/s^2 or rad/s\].
        pub high: Option<f64> = None,
        /// Number of grid points; also how often every window is judged in validation and evaluation.
        pub steps: Option<usize> = None,
        /// What a window is labelled with.
        pub label: Label = Label::Injected,
        /// Span of the sums of `label = "sigma_eff"` \[s, a sample of 5 ms to 1 s\]; .1 when not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub span_s: Option<f64> = None,
        /// Vibration beside the white noise, for `label = "sigma_eff"`; none when not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub vibration: Option<VibrationDraw> = None,
        /// What the sensor does to all of it; nothing when not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub sensor: Option<SensorDraw> = None,
        /// What each training sequence's own noise is in sums, as a density \[m/s^2/sqrt(Hz) or rad/s/sqrt(Hz)\], for `label = "sigma_eff"` on raw windows;
        /// what `dpn truth` says of it; sequences without are left out. Not counted when not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub own: Option<BTreeMap<String, f64>> = None,
    }
);

/// Samples that a window has at least: the widest Gaussian base reaches 27 to either side.
const LEAST_WINDOW: usize = 28;
/// The span of `sigma_eff` where the file gives none \[s\].
const SPAN_S: f64 = 0.1;

impl NoiseConfig {
    /// Samples of `rate` in the sums that `sigma_eff` is about.
    pub fn span(&self, rate: SampleRate) -> usize {
        (self.span_s.unwrap_or(SPAN_S) * rate.hz()).round() as usize
    }
}

dpn_core::settings!(
    /// How the weights are fitted.
    #[derive(Copy)]
    pub struct FitConfig {
        /// Passes over the training windows.
        pub epochs: u64 = 200,
        /// How often an epoch shows each window, every time with other noise.
        pub draws_per_window: u64 = 2 => 1..=1000,
        /// Windows a step.
        pub batch: usize = 200 => 1..=10_000,
        /// Largest learning rate of Adam.
        pub learning_rate: f64 = 4e-3 => Limit::AtMost(1.0),
        /// Its course over the run.
        pub schedule: Schedule = Schedule::Cosine,
        /// Steps over which the learning rate rises from 0.
        pub warmup_steps: u64 = 100,
        /// Decoupled weight decay (AdamW) a step, times the learning rate; 0 is plain Adam.
        pub weight_decay: f64 = 1e-4 => 0.0..=1.0,
        /// Largest norm of the whole gradient, in units of the normalised loss; 0 leaves it as it is.
        pub clip_norm: f64 = 1.0 => Limit::NotNegative,
        /// Decay of the running mean of the weights that is validated and kept; 0 keeps the weights themselves.
        pub ema: f64 = 0.99,
        /// What is minimised.
        pub loss: Loss = Loss::Mse,
        /// Epochs between two validations; the last epoch is always validated.
        pub validate_every: u64 = 5,
    }
);

/// Course of the learning rate after warm-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// As it is (the paper).
    Constant,
    /// Half a cosine down to 0 at the last step.
    Cosine,
}

/// What is minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// Mean square error of the deviation in units of the output scale (the paper's, but for the unit).
    Mse,
    /// Mean square error of its logarithm.
    LogMse,
    /// What a normal law of its logarithm is worth, whose deviation the network says too (`network.head = "log-sigma-and-spread"`): `e^2 / (2 s^2) + ln s`.
    LogNll,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self::for_sensor(Sensor::Accel)
    }
}

impl TrainConfig {
    /// The default run for `sensor`: what `configs/train/accel.toml` and `gyro.toml` say.
    ///
    /// Chosen on validation data (docs/src/reads-the-noise.md): the first convolution sees second differences, which motion hardly
    /// reaches, at a tenth of the scale of the answer, so that its bias outweighs them and layer normalisation over
    /// channels stays close to linear; its kernels begin as a bank of band-pass filters.
    pub fn for_sensor(sensor: Sensor) -> Self {
        Self::at_rate(sensor, SampleRate::HZ_200)
    }

    /// The same for samples of another rate, with windows of one second.
    pub fn at_rate(sensor: Sensor, rate: SampleRate) -> Self {
        let plain = ProNetConfig::for_sensor(sensor);
        let network = ProNetConfig {
            window: (rate.hz().round() as usize).max(LEAST_WINDOW),
            input: Input::SecondDifferences,
            input_scale: Some(10.0 * plain.output_scale()),
            output_scale: Some(plain.output_scale()),
            first_kernels: FirstKernels::BandPass,
            channels: vec![32, 32, 64],
            kernels: vec![41, 5, 3],
            strides: vec![1, 4, 2],
            paddings: vec![20, 2, 1],
            leak: 0.1,
            hidden: vec![32, 32, 16],
            ..plain
        };
        Self {
            name: "pronet".into(),
            seed: 0,
            rate_hz: rate,
            base: BaseConfig::default(),
            noise: NoiseConfig::default(),
            augment: Augment::default(),
            fit: FitConfig::default(),
            network,
        }
    }

    /// The sensor trained for.
    pub fn sensor(&self) -> Sensor {
        self.network.sensor
    }

    /// Injected deviations, the paper's range where the file gives none.
    pub fn levels(&self) -> Levels {
        let paper = Levels::paper(self.sensor(), self.noise.levels);
        let same_density = (self.rate_hz.hz() / SampleRate::HZ_200.hz()).sqrt();
        Levels {
            kind: self.noise.levels,
            low: self.noise.low.unwrap_or(paper.low * same_density),
            high: self.noise.high.unwrap_or(paper.high * same_density),
            steps: self.noise.steps.unwrap_or(paper.steps),
        }
    }

    /// The rule examples are drawn by.
    pub(crate) fn draw_rule(&self) -> DrawRule {
        DrawRule {
            levels: self.levels(),
            label: self.noise.label,
            vibration: self.noise.vibration,
            sensor: self.noise.sensor,
            span: self.noise.span(self.rate_hz),
            rate: self.rate_hz,
            augment: self.augment,
        }
    }

    /// The same run with every default written out.
    #[must_use]
    pub fn resolved(&self) -> Self {
        let levels = self.levels();
        let noise = NoiseConfig {
            low: Some(levels.low),
            high: Some(levels.high),
            steps: Some(levels.steps),
            ..self.noise.clone()
        };
        Self { noise, network: self.network.resolved(), ..self.clone() }
    }
}

/// Reads a configuration whose missing keys, in every table, are those of [`TrainConfig::for_sensor`]; `sensor` is the
/// file's own where it names none.
///
/// # Errors
/// A file that cannot be read or is no such configuration; values outside their bounds.
pub fn load(path: &Path, sensor: Sensor) -> Result<TrainConfig, ConfigError> {
    load_over(Some(path), &[], sensor)
}

/// As [`load`], or the sensor's defaults without a file, with single keys set over it: `("network.leak", "0.2")`.
///
/// # Errors
/// As [`load`]; a key that is not known, a value of the wrong kind.
pub fn load_over(
    path: Option<&Path>,
    sets: &[(String, String)],
    sensor: Sensor,
) -> Result<TrainConfig, ConfigError> {
    let table = config::table_over::<TrainConfig>(path, sets)?;
    config::of_table(over_defaults(table, sensor), path, sets)
}

/// As [`load`], from a text at hand; `path` only names it in errors.
///
/// # Errors
/// A text that is no such configuration; values outside their bounds.
pub fn parse(text: &str, path: &Path, sensor: Sensor) -> Result<TrainConfig, ConfigError> {
    // Read as it stands first: only this text's errors can name its lines.
    config::parse::<TrainConfig>(text, path)?;
    let table = toml::from_str(text).expect("it was read as a configuration just now");
    config::of_table(over_defaults(table, sensor), Some(path), &[])
}

/// The keys of `table` over the defaults of the sensor that it names, or of `sensor`, and of the rate that it names.
fn over_defaults(table: toml::Table, sensor: Sensor) -> toml::Table {
    let named = table.get("network").and_then(|network| network.get("sensor")).cloned();
    let sensor = named.and_then(|name| name.try_into().ok()).unwrap_or(sensor);
    let rate =
        table.get("rate_hz").and_then(|value| value.clone().try_into().ok()).and_then(SampleRate::from_hz);
    let defaults = TrainConfig::at_rate(sensor, rate.unwrap_or(SampleRate::HZ_200));
    let mut whole = toml::Table::try_from(defaults).expect("tables of plain keys are TOML");
    overlay(&mut whole, table);
    whole
}

/// Puts the keys of `over` in place of those of `under`, table by table.
fn overlay(under: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(toml::Value::Table(under)), toml::Value::Table(over)) => overlay(under, over),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

impl Validate for TrainConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.table("network", self.network.faults());
        let (base, fit, levels) = (&self.base, &self.fit, self.levels());
        faults.check(base.base().filter().is_ok(), "base", base.base(), "an odd window above its order");
        let (rate, window) = (self.rate_hz, self.network.window);
        faults.within("rate_hz", rate.hz(), 20.0, 8000.0);
        let filter = if base.filter == FilterKind::SavitzkyGolay { base.window } else { LEAST_WINDOW };
        let whole = format!("at least {filter} samples, for the base's filter and the window's own noise");
        faults.check(window >= filter.max(LEAST_WINDOW), "network.window", window, whole);
        faults.check(
            levels.low > 0.0 && levels.low <= levels.high && levels.high.is_finite(),
            "noise.low",
            format!("{} (with `noise.high` {})", levels.low, levels.high),
            "above 0 and at most `noise.high`",
        );
        faults.within("noise.steps", levels.steps, 1, 1000);
        let noise = &self.noise;
        if let Some(vibration) = &noise.vibration {
            vibration.check(&mut faults);
        }
        if let Some(sensor) = &noise.sensor {
            sensor.check(&mut faults);
        }
        let fits = noise.label == Label::Effective && base.filter == FilterKind::None;
        faults.check(
            noise.own.is_none() || fits,
            "noise.own",
            "given",
            "not given but for `noise.label = \"sigma_eff\"` on a raw base",
        );
        let is_level = |level: &f64| *level > 0.0 && level.is_finite();
        let levels = noise.own.iter().flat_map(|own| own.values());
        faults.check(levels.clone().all(is_level), "noise.own", "a level", "above 0");
        faults.check(
            noise.vibration.is_none() || noise.label == Label::Effective,
            "noise.label",
            format!("\"{}\"", noise.label),
            "\"sigma_eff\" where there is `noise.vibration`, which no other label counts",
        );
        faults.check(
            (1..=window).contains(&noise.span(rate)),
            "noise.span_s",
            noise.span_s.unwrap_or(SPAN_S),
            format!("a sample ({} s) to a window ({} s)", rate.period(), window as f64 * rate.period()),
        );
        faults.check(
            self.fit.loss != Loss::LogNll || self.network.head == Head::LogSigmaAndSpread,
            "network.head",
            format!("\"{}\"", self.network.head),
            "\"log-sigma-and-spread\" for `fit.loss = \"log-nll\"`, which weighs errors by what the network says of itself",
        );
        faults.table("augment", self.augment.outside().0);
        faults.table("fit", fit.outside().0);
        faults.check(fit.epochs >= 1, "fit.epochs", fit.epochs, "at least 1");
        let every = fit.validate_every;
        faults.check(every >= 1, "fit.validate_every", every, "at least 1");
        let ema = fit.ema;
        faults.check((0.0..1.0).contains(&ema), "fit.ema", ema, "0 or more and below 1");
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_pronet::config::BlockOrder;

    fn read(text: &str) -> TrainConfig {
        parse(text, Path::new("a.toml"), Sensor::Gyro).unwrap()
    }

    #[test]
    fn keys_that_are_not_there_are_the_defaults_of_the_sensor() {
        assert_eq!(read("").resolved(), TrainConfig::for_sensor(Sensor::Gyro).resolved());
        let one = read("[network]\nleak = 0.2");
        let mut expected = TrainConfig::for_sensor(Sensor::Gyro);
        expected.network.leak = 0.2;
        assert_eq!(one, expected);
        assert_eq!(
            read("[network]\nsensor = \"accel\"").resolved(),
            TrainConfig::for_sensor(Sensor::Accel).resolved()
        );
    }

    #[test]
    fn single_keys_go_over_the_defaults_of_the_sensor() {
        let set = |key: &str, text: &str| [(key.to_owned(), text.to_owned())];
        let expected = {
            let mut config = TrainConfig::for_sensor(Sensor::Gyro);
            config.network.block_order = BlockOrder::ConvActNorm;
            config
        };
        for word in ["conv-act-norm", "\"conv-act-norm\""] {
            let config = load_over(None, &set("network.block_order", word), Sensor::Gyro).unwrap();
            assert_eq!(config.resolved(), expected.resolved());
        }
        let fault = |key, text| load_over(None, &set(key, text), Sensor::Gyro).unwrap_err().to_string();
        assert!(fault("fit.epochs", "0").starts_with("fit.epochs=0: `fit.epochs` is 0, "));
        assert!(fault("noise.draws", "fixed").contains("`draws` is gone since 0.2.0; "));
        for word in ["linear", "\"linear\"", "'linear'"] {
            let said = fault("network.head", word);
            assert!(said.contains("`linear` is gone since 0.2.0; write `head = "), "{said}");
        }
    }

    #[test]
    fn vibration_asks_for_the_label_that_counts_it_and_an_uncertainty_for_a_head_that_says_it() {
        let vibration = "[noise.vibration]\nshare = 0.5\ndeviation = [0.02, 3.0]\nhover_hz = [50.0, 150.0]";
        let fault = |text: &str| parse(text, Path::new("a.toml"), Sensor::Accel).unwrap_err().to_string();
        assert!(fault(vibration).contains("`noise.label` is \"sigma_inj\""), "{}", fault(vibration));
        let loss = "[fit]\nloss = \"log-nll\"";
        assert!(fault(loss).contains("`network.head` is"), "{}", fault(loss));
        let both = format!(
            "[noise]\nlabel = \"sigma_eff\"\nspan_s = 0.05\n{vibration}\n{loss}\n[network]\nhead = \"log-sigma-and-spread\""
        );
        assert_eq!(read(&both).noise.span(SampleRate::HZ_200), 10);
        assert!(fault(&both.replace("[0.02, 3.0]", "[3.0, 0.02]")).contains("noise.vibration.deviation"));
        assert!(fault(&both.replace("0.05", "2.0")).contains("noise.span_s"));
    }

    #[test]
    fn bad_values_of_all_tables_come_at_once() {
        let text = "[fit]\nepochs = 0\n[network]\nleak = 7.0\n[noise]\nlow = 1.0\nhigh = 0.5";
        let error = parse(text, Path::new("a.toml"), Sensor::Accel).unwrap_err().to_string();
        for key in ["fit.epochs", "network.leak", "noise.low"] {
            assert!(error.contains(key), "{key} is not in {error}");
        }
    }
}
