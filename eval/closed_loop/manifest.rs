//! What a sweep's folder was made from: `run.json`.

use super::error::ClosedLoopError;
use super::sweep_plan::Sweep;
use crate::noise::NoiseError;
use dpn_core::checksum::of_parts;
use dpn_core::estimate::NoiseSpec;
use dpn_io::{ResultPath, write_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a run is a function of, besides its cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The program: its version and, where known, a checksum of it.
    pub program: String,
    /// The estimator's settings, resolved.
    pub estimator: serde_json::Value,
    /// Where recordings and tracks come from, with all settings that a number depends on.
    pub source: serde_json::Value,
    /// Where runs begin: `table` or seconds; and where they end, if that is said.
    pub from: String,
    /// SHA-256 of every sequence's files.
    pub inputs: BTreeMap<String, String>,
    /// SHA-256 of all networks that noises may name.
    #[serde(default)]
    pub networks: String,
    /// The cells last asked for.
    pub cells: serde_json::Value,
}

impl Manifest {
    /// Of `sweep` by `program`.
    ///
    /// # Errors
    /// A sequence's file that cannot be read.
    pub fn of(sweep: &Sweep<'_>, program: String) -> Result<Self, ClosedLoopError> {
        let names = sweep.source.names();
        let mut inputs = BTreeMap::new();
        for &place in &sweep.places {
            inputs.insert(names[place].0.clone(), sweep.source.checksum(place)?);
        }
        let mut networks = Vec::new();
        for network in sweep.networks {
            networks.push(network.tag().into_bytes());
            networks.push(network.weights.to_bytes().map_err(NoiseError::from)?);
        }
        let mut source = sweep.source.description();
        if let Some(injection) = &sweep.injection {
            source["injection"] = serde_json::json!(injection);
        }
        let specs = |noises: &[NoiseSpec]| noises.iter().map(ToString::to_string).collect::<Vec<_>>();
        let sequences: Vec<&str> = sweep.places.iter().map(|place| names[*place].0.as_str()).collect();
        let mut cells = serde_json::json!({ "sequences": sequences, "noises": specs(&sweep.noises), "seeds": sweep.seeds });
        if !sweep.others.is_empty() {
            cells["others"] =
                serde_json::json!({ "noises": specs(&sweep.others), "seeds": sweep.other_seeds });
        }
        Ok(Self {
            program,
            estimator: serde_json::json!(sweep.estimator),
            source,
            from: sweep.to.map_or_else(|| sweep.from.to_string(), |to| format!("{} to {to}", sweep.from)),
            inputs,
            networks: of_parts(networks),
            cells,
        })
    }

    /// SHA-256 over all but the cells: runs that agree in it may share a folder.
    pub fn fingerprint(&self) -> String {
        let parts = [&self.program, &self.estimator.to_string(), &self.source.to_string(), &self.from];
        let inputs = self.inputs.iter().flat_map(|(name, sum)| [name.as_str(), sum]);
        of_parts(parts.map(String::as_str).into_iter().chain(inputs).chain([self.networks.as_str()]))
    }

    /// Writes it as `run.json` of `dir`, the inputs that were named there before among its own.
    ///
    /// # Errors
    /// A folder of another run, or one that cannot be written to; a file there that does not read.
    pub fn put_into(mut self, dir: &ResultPath) -> Result<(), ClosedLoopError> {
        let path = dir.join("run.json");
        if let Some(bytes) = path.read()? {
            let bad = |e: serde_json::Error| ClosedLoopError::BadRow {
                path: path.path().to_path_buf(),
                line: e.line(),
                message: e.to_string(),
            };
            let there: Self = serde_json::from_slice(&bytes).map_err(bad)?;
            if let Some((key, there, here)) = self.differs(&there) {
                return Err(ClosedLoopError::OtherRun { dir: dir.path().to_path_buf(), key, there, here });
            }
            for (name, sum) in there.inputs {
                self.inputs.entry(name).or_insert(sum);
            }
        }
        let text = serde_json::to_string_pretty(&self).expect("texts and JSON values") + "\n";
        Ok(write_file(&path, &text)?)
    }

    /// The first thing in which `there` is of another run. Networks are none: which of them a cell asks is in the cell's own checksum.
    pub(crate) fn differs(&self, there: &Self) -> Option<(String, String, String)> {
        let texts = |m: &Self| [m.program.clone(), m.from.clone()];
        for ((key, there), here) in ["program", "start"].into_iter().zip(texts(there)).zip(texts(self)) {
            if there != here {
                return Some((key.into(), there, here));
            }
        }
        for (key, there, here) in
            [("estimator", &there.estimator, &self.estimator), ("source", &there.source, &self.source)]
        {
            if let Some((path, there, here)) = difference(key, there, here) {
                return Some((path, there, here));
            }
        }
        self.inputs.iter().find_map(|(name, here)| {
            let there = there.inputs.get(name).filter(|there| *there != here)?;
            Some((format!("input of {name}"), there.clone(), here.clone()))
        })
    }
}

/// The first place in which two values differ.
fn difference(
    path: &str,
    there: &serde_json::Value,
    here: &serde_json::Value,
) -> Option<(String, String, String)> {
    use serde_json::Value::Object;
    match (there, here) {
        (Object(a), Object(b)) => {
            let keys = a.keys().chain(b.keys());
            let null = serde_json::Value::Null;
            keys.into_iter().find_map(|key| {
                let (a, b) = (a.get(key).unwrap_or(&null), b.get(key).unwrap_or(&null));
                difference(&format!("{path}.{key}"), a, b)
            })
        }
        _ if there == here => None,
        _ => Some((path.to_owned(), there.to_string(), here.to_string())),
    }
}
