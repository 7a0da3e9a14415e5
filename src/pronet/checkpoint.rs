//! A training in a file, to the bit: network, Adam's state, and whatever vectors and notes the trainer adds.
//!
//! Resumed from it, training goes on to the same bits as if it had never stopped: all state is `f32` vectors and a count of steps.

use crate::adam::{Adam, AdamConfig};
use crate::config::ProNetConfig;
use crate::shape::parameter_count;
use crate::store::{self, Named, StoreError};
use dpn_core::config::Validate;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// What a checkpoint calls itself.
const FORMAT: &str = "dpn-pronet-checkpoint";
/// Put before the trainer's own vectors' names in the file.
const EXTRA: &str = "extra.";

/// The state of a training between two steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// The network's configuration.
    pub config: ProNetConfig,
    /// Its numbers, in the order of [`crate::shape::parameters`].
    pub parameters: Vec<f32>,
    /// The optimiser.
    pub adam: Adam,
    /// The trainer's own vectors, for example averaged or best parameters.
    pub vectors: BTreeMap<String, Vec<f32>>,
    /// The trainer's own notes: epoch, seed, losses so far. Numbers of `f64` survive to the bit.
    pub notes: Map<String, Value>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    config: ProNetConfig,
    adam: AdamConfig,
    steps: u64,
    notes: Map<String, Value>,
}

impl Checkpoint {
    /// The bytes of its file.
    ///
    /// # Errors
    /// A configuration or notes that cannot be written as JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let named = |name: &str, numbers: &[f32]| Named {
            name: name.to_owned(),
            shape: vec![numbers.len()],
            numbers: numbers.to_vec(),
        };
        let mut tensors = vec![
            named("parameters", &self.parameters),
            named("adam.mean", &self.adam.mean),
            named("adam.square", &self.adam.square),
        ];
        tensors.extend(self.vectors.iter().map(|(name, v)| named(&format!("{EXTRA}{name}"), v)));
        let description = Description {
            config: self.config.clone(),
            adam: *self.adam.config(),
            steps: self.adam.steps,
            notes: self.notes.clone(),
        };
        store::to_bytes(FORMAT, &description, &tensors, Path::new("checkpoint"))
    }

    /// Reads it.
    ///
    /// # Errors
    /// A file that cannot be read, is truncated or damaged, is no checkpoint or another version's, has missing or misshapen
    /// vectors, or holds NaN or infinity.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, StoreError> {
        let path = path.as_ref();
        Self::from_bytes(&store::read(path)?, path)
    }

    /// Takes a file's bytes; `path` is for messages.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, StoreError> {
        let (d, mut tensors): (Description, _) = store::from_bytes(FORMAT, bytes, path)?;
        d.config
            .validate()
            .map_err(|e| StoreError::Description { path: path.to_owned(), detail: e.to_string() })?;
        let count = [parameter_count(&d.config)];
        let parameters = store::take(&mut tensors, "parameters", &count, path)?;
        let mean = store::take(&mut tensors, "adam.mean", &count, path)?;
        let square = store::take(&mut tensors, "adam.square", &count, path)?;
        let names: Vec<String> = tensors.keys().filter(|n| n.starts_with(EXTRA)).cloned().collect();
        let mut vectors = BTreeMap::new();
        for name in names {
            if let Some(tensor) = tensors.remove(&name) {
                vectors.insert(name[EXTRA.len()..].to_owned(), tensor.numbers);
            }
        }
        store::nothing_left(&tensors, path)?;
        Ok(Self {
            config: d.config,
            parameters,
            adam: Adam::resumed(d.adam, [mean, square], d.steps),
            vectors,
            notes: d.notes,
        })
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::{Device, Trainable};
    use dpn_core::random::Stream;
    use rand::Rng;
    use serde_json::json;

    fn config() -> ProNetConfig {
        ProNetConfig {
            window: 40,
            channels: vec![4, 6],
            kernels: vec![5, 3],
            strides: vec![1, 2],
            paddings: vec![2, 1],
            hidden: vec![5],
            ..ProNetConfig::default()
        }
    }

    fn start() -> Checkpoint {
        let config = config();
        let parameters = crate::init::initial_parameters(&config, &Stream::new(2));
        Checkpoint {
            adam: Adam::new(AdamConfig::default(), parameters.len()),
            vectors: BTreeMap::from([("best".to_owned(), vec![0.1, -0.0, 1e-40])]),
            notes: Map::from_iter([("loss".to_owned(), json!(0.1 + 0.2))]),
            config,
            parameters,
        }
    }

    /// One step on the windows of `epoch`.
    fn step(state: &mut Checkpoint, epoch: u64) {
        let mut rng = Stream::new(5).named("batch").index(epoch).rng();
        let x: Vec<f32> = (0..33 * 40).map(|_| 0.3 * rng.random::<f32>()).collect();
        let network = Trainable::new(&state.config, &Device::Cpu).unwrap();
        let (_, gradient) = network.gradient(&state.parameters, &x, |sigma| {
            (0.0, sigma.iter().map(|sigma| (sigma - 0.1) * 200.0 / 33.0).collect())
        });
        state.adam.step(&mut state.parameters, &gradient, 1e-3);
    }

    #[test]
    fn a_training_cut_in_two_ends_in_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        let mut whole = start();
        (0..6).for_each(|epoch| step(&mut whole, epoch));
        let mut first = start();
        (0..3).for_each(|epoch| step(&mut first, epoch));
        std::fs::write(&path, first.to_bytes().unwrap()).unwrap();
        let mut second = Checkpoint::load(&path).unwrap();
        assert_eq!(second, first);
        (3..6).for_each(|epoch| step(&mut second, epoch));
        assert_eq!(second, whole);
        assert_ne!(second.parameters, start().parameters);
        assert_eq!(second.adam.steps(), 6);
    }

    #[test]
    fn weights_are_no_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("w.safetensors");
        let state = start();
        let weights = crate::Weights::new(&state.config, state.parameters, crate::Card::default());
        std::fs::write(&path, weights.to_bytes().unwrap()).unwrap();
        let message = Checkpoint::load(&path).unwrap_err().to_string();
        assert!(message.contains("dpn-pronet-weights, where dpn-pronet-checkpoint is needed"), "{message}");
    }

    #[test]
    fn results_are_the_same_bits_on_one_thread_and_on_three() {
        let run = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                let mut state = start();
                (0..3).for_each(|epoch| step(&mut state, epoch));
                state.parameters
            })
        };
        assert_eq!(run(1), run(3));
    }
}
