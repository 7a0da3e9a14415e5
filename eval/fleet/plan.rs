//! Which platforms, and which noises on them.

use crate::closed_loop::Experiment;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::estimate::NoiseSpec;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A fleet.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FleetPlan {
    /// `fleet`, where a sweep is to be cut of it.
    #[serde(default)]
    pub kind: Option<String>,
    /// Constants that are swept on every platform; its best one is what all others are scored by.
    pub constants: Vec<NoiseSpec>,
    /// What is scored beside them.
    pub noises: Vec<NoiseSpec>,
    /// The platforms.
    pub platform: Vec<Platform>,
}

/// One platform.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Platform {
    /// What a reader calls it.
    pub name: String,
    /// The folder of its rows, in that of the results.
    pub folder: String,
    /// Whether its ground truth is reconciled with its IMU before anything is run (`dpn truth`).
    #[serde(default)]
    pub reconciled: bool,
    /// What is run on it; its noises are the fleet's. A relative `data` is looked for in the folder of the data packs.
    #[serde(default)]
    pub run: Experiment,
}

impl FleetPlan {
    /// Constants first, then the others, each once.
    pub fn all_noises(&self) -> Vec<NoiseSpec> {
        let mut all: Vec<NoiseSpec> = Vec::new();
        for noise in self.constants.iter().chain(&self.noises) {
            if !all.contains(noise) {
                all.push(noise.clone());
            }
        }
        all
    }
}

impl Platform {
    /// Its experiment with the fleet's `noises`, its data in `data`; `truth` is where reconciled ground truth is.
    pub fn experiment(&self, noises: Vec<NoiseSpec>, data: &Path, truth: &Path) -> Experiment {
        Experiment {
            noises,
            data: self.data(data),
            truth: self.reconciled.then(|| truth.to_path_buf()).or_else(|| self.run.truth.clone()),
            ..self.run.clone()
        }
    }

    /// The folder of its sequences, in `data` where it is relative; none for simulated flights.
    pub fn data(&self, data: &Path) -> Option<PathBuf> {
        self.run.data.as_ref().map(|own| data.join(own))
    }
}

impl Validate for FleetPlan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        let constant = self.constants.iter().all(NoiseSpec::is_constant);
        let names = self.constants.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        faults.check(constant && !self.constants.is_empty(), "constants", names, "constants, one or more");
        faults.check(!self.platform.is_empty(), "platform", "[]", "one platform or more");
        let mut folders = BTreeSet::new();
        for (i, platform) in self.platform.iter().enumerate() {
            let key = |name: &str| format!("platform[{i}].{name}");
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            let sound = !platform.folder.is_empty() && platform.folder.chars().all(plain);
            faults.check(sound, key("folder"), &platform.folder, "lower-case letters, digits and hyphens");
            faults.check(
                folders.insert(&platform.folder),
                key("folder"),
                &platform.folder,
                "unlike the others'",
            );
            let has_data = !platform.reconciled || platform.run.data.is_some();
            faults.check(has_data, key("reconciled"), true, "left out where there is no `data`");
            let run = Experiment { noises: self.constants.clone(), ..platform.run.clone() };
            faults.table(&key("run"), run.faults());
        }
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<FleetPlan, String> {
        dpn_io::config::parse(text, Path::new("fleet.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn the_files_of_the_folder_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/fleet");
        let plan: FleetPlan = dpn_io::config::load(&folder.join("fleet.toml")).unwrap();
        assert!(plan.platform.len() >= 6 && plan.platform.iter().any(|platform| platform.reconciled));
        let run = plan.platform[0].experiment(plan.all_noises(), Path::new("packs"), Path::new("t"));
        assert_eq!((run.data.as_deref(), run.truth), (Some(Path::new("packs/euroc")), None));
        assert_eq!(run.noises.len(), plan.constants.len() + plan.noises.len());
    }

    #[test]
    fn faults_are_named_with_their_platform() {
        let error = parse(
            "constants = [\"self\"]\nnoises = []\n[[platform]]\nname = \"a\"\nfolder = \"../a\"\nreconciled = true\n\
             [[platform]]\nname = \"b\"\nfolder = \"b\"\n[platform.run]\nseeds = 0\n[[platform]]\nname = \"b\"\nfolder = \"b\"",
        )
        .unwrap_err();
        for words in [
            "`constants` is self",
            "`platform[0].folder` is ../a",
            "`platform[0].reconciled` is true",
            "`platform[1].run.seeds` is 0",
            "`platform[2].folder` is b",
        ] {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
