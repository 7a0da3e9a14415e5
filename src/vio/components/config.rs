//! Settings of learning.

use dpn_core::config::{ConfigFault, Validate};
use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};

dpn_core::settings!(
    /// How levels are learned, and below what none is believed: the data sheet.
    #[derive(Copy)]
    pub struct ComponentsConfig {
        /// Time after which a residual counts for a third \[s\]; 1 to 1000.
        pub memory_s: f64 = 10.0 => 1.0..=1000.0,
        /// Residuals are read over so much time \[s\], within the window; 0 to 10. What matters is the error that noise adds up to, and vibration's adds up
        /// less than white noise: over one interval alone it looks several times as large.
        pub span_s: f64 = 1.5 => 0.0..=10.0,
        /// What is told counts at the start as so many observations of a variance; 0.1 to 1000.
        pub prior: f64 = 2.0 => 0.1..=1000.0,
        /// Least noise of the accelerometer \[m/s^2/sqrt(Hz)\]. Default EuRoC's data sheet.
        pub accel_floor: AccelNoiseDensity = AccelNoiseDensity::EUROC,
        /// Least noise of the gyroscope \[rad/s/sqrt(Hz)\]. Default EuRoC's data sheet.
        pub gyro_floor: GyroNoiseDensity = GyroNoiseDensity::EUROC,
        /// Least walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\]. Default EuRoC's data sheet.
        pub accel_walk_floor: AccelBiasWalkDensity = AccelBiasWalkDensity::EUROC,
        /// Least walk of the gyroscope's bias \[rad/s^2/sqrt(Hz)\]. Default EuRoC's data sheet.
        pub gyro_walk_floor: GyroBiasWalkDensity = GyroBiasWalkDensity::EUROC,
        /// Whether the pixels' level is learned too.
        pub pixels: bool = true,
        /// Least deviation of a pixel \[px\] of tracks that are fed.
        pub pixel_floor: f64 = 0.5 => 0.01..=10.0,
        /// The same where points are followed through images. What such a point is off lasts and is shared by its neighbours; residuals within a window show only
        /// a part of it.
        pub followed_pixel_floor: f64 = 0.7 => 0.01..=10.0,
    }
);

impl Validate for ComponentsConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        // A floor above all that sensors have would be a constant under another name.
        for (key, value) in [
            ("accel_floor", self.accel_floor.get()),
            ("gyro_floor", self.gyro_floor.get()),
            ("accel_walk_floor", self.accel_walk_floor.get()),
            ("gyro_walk_floor", self.gyro_walk_floor.get()),
        ] {
            faults.within(key, value, 1e-9, 10.0);
        }
        faults.0
    }
}
