//! Bounds of the estimator's settings.

use super::EstimatorConfig;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};

impl Validate for EstimatorConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        let (window, health) = (&self.window, &self.health);
        faults.positive("imu.accel_bias_walk", self.imu.accel_bias_walk.get());
        faults.positive("imu.gyro_bias_walk", self.imu.gyro_bias_walk.get());
        faults.positive("window.pixel_std", window.pixel_std);
        faults.positive("window.loss_scale", window.loss_scale);
        faults.positive("window.followed_loss_px", window.followed_loss_px);
        faults.positive("window.min_triangulation_angle", window.min_triangulation_angle);
        faults.positive("window.outlier_px", window.outlier_px);
        faults.positive("health.max_accel_bias", health.max_accel_bias);
        faults.positive("health.max_gyro_bias", health.max_gyro_bias);
        faults.positive("health.max_jump", health.max_jump);
        faults.positive("health.max_speed", health.max_speed);
        faults.positive("health.max_starved", health.max_starved);
        faults.positive("health.max_imu_gap", health.max_imu_gap);
        faults.not_negative("window.key_frame_parallax_px", window.key_frame_parallax_px);
        faults.not_negative("window.cost_tolerance", window.cost_tolerance);
        let mut between = |key: &str, value: f64, low: f64, high: f64| {
            faults.check((low..=high).contains(&value), key, value, format!("from {low} to {high}"));
        };
        between("window.key_frame_min_share", window.key_frame_min_share, 0.0, 1.0);
        between("window.key_frames", window.key_frames as f64, 3.0, 30.0);
        between("window.max_iterations", window.max_iterations as f64, 1.0, 1000.0);
        self.delayed.check(&mut faults);
        if let Some(components) = &self.components {
            components.check(&mut faults);
        }
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
            "window.pixel_std",
            "health.max_speed",
            "window.key_frames",
            "init.min_frames",
            "front_end.klt.window",
        ];
        assert_eq!(keys, expected);
    }
}
