//! Settings of the vibration: how fast the rotors turn, how they wander, what reaches which axis.

/// Deviations one axis shows in a steady hover of a flight of level 1, in the sensor's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisVibration {
    /// Tones at once, twice and three times the rotors' speed.
    pub(super) harmonics: [f64; 3],
    /// Motion of the frame near [`LOW_LINE_HZ`].
    pub(super) low_line: f64,
    /// Motion of the frame over a broad band.
    pub(super) broad_band: f64,
    /// Centre of the broad band \[Hz\].
    pub(super) broad_band_hz: f64,
}

/// Speed when idling on the ground, relative to hover.
pub(super) const IDLE_SPEED: f64 = 0.4;
/// Time the motors take to start and to stop \[s\].
pub(super) const SPIN_UP_S: f64 = 1.0;
/// Correlation time of a rotor's wandering speed \[s\].
pub(super) const SPEED_WANDER_S: f64 = 0.25;
/// Correlation time of amplitudes \[s\], a quarter and an eighth of it in bursts.
pub(super) const AMPLITUDE_WANDER_S: f64 = 2.0;
/// Mean frequency of the low line \[Hz\].
pub(super) const LOW_LINE_HZ: f64 = 27.0;
/// Deviation of the same \[Hz\]; its correlation time is .3 s.
pub(super) const LOW_LINE_WANDER_HZ: f64 = 2.0;

dpn_core::settings!(
    /// Vibration of a multirotor's frame, fitted to EuRoC's in-flight spectra.
    pub struct VibrationConfig {
        /// Scales all vibration, 0 to 100; 0 switches it off. Default 1.
        pub scale: f64 = 1.0 => 0.0..=100.0,
        /// Number of rotors, 1 to 16. Default 6 (EuRoC's Firefly).
        pub rotors: u32 = 6 => 1..=16,
        /// Turns a second of a rotor in hover \[Hz\], 10 to 400; it grows with the square root of thrust. Default 91.5.
        pub hover_hz: f64 = 91.5 => 10.0..=400.0,
        /// Deviation of the rotors' fixed differences in speed, 0 to .3. Default .035.
        pub rotor_spread: f64 = 0.035 => 0.0..=0.3,
        /// Deviation of a rotor's wandering speed, 0 to .3. Default .035.
        pub speed_wander: f64 = 0.035 => 0.0..=0.3,
        /// Deviation of the logarithm of amplitudes, for each rotor and once more for all, 0 to .3; the low line and the
        /// broad band come in bursts, with 4 and 2.5 times as much. Default .12.
        pub amplitude_wander: f64 = 0.12 => 0.0..=0.3,
    }
);

/// An axis that hears nothing.
pub(super) const SILENT: AxisVibration = axis([0.0; 3], 0.0, 0.0, 40.0);

/// Shorthand for the table of defaults.
const fn axis(harmonics: [f64; 3], low_line: f64, broad_band: f64, broad_band_hz: f64) -> AxisVibration {
    AxisVibration { harmonics, low_line, broad_band, broad_band_hz }
}

/// What each axis hears: accelerometer x, y, z \[m/s^2\], gyroscope x, y, z \[rad/s\]. The sensor averages over 5 ms before it is read, which leaves little
/// of twice the rotors' speed.
pub(super) const AXES: [AxisVibration; 6] = [
    axis([0.71, 0.12, 0.28], 0.16, 0.60, 17.0),
    axis([0.20, 0.08, 0.17], 0.31, 0.235, 20.0),
    axis([0.51, 0.10, 0.26], 0.115, 0.39, 17.0),
    axis([0.0052, 0.0010, 0.0025], 0.0185, 0.0184, 9.0),
    axis([0.0300, 0.0030, 0.0060], 0.0065, 0.0400, 9.5),
    axis([0.0150, 0.0020, 0.0045], 0.0060, 0.0420, 7.5),
];
