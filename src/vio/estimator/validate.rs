//! Bounds of the estimator's settings.

use super::EstimatorConfig;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};

impl Validate for EstimatorConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.positive("imu.accel_bias_walk", self.imu.accel_bias_walk.get());
        faults.positive("imu.gyro_bias_walk", self.imu.gyro_bias_walk.get());
        faults.table("window", self.window.outside().0);
        faults.table("health", self.health.outside().0);
        faults.table("delayed", self.delayed.outside().0);
        faults.table("components", self.components.iter().flat_map(Validate::faults).collect());
        faults.table("init", self.init.faults());
        faults.table("front_end", self.front_end.faults());
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_have_no_fault_and_faults_come_all_at_once_under_their_tables() {
        assert!(EstimatorConfig::default().faults().is_empty());
        let mut config = EstimatorConfig::default();
        config.window.key_frames = 2;
        config.window.pixel_std = f64::NAN;
        config.init.min_frames = 1;
        config.health.max_speed = 0.0;
        config.front_end.klt.window = 20;
        let keys: Vec<_> = config.faults().into_iter().map(|f| f.key).collect();
        let expected = [
            "window.key_frames",
            "window.pixel_std",
            "health.max_speed",
            "init.min_frames",
            "front_end.klt.window",
        ];
        assert_eq!(keys, expected);
    }
}
