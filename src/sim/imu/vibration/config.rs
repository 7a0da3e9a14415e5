//! Settings of the vibration: how fast the rotors turn, how they wander, what reaches which axis.

use dpn_core::config::ConfigFaults;
use serde::{Deserialize, Serialize};

/// Highest frequency that the knots of the frame's motion carry with more than half of its amplitude \[Hz\].
const HIGHEST_HZ: f64 = 60.0;

/// Deviations one axis shows in a steady hover of a flight of level 1, in the sensor's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisVibration {
    /// Tones at once, twice and three times the rotors' speed, 0 to 100 each.
    pub harmonics: [f64; 3],
    /// Motion of the frame near [`VibrationConfig::low_line_hz`], 0 to 100.
    pub low_line: f64,
    /// Motion of the frame over a broad band, 0 to 100.
    pub broad_band: f64,
    /// Centre of the broad band \[Hz\], 1 to 60.
    pub broad_band_hz: f64,
}

impl AxisVibration {
    /// All tones of the rotors together.
    pub fn tones(&self) -> f64 {
        self.harmonics.iter().map(|v| v * v).sum::<f64>().sqrt()
    }
}

/// Vibration of a multirotor's frame, fitted to EuRoC's in-flight spectra.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VibrationConfig {
    /// Scales all vibration, 0 to 100; 0 switches it off. Default 1.
    pub scale: f64,
    /// Number of rotors, 1 to 16. Default 6 (EuRoC's Firefly).
    pub rotors: u32,
    /// Turns a second of a rotor in hover \[Hz\], 10 to 400; it grows with the square root of thrust. Default 91.5.
    pub hover_hz: f64,
    /// Speed when idling on the ground, relative to hover, .05 to 1. Default .4.
    pub idle_speed: f64,
    /// Time the motors take to start and to stop \[s\], .1 to 1.5. Default 1.
    pub spin_up_s: f64,
    /// Deviation of the rotors' fixed differences in speed, 0 to .3. Default .035.
    pub rotor_spread: f64,
    /// Deviation of a rotor's wandering speed, 0 to .3. Default .035.
    pub speed_wander: f64,
    /// Correlation time of that wander \[s\], .01 to 100. Default .25.
    pub speed_wander_s: f64,
    /// Deviation of the logarithm of amplitudes, for each rotor and once more for all, 0 to .3; the low line and the
    /// broad band come in bursts, with 4 and 2.5 times as much. Default .12.
    pub amplitude_wander: f64,
    /// Correlation time of amplitudes \[s\], .01 to 100, a quarter and an eighth of it in bursts. Default 2.
    pub amplitude_wander_s: f64,
    /// Mean frequency of the low line \[Hz\], 1 to 60. Default 27.
    pub low_line_hz: f64,
    /// Deviation of that frequency \[Hz\], 0 to 20. Default 2; its correlation time is .3 s.
    pub low_line_wander_hz: f64,
    /// Accelerometer x, y, z \[m/s^2\].
    pub accel: [AxisVibration; 3],
    /// Gyroscope x, y, z \[rad/s\].
    pub gyro: [AxisVibration; 3],
}

/// An axis that hears nothing.
pub(super) const SILENT: AxisVibration = axis([0.0; 3], 0.0, 0.0, 40.0);

/// Shorthand for the table of defaults.
const fn axis(harmonics: [f64; 3], low_line: f64, broad_band: f64, broad_band_hz: f64) -> AxisVibration {
    AxisVibration { harmonics, low_line, broad_band, broad_band_hz }
}

impl Default for VibrationConfig {
    fn default() -> Self {
        Self {
            scale: 1.0,
            rotors: 6,
            hover_hz: 91.5,
            idle_speed: 0.4,
            spin_up_s: 1.0,
            rotor_spread: 0.035,
            speed_wander: 0.035,
            speed_wander_s: 0.25,
            amplitude_wander: 0.12,
            amplitude_wander_s: 2.0,
            low_line_hz: 27.0,
            low_line_wander_hz: 2.0,
            // The sensor averages over 5 ms before it is read, which leaves little of twice the rotors' speed.
            accel: [
                axis([0.71, 0.12, 0.28], 0.16, 0.60, 17.0),
                axis([0.20, 0.08, 0.17], 0.31, 0.235, 20.0),
                axis([0.51, 0.10, 0.26], 0.115, 0.39, 17.0),
            ],
            gyro: [
                axis([0.0052, 0.0010, 0.0025], 0.0185, 0.0184, 9.0),
                axis([0.0300, 0.0030, 0.0060], 0.0065, 0.0400, 9.5),
                axis([0.0150, 0.0020, 0.0045], 0.0060, 0.0420, 7.5),
            ],
        }
    }
}

impl VibrationConfig {
    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        let mut within = |key: &str, value: f64, low: f64, high: f64| {
            faults.within(format!("vibration.{key}"), value, low, high);
        };
        within("scale", self.scale, 0.0, 100.0);
        within("rotors", f64::from(self.rotors), 1.0, 16.0);
        within("hover_hz", self.hover_hz, 10.0, 400.0);
        within("idle_speed", self.idle_speed, 0.05, 1.0);
        within("spin_up_s", self.spin_up_s, 0.1, 1.5);
        within("rotor_spread", self.rotor_spread, 0.0, 0.3);
        within("speed_wander", self.speed_wander, 0.0, 0.3);
        within("speed_wander_s", self.speed_wander_s, 0.01, 100.0);
        within("amplitude_wander", self.amplitude_wander, 0.0, 0.3);
        within("amplitude_wander_s", self.amplitude_wander_s, 0.01, 100.0);
        within("low_line_hz", self.low_line_hz, 1.0, HIGHEST_HZ);
        within("low_line_wander_hz", self.low_line_wander_hz, 0.0, 20.0);
        for (sensor, axes) in [("accel", &self.accel), ("gyro", &self.gyro)] {
            for (axis, name) in axes.iter().zip(["x", "y", "z"]) {
                for (i, &value) in axis.harmonics.iter().enumerate() {
                    within(&format!("{sensor}.{name}.harmonics[{i}]"), value, 0.0, 100.0);
                }
                within(&format!("{sensor}.{name}.low_line"), axis.low_line, 0.0, 100.0);
                within(&format!("{sensor}.{name}.broad_band"), axis.broad_band, 0.0, 100.0);
                within(&format!("{sensor}.{name}.broad_band_hz"), axis.broad_band_hz, 1.0, HIGHEST_HZ);
            }
        }
    }
}
