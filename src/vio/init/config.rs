//! What the initialisation is told: how good tracks are, how long it may look back, when it is sure enough.

use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::noise::{AccelNoiseDensity, GyroNoiseDensity};
use serde::{Deserialize, Serialize};

/// Settings of [`super::Initialiser`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InitConfig {
    /// Focal length that turns pixels into angles \[px\]; EuRoC's cam0: 458.
    pub focal_px: f64,
    /// Deviation of a track's position in u and in v \[px\] that is assumed before the tracks' own residuals are seen.
    pub track_std_px: f64,
    /// Frames in the estimate, the newest included; at least 4.
    pub max_frames: usize,
    /// Fewest frames with which an estimate is tried; at least 4.
    pub min_frames: usize,
    /// Shortest time that the frames must span \[s\].
    pub min_span_s: f64,
    /// Longest time that the frames may span \[s\]; older ones are dropped.
    pub max_span_s: f64,
    /// An estimate is tried at every n-th frame.
    pub try_every: usize,
    /// Tracks that two frames must share to be compared.
    pub min_shared_tracks: usize,
    /// Parallax after compensating rotation that some pair of frames must show, median over tracks \[px\].
    pub min_parallax_px: f64,
    /// Largest relative standard deviation of the scale with which the estimate is given out.
    pub max_scale_std: f64,
    /// Prior standard deviation of each axis of the accelerometer's bias, here and where the window begins \[m/s^2\].
    pub accel_bias_std: f64,
    /// Prior standard deviation of each axis of the gyro's bias, here where no rest was seen and where the window begins \[rad/s\].
    pub gyro_bias_std: f64,
    /// Least white noise of the accelerometer that is believed, whatever is told \[m/s^2/sqrt(Hz)\]: rotors shake it more than its data
    /// sheet says.
    pub min_accel_noise: AccelNoiseDensity,
    /// Least white noise of the gyro that is believed \[rad/s/sqrt(Hz)\].
    pub min_gyro_noise: GyroNoiseDensity,
    /// How many redundant measurements the belief in the noise that is told counts against what the residuals say of it.
    pub noise_prior_weight: f64,
    /// Longest move of the median track that still counts as rest, against the rest's first frame \[px\].
    pub rest_track_px: f64,
    /// Shortest rest that is believed \[s\].
    pub min_rest_s: f64,
}

impl Default for InitConfig {
    fn default() -> Self {
        Self {
            focal_px: 460.0,
            track_std_px: 1.0,
            max_frames: 11,
            min_frames: 6,
            min_span_s: 1.0,
            max_span_s: 4.0,
            try_every: 2,
            min_shared_tracks: 20,
            min_parallax_px: 10.0,
            max_scale_std: 0.04,
            accel_bias_std: 0.15,
            gyro_bias_std: 0.1,
            // Rotors: .35 m/s^2 and .016 rad/s per sample at 200 Hz.
            min_accel_noise: AccelNoiseDensity::new(0.025).unwrap_or(AccelNoiseDensity::EUROC),
            min_gyro_noise: GyroNoiseDensity::new(1.1e-3).unwrap_or(GyroNoiseDensity::EUROC),
            noise_prior_weight: 6.0,
            rest_track_px: 1.5,
            min_rest_s: 0.5,
        }
    }
}

impl InitConfig {
    /// Angle of `px` pixels near the principal point \[rad\].
    pub(super) fn angle(&self, px: f64) -> f64 {
        px / self.focal_px
    }

    /// By how much an image may move that counts as rest \[rad\].
    pub(crate) fn rest_angle(&self) -> f64 {
        self.angle(self.rest_track_px)
    }
}

impl Validate for InitConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.positive("focal_px", self.focal_px);
        faults.positive("track_std_px", self.track_std_px);
        faults.positive("min_span_s", self.min_span_s);
        faults.positive("max_scale_std", self.max_scale_std);
        faults.positive("accel_bias_std", self.accel_bias_std);
        faults.positive("gyro_bias_std", self.gyro_bias_std);
        faults.positive("noise_prior_weight", self.noise_prior_weight);
        faults.positive("rest_track_px", self.rest_track_px);
        faults.positive("min_rest_s", self.min_rest_s);
        faults.not_negative("min_parallax_px", self.min_parallax_px);
        let (span, frames) = (self.max_span_s, self.max_frames);
        let longer = span.is_finite() && span > self.min_span_s;
        faults.check(longer, "max_span_s", span, "above min_span_s, and finite");
        faults.check(self.min_frames >= 4, "min_frames", self.min_frames, "at least 4");
        let fits = (self.min_frames..=60).contains(&frames);
        faults.check(fits, "max_frames", frames, "from min_frames to 60");
        faults.check(self.try_every > 0, "try_every", self.try_every, "at least 1");
        let shared = self.min_shared_tracks;
        faults.check(shared >= 8, "min_shared_tracks", shared, "at least 8");
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_have_no_fault() {
        assert!(InitConfig::default().faults().is_empty());
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let bad = InitConfig {
            focal_px: 0.0,
            track_std_px: f64::NAN,
            min_frames: 2,
            max_span_s: 0.1,
            try_every: 0,
            ..InitConfig::default()
        };
        let keys: Vec<_> = bad.faults().into_iter().map(|f| f.key).collect();
        assert_eq!(keys, ["focal_px", "track_std_px", "max_span_s", "min_frames", "try_every"]);
    }
}
