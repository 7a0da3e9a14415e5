//! Trained networks on disk, and what each was trained for.

use crate::{StoreError, Weights};
use dpn_core::signal::BlockLength;
use dpn_core::{SampleRate, Sensor};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A trained network and what its card says of the training.
#[derive(Debug, Clone)]
pub struct Network {
    /// The weights.
    pub weights: Weights,
    /// Name in tables, for example `pronet`.
    pub name: String,
    /// Base it was trained on.
    pub base: String,
    /// `grid` or `continuous`.
    pub levels: String,
    /// `sigma_inj`, `sigma_tot` or `sigma_eff`.
    pub label: String,
    /// Seed of the training.
    pub seed: u64,
    /// The file.
    pub path: PathBuf,
}

/// Why networks cannot be used.
#[derive(Debug, Error)]
pub enum NetworkError {
    /// A file that cannot be read or is no network.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A folder that cannot be listed.
    #[error("cannot list {}: {source}", path.display())]
    List {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A card that does not say what the network was trained for.
    #[error("{}: its card does not say `{key}`; train the network with this version of dpn", path.display())]
    Card {
        /// The file.
        path: PathBuf,
        /// What is missing.
        key: &'static str,
    },
}

impl Network {
    /// Reads one file; which sensor it is for stands in it.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or whose card lacks what the training was for.
    pub fn load(path: &Path) -> Result<Self, NetworkError> {
        Self::of(Weights::load(path)?, path)
    }

    /// Reads a file's bytes at hand; `path` names them.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, NetworkError> {
        Self::of(Weights::from_bytes(bytes, path)?, path)
    }

    fn of(weights: Weights, path: &Path) -> Result<Self, NetworkError> {
        let training = weights.card().training.clone();
        let text = |key: &'static str| {
            let value = training.get(key).and_then(|value| value.as_str()).map(str::to_owned);
            value.ok_or_else(|| NetworkError::Card { path: path.to_owned(), key })
        };
        let seed = training.get("seed").and_then(serde_json::Value::as_u64);
        Ok(Self {
            name: text("name")?,
            base: text("base")?,
            levels: text("levels")?,
            label: text("label")?,
            seed: seed.ok_or_else(|| NetworkError::Card { path: path.to_owned(), key: "seed" })?,
            path: path.to_owned(),
            weights,
        })
    }

    /// The name of its file without the ending; what a noise spec calls it.
    pub fn tag(&self) -> String {
        self.path.file_stem().expect("a file has a name").to_string_lossy().into_owned()
    }

    /// The sensor it is for.
    pub fn sensor(&self) -> Sensor {
        self.weights.sensor()
    }
}

/// A network that is asked for by name and is not there.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("there is no {sensor} network `{tag}`; known are {}", if known.is_empty() { "none".to_owned() } else { known.join(", ") })]
pub struct UnknownNetwork {
    /// The sensor.
    pub sensor: Sensor,
    /// What was asked for.
    pub tag: String,
    /// Every tag there is for that sensor.
    pub known: Vec<String>,
}

/// The network of a sensor whose weight file is called `tag`.
///
/// # Errors
/// None of that name.
pub fn select<'a>(networks: &'a [Network], sensor: Sensor, tag: &str) -> Result<&'a Network, UnknownNetwork> {
    let of_sensor = || networks.iter().filter(|network| network.sensor() == sensor);
    of_sensor().find(|network| network.tag() == tag).ok_or_else(|| UnknownNetwork {
        sensor,
        tag: tag.to_owned(),
        known: of_sensor().map(Network::tag).collect(),
    })
}

/// Parts the name of a training from the rate of its windows: `sg11-s0@100` is `sg11-s0` for samples of 100 Hz.
const AT: char = '@';

/// The networks of a sensor that go by `tag`, at whatever rate: that of this name, and those called `tag@HZ`.
pub fn variants<'a>(networks: &'a [Network], sensor: Sensor, tag: &str) -> impl Iterator<Item = &'a Network> {
    networks.iter().filter(move |network| {
        let own = network.tag();
        let is_variant = || own.strip_prefix(tag).is_some_and(|rest| rest.starts_with(AT));
        network.sensor() == sensor && (own == tag || is_variant())
    })
}

/// Of the networks of a sensor that go by `tag` the one for samples of `rate`: the fastest that the samples reach, or, where they reach none, the slowest.
///
/// # Errors
/// None of that name.
pub fn select_for<'a>(
    networks: &'a [Network],
    sensor: Sensor,
    tag: &str,
    rate: SampleRate,
) -> Result<&'a Network, UnknownNetwork> {
    let trained = |network: &&Network| network.weights.card().rate;
    let by_rate = |a: &&Network, b: &&Network| trained(a).hz().total_cmp(&trained(b).hz());
    let of_tag = || variants(networks, sensor, tag);
    let reached =
        of_tag().filter(|network| BlockLength::of(rate, trained(network)).is_some()).max_by(by_rate);
    // Whether it is there at all, and if not, what is.
    reached.or_else(|| of_tag().min_by(by_rate)).map_or_else(|| select(networks, sensor, tag), Ok)
}

/// Every network (`*.safetensors`, checkpoints left out) in `dir` and the folders in it, sorted by path.
///
/// # Errors
/// A folder that cannot be listed; a file that is no network.
pub fn load_all(dir: &Path) -> Result<Vec<Network>, NetworkError> {
    let mut files = Vec::new();
    collect(dir, 3, &mut files)?;
    files.sort();
    files.iter().map(|path| Network::load(path)).collect()
}

fn collect(dir: &Path, depth: usize, files: &mut Vec<PathBuf>) -> Result<(), NetworkError> {
    let failed = |source| NetworkError::List { path: dir.to_owned(), source };
    for entry in std::fs::read_dir(dir).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            if depth > 0 {
                collect(&path, depth - 1, files)?;
            }
        } else if path.extension().is_some_and(|e| e == "safetensors")
            && path.file_stem().is_some_and(|stem| stem != "checkpoint")
        {
            files.push(path);
        }
    }
    Ok(())
}
