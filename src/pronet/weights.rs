//! A trained network in a file: numbers by their PyTorch names, and what is needed to use them rightly.

use crate::config::ProNetConfig;
use crate::range::TrainedRange;
use crate::shape::{ParameterShape, parameters};
use crate::store::{self, Named, StoreError};
use dpn_core::config::Validate;
use dpn_core::{SampleRate, Sensor};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// What a file of weights calls itself.
const FORMAT: &str = "dpn-pronet-weights";

/// A trained network: configuration, numbers and what to know about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    config: ProNetConfig,
    parameters: Vec<f32>,
    card: Card,
}

/// What to know about a network besides its configuration and numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Sampling rate of the windows it was trained on \[Hz\].
    pub rate: SampleRate,
    /// Range of the windows it was trained on; nothing is counted as outside when not given.
    pub range: Option<TrainedRange>,
    /// The training in the trainer's own words: seed, data, steps, errors.
    pub training: Map<String, Value>,
}

impl Default for Card {
    fn default() -> Self {
        Self { rate: SampleRate::HZ_200, range: None, training: Map::new() }
    }
}

/// The description in the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    sensor: Sensor,
    /// Unit of windows and deviations.
    unit: String,
    /// The numbers windows are divided and outputs multiplied by.
    input_scale: f64,
    output_scale: f64,
    config: ProNetConfig,
    card: Card,
}

impl Weights {
    /// Joins what belongs together.
    ///
    /// # Panics
    /// When `parameters` has not as many numbers as the configuration asks for, or the configuration has faults.
    pub fn new(config: &ProNetConfig, parameters: Vec<f32>, card: Card) -> Self {
        assert!(config.validate().is_ok(), "weights need a checked configuration");
        let count = crate::shape::parameter_count(config);
        assert_eq!(parameters.len(), count, "the network has {count} parameters");
        Self { config: config.resolved(), parameters, card }
    }

    /// The configuration, all defaults written out.
    pub fn config(&self) -> &ProNetConfig {
        &self.config
    }

    /// The numbers in the order of [`crate::shape::parameters`].
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// What to know about them.
    pub fn card(&self) -> &Card {
        &self.card
    }

    /// Which sensor they are for.
    pub fn sensor(&self) -> Sensor {
        self.config.sensor
    }

