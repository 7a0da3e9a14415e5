//! Settings of learning.

use dpn_core::config::ConfigFaults;
use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
use serde::{Deserialize, Serialize};

/// How levels are learned, and below what none is believed: the data sheet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ComponentsConfig {
    /// Time after which a residual counts for a third \[s\]; 1 to 1000.
    pub memory_s: f64,
    /// Residuals are read over so much time \[s\], within the window; 0 to 10. What matters is the error that noise adds up to, and vibration's adds up
    /// less than white noise: over one interval alone it looks several times as large.
    pub span_s: f64,
    /// What is told counts at the start as so many observations of a variance; 0.1 to 1000.
    pub prior: f64,
    /// Least noise of the accelerometer \[m/s^2/sqrt(Hz)\]. Default EuRoC's data sheet.
    pub accel_floor: AccelNoiseDensity,
    /// Least noise of the gyroscope \[rad/s/sqrt(Hz)\]. Default EuRoC's data sheet.
    pub gyro_floor: GyroNoiseDensity,
    /// Least walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\]. Default EuRoC's data sheet.
    pub accel_walk_floor: AccelBiasWalkDensity,
    /// Least walk of the gyroscope's bias \[rad/s^2/sqrt(Hz)\]. Default EuRoC's data sheet.
    pub gyro_walk_floor: GyroBiasWalkDensity,
    /// Whether the pixels' level is learned too.
    pub pixels: bool,
    /// Least deviation of a pixel \[px\] of tracks that are fed.
    pub pixel_floor: f64,
    /// The same where points are followed through images. What such a point is off lasts and is shared by its neighbours; residuals within a window show only
    /// a part of it.
    pub followed_pixel_floor: f64,
}

impl Default for ComponentsConfig {
    fn default() -> Self {
        Self {
            memory_s: 10.0,
            span_s: 1.5,
            prior: 2.0,
            accel_floor: AccelNoiseDensity::EUROC,
            gyro_floor: GyroNoiseDensity::EUROC,
            accel_walk_floor: AccelBiasWalkDensity::EUROC,
            gyro_walk_floor: GyroBiasWalkDensity::EUROC,
            pixels: true,
            pixel_floor: 0.5,
            followed_pixel_floor: 0.7,
        }
    }
}

impl ComponentsConfig {
    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        faults.within("components.memory_s", self.memory_s, 1.0, 1000.0);
        faults.within("components.span_s", self.span_s, 0.0, 10.0);
        faults.within("components.prior", self.prior, 0.1, 1000.0);
        // A floor above all that sensors have would be a constant under another name.
        for (key, value) in [
            ("components.accel_floor", self.accel_floor.get()),
            ("components.gyro_floor", self.gyro_floor.get()),
            ("components.accel_walk_floor", self.accel_walk_floor.get()),
            ("components.gyro_walk_floor", self.gyro_walk_floor.get()),
        ] {
            faults.within(key, value, 1e-9, 10.0);
        }
        faults.within("components.pixel_floor", self.pixel_floor, 0.01, 10.0);
        faults.within("components.followed_pixel_floor", self.followed_pixel_floor, 0.01, 10.0);
    }
}
