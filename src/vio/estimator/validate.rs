//! Bounds of the estimator's settings.

use super::EstimatorConfig;
use dpn_core::config::{ConfigFault, Validate};

impl Validate for EstimatorConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = Vec::new();
        let (window, health) = (&self.window, &self.health);
        let positive = [
            ("imu.accel_bias_walk", self.imu.accel_bias_walk.get()),
            ("imu.gyro_bias_walk", self.imu.gyro_bias_walk.get()),
            ("window.pixel_std", window.pixel_std),
            ("window.loss_scale", window.loss_scale),
            ("window.min_triangulation_angle", window.min_triangulation_angle),
            ("window.outlier_px", window.outlier_px),
            ("health.max_accel_bias", health.max_accel_bias),
            ("health.max_gyro_bias", health.max_gyro_bias),
            ("health.max_jump", health.max_jump),
            ("health.max_speed", health.max_speed),
            ("health.max_starved", health.max_starved),
            ("health.max_imu_gap", health.max_imu_gap),
        ];
        for (key, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                faults.push(ConfigFault::new(key, value, "positive and finite"));
            }
        }
        let not_negative = [
            ("window.key_frame_parallax_px", window.key_frame_parallax_px),
            ("window.cost_tolerance", window.cost_tolerance),
        ];
        for (key, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(ConfigFault::new(key, value, "0 or more, and finite"));
            }
        }
        if !(0.0..=1.0).contains(&window.key_frame_min_share) {
            faults.push(ConfigFault::new(
                "window.key_frame_min_share",
                window.key_frame_min_share,
                "from 0 to 1",
            ));
        }
        if !(3..=30).contains(&window.key_frames) {
            faults.push(ConfigFault::new("window.key_frames", window.key_frames, "from 3 to 30"));
        }
        if !(1..=1000).contains(&window.max_iterations) {
            faults.push(ConfigFault::new("window.max_iterations", window.max_iterations, "from 1 to 1000"));
        }
        for (table, inner) in [("init", self.init.faults()), ("front_end", self.front_end.faults())] {
            let named = inner.into_iter();
            faults.extend(named.map(|fault| ConfigFault { key: format!("{table}.{}", fault.key), ..fault }));
        }
        faults
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