    /// The bytes of their safetensors file: the same weights are the same bytes.
    ///
    /// # Errors
    /// A training summary that cannot be written as JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let tensors: Vec<Named> = parameters(&self.config)
            .into_iter()
            .map(|p| Named {
                numbers: self.parameters[p.offset..p.offset + p.len()].to_vec(),
                name: p.name,
                shape: p.shape,
            })
            .collect();
        let description = Description {
            sensor: self.sensor(),
            unit: self.sensor().unit().to_owned(),
            input_scale: self.config.input_scale(),
            output_scale: self.config.output_scale(),
            config: self.config.clone(),
            card: self.card.clone(),
        };
        store::to_bytes(FORMAT, &description, &tensors, Path::new("weights"))
    }

    /// Reads a network.
    ///
    /// # Errors
    /// A file that cannot be read, is truncated or damaged, was not written by dpn or by another version, has missing, unknown or misshapen
    /// tensors, or holds NaN or infinity.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, StoreError> {
        let path = path.as_ref();
        Self::from_bytes(&store::read(path)?, path)
    }

    /// Takes a file's bytes, for example of weights built into a program; `path` is for messages.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, StoreError> {
        let (description, mut tensors): (Description, _) = store::from_bytes(FORMAT, bytes, path)?;
        let config = description.config;
        let unusable = |detail: String| StoreError::Description { path: path.to_owned(), detail };
        config.validate().map_err(|e| unusable(e.to_string()))?;
        if config.sensor != description.sensor || config.sensor.unit() != description.unit {
            let (sensor, unit) = (description.sensor, description.unit);
            return Err(unusable(format!(
                "sensor {sensor} in {unit}, but its configuration is the {}'s",
                config.sensor
            )));
        }
        if SampleRate::from_hz(description.card.rate.hz()).is_none() {
            return Err(unusable(format!("a rate of {} Hz", description.card.rate.hz())));
        }
        let mut flat = Vec::new();
        for ParameterShape { name, shape, .. } in parameters(&config) {
            flat.extend(store::take(&mut tensors, &name, &shape, path)?);
        }
        store::nothing_left(&tensors, path)?;
        Ok(Self { config: config.resolved(), parameters: flat, card: description.card })
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::init::initial_parameters;
    use dpn_core::random::Stream;
    use proptest::prelude::*;
    use serde_json::json;

    fn weights(sensor: Sensor) -> Weights {
        let config = ProNetConfig {
            channels: vec![3, 4],
            kernels: vec![3, 3],
            strides: vec![1, 2],
            paddings: vec![1, 1],
            hidden: vec![5],
            ..ProNetConfig::for_sensor(sensor)
        };
        let flat = initial_parameters(&config, &Stream::new(1).named("weights"));
        let card = Card {
            range: TrainedRange::spanning([[0.0f32, 1.0, 0.5, 2.0].as_slice()]),
            training: Map::from_iter([("seed".to_owned(), json!(1))]),
            ..Card::default()
        };
        Weights::new(&config, flat, card)
    }

    fn parse(bytes: &[u8]) -> Result<Weights, StoreError> {
        Weights::from_bytes(bytes, Path::new("file"))
    }

    /// The same file with `from` replaced in its header by `to`, of the same length.
    fn forged(from: &str, to: &str) -> Result<Weights, StoreError> {
        parse(&replaced(from, to))
    }

    fn replaced(from: &str, to: &str) -> Vec<u8> {
        assert_eq!(from.len(), to.len());
        let mut bytes = weights(Sensor::Accel).to_bytes().unwrap();
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        bytes
    }

    #[test]
    fn what_is_written_is_loaded_and_the_bytes_are_the_same_twice() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gyro.safetensors");
        let saved = weights(Sensor::Gyro);
        std::fs::write(&path, saved.to_bytes().unwrap()).unwrap();
        assert_eq!(Weights::load(&path).unwrap(), saved);
        assert_eq!(saved.to_bytes().unwrap(), weights(Sensor::Gyro).to_bytes().unwrap());
    }

    #[test]
    fn every_truncation_is_an_error() {
        let bytes = weights(Sensor::Accel).to_bytes().unwrap();
        for len in 0..bytes.len() {
            assert!(matches!(parse(&bytes[..len]), Err(StoreError::Container { .. })), "{len}");
        }
    }

    #[test]
    fn version_and_format_are_read_before_the_rest() {
        // Inside the description quotes are escaped.
        assert!(matches!(forged("\\\"version\\\":2", "\\\"version\\\":1"), Err(StoreError::Version { .. })));
        assert!(matches!(forged("pronet-weights", "pronet-w3ights"), Err(StoreError::Format { .. })));
    }

    #[test]
    fn a_key_that_is_gone_is_named_with_what_to_do() {
        let error = forged("\\\"input_scale\\\"", "\\\"standardise\\\"").unwrap_err().to_string();
        let said = "(`standardise` is gone since 0.2.0; train again, or take such keys out of the file by";
        assert!(error.contains(said), "{error}");
    }

    #[test]
    fn one_changed_number_breaks_the_checksum_and_nan_is_named() {
        let mut bytes = weights(Sensor::Accel).to_bytes().unwrap();
        let last = bytes.len() - 4;
        bytes[last] ^= 1;
        assert!(matches!(parse(&bytes), Err(StoreError::Checksum { .. })));
        bytes[last..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(parse(&bytes), Err(StoreError::NotFinite { .. })));
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_among_the_weights_is_an_error_and_nobody_waits_for_it() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("sg11-s0.safetensors");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let error = crate::network::load_all(tmp.path()).unwrap_err();
        let causes: Vec<String> =
            std::iter::successors(Some(&error as &dyn std::error::Error), |e| e.source())
                .map(ToString::to_string)
                .collect();
        assert!(causes.concat().contains("not a regular file"), "{causes:?}");
    }

    #[test]
    fn a_changed_description_breaks_the_checksum() {
        let good = weights(Sensor::Accel).to_bytes().unwrap();
        // Inside the description quotes are escaped.
        for key in ["input_scale", "output_scale", "hidden", "seed", "sha256"] {
            let key = format!("{key}\\\":");
            for (at, _) in good.windows(key.len()).enumerate().filter(|(_, part)| *part == key.as_bytes()) {
                let digit =
                    at + key.len() + good[at + key.len()..].iter().position(u8::is_ascii_digit).unwrap();
                let mut bytes = good.clone();
                bytes[digit] = if bytes[digit] == b'9' { b'8' } else { bytes[digit] + 1 };
                assert!(matches!(parse(&bytes), Err(StoreError::Checksum { .. })), "{key} at {at}");
            }
        }
    }

    #[test]
    fn a_tensor_of_another_shape_is_named() {
        // fc1 has five outputs; six are asked for, and the file is signed so.
        let (from, to) = ("\\\"hidden\\\":[5]", "\\\"hidden\\\":[6]");
        match parse(&store::signed(replaced(from, to))) {
            Err(StoreError::Shape { name, found, wanted, .. }) => {
                assert_eq!(
                    (name.as_str(), found.as_str(), wanted.as_str()),
                    ("fc1.weight", "[5, 4]", "[6, 4]")
                );
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_missing_file_is_said_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/w.safetensors");
        let error = Weights::load(&path).unwrap_err();
        assert!(error.to_string().contains("none/w.safetensors: cannot be read"), "{error}");
    }

    proptest! {
        #[test]
        fn mutated_files_never_panic(at in 0usize..4000, value: u8) {
            let mut bytes = weights(Sensor::Accel).to_bytes().unwrap();
            let at = at % bytes.len();
            let changed = bytes[at] != value;
            bytes[at] = value;
            // A change in the header's padding or in a float's spelling may be harmless; in the numbers it is not.
            if parse(&bytes).is_ok() && changed {
                prop_assert!(at < bytes.len() - 4 * weights(Sensor::Accel).parameters.len());
            }
        }
    }
}
