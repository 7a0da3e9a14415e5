//! Trainings as a plan asks for them.

use super::error::SweepError;
use dpn_core::Sensor;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_train::config::TrainConfig;
use std::path::PathBuf;

dpn_core::settings!(
    /// Trainings: every sensor with every configuration and every seed.
    pub struct TrainPlan {
        /// `train`.
        pub kind: String = "train".into(),
        /// Folder of ASL sequences; without it the simulated flights.
        pub data: Option<PathBuf> = None,
        /// The sensors.
        pub sensors: Vec<Sensor> = Sensor::ALL.to_vec(),
        /// Configurations (TOML); one that names a sensor is for that one alone. Without any the program's own.
        pub configs: Vec<PathBuf> = Vec::new(),
        /// The first seed.
        pub seed: u64 = 0,
        /// How many seeds, from the first on; 1 to 10000.
        pub seeds: u64 = 1,
        /// Epochs, over the configurations'.
        pub epochs: Option<u64> = None,
        /// Where to compute: cpu, or wgpu, a GPU, where the program is built with that feature.
        pub device: String = "cpu".into(),
    }
);

impl Validate for TrainPlan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.check(!self.sensors.is_empty(), "sensors", "[]", "accel, gyro or both");
        faults.within("seeds", self.seeds, 1, 10_000);
        faults.0
    }
}

impl TrainPlan {
    /// Every configuration with what its folder's name begins with.
    ///
    /// # Errors
    /// Files that are no configurations; one for none of the sensors.
    pub fn configurations(&self) -> Result<Vec<(String, TrainConfig)>, SweepError> {
        let mut found = Vec::new();
        for &sensor in &self.sensors {
            if self.configs.is_empty() {
                let mut config = TrainConfig::for_sensor(sensor);
                config.fit.epochs = self.epochs.unwrap_or(config.fit.epochs);
                found.push((sensor.to_string(), config));
            }
            for path in &self.configs {
                let mut config = dpn_train::config::load(path, sensor)?;
                if config.sensor() == sensor {
                    config.fit.epochs = self.epochs.unwrap_or(config.fit.epochs);
                    let stem = path.file_stem().expect("a configuration was read from it").to_string_lossy();
                    found.push((format!("{sensor}-{stem}"), config));
                }
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_written_plan_is_both_sensors_own_networks_and_a_configuration_is_for_the_sensor_it_names() {
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs");
        let plan: TrainPlan = dpn_io::config::load(&configs.join("sweep/train.toml")).unwrap();
        assert_eq!(plan, TrainPlan { seeds: 5, ..TrainPlan::default() });
        let names = |plan: &TrainPlan| -> Vec<String> {
            plan.configurations().unwrap().into_iter().map(|(name, _)| name).collect()
        };
        assert_eq!(names(&plan), ["accel", "gyro"]);
        let own = ["accel-wide.toml", "gyro-wide.toml"].map(|name| configs.join("train").join(name));
        let plan = TrainPlan { configs: own.to_vec(), epochs: Some(3), ..plan };
        assert_eq!(names(&plan), ["accel-accel-wide", "gyro-gyro-wide"]);
        assert!(plan.configurations().unwrap().iter().all(|(_, config)| config.fit.epochs == 3));
    }
}
