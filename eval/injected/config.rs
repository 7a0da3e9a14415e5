//! What is added, how much, and what is there without it.

use super::course::Course;
use dpn_core::config::Limit;

dpn_core::settings!(
    /// What is added to a recording's samples. An injection is a function of this, of the recording's name and of a seed.
    ///
    /// The defaults were chosen on the training sequences (docs/src/when.md); own noise is x4, the best constant on them.
    #[derive(Copy)]
    pub struct Injection {
        /// How it changes over the recording. Default `step`.
        pub course: Course = Course::Step,
        /// Deviation at x1 on every axis of the accelerometer \[m/s^2\], 0 to 100.
        pub accel: f64 = 0.4 => 0.0..=100.0,
        /// Deviation at x1 on every axis of the gyroscope \[rad/s\], 0 to 100.
        pub gyro: f64 = 0.02 => 0.0..=100.0,
        /// The change: deviations go from x1 to this many times that, 1 to 100. Default 5, the paper's range.
        pub factor: f64 = 5.0 => 1.0..=100.0,
        /// What the odometry is best told where nothing is added: accelerometer \[m/s^2\], above 0 and up to 100.
        pub own_accel: f64 = 0.32 => Limit::AtMost(100.0),
        /// The same of the gyroscope \[rad/s\], above 0 and up to 100.
        pub own_gyro: f64 = 0.016 => Limit::AtMost(100.0),
    }
    impl Validate
);

impl Injection {
    /// The same strengths in another course.
    #[must_use]
    pub fn with(self, course: Course) -> Self {
        Self { course, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_written_configuration_is_the_default_and_bad_values_are_named() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/injected/step.toml");
        assert_eq!(dpn_io::config::load::<Injection>(&path).unwrap(), Injection::default());
        let text = "accel = -1.0\nown_gyro = 0.0\nfactor = 0.5";
        let error = dpn_io::config::parse::<Injection>(text, Path::new("a.toml")).unwrap_err().to_string();
        for key in ["accel", "own_gyro", "factor"] {
            assert!(error.contains(key), "{error}");
        }
    }
}
