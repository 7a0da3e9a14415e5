//! What the initialisation is told: how good tracks are, how long it may look back, when it is sure enough.

use dpn_core::config::{ConfigFault, Limit, Validate};

/// Deviation of a track's position in u and in v \[px\] that is assumed before the tracks' own residuals are seen.
pub(super) const TRACK_STD_PX: f64 = 1.0;
/// Shortest time that the frames must span \[s\].
pub(super) const MIN_SPAN_S: f64 = 1.0;
/// An estimate is tried at every n-th frame.
pub(super) const TRY_EVERY: u64 = 2;
/// Tracks that two frames must share to be compared.
pub(super) const MIN_SHARED_TRACKS: usize = 20;
/// Parallax after compensating rotation that some pair of frames must show, median over tracks \[px\]. With 5 px 97 % of 146 starts in flight are given out within 1.5 s of
/// motion, with 8 px 92 %; but the first pose then errs twice as much as its covariance says.
pub(super) const MIN_PARALLAX_PX: f64 = 8.0;
/// Least white noise of the accelerometer that is believed, whatever is told \[m/s^2/sqrt(Hz)\]: rotors shake it more than its data
/// sheet says.
pub(super) const MIN_ACCEL_NOISE: f64 = 0.025;
/// Least white noise of the gyro that is believed \[rad/s/sqrt(Hz)\].
pub(super) const MIN_GYRO_NOISE: f64 = 1.1e-3;
/// How many redundant measurements the belief in the noise that is told counts against what the residuals say of it.
pub(super) const NOISE_PRIOR_WEIGHT: f64 = 6.0;
/// Longest move of the median track that still counts as rest, against the rest's first frame \[px\].
pub(super) const REST_TRACK_PX: f64 = 1.5;
/// Shortest rest that is believed \[s\].
pub(super) const MIN_REST_S: f64 = 0.5;

dpn_core::settings!(
    /// Settings of [`super::Initialiser`].
    pub struct InitConfig {
        /// Focal length that turns pixels into angles \[px\]; EuRoC's cam0: 458.
        pub focal_px: f64 = 460.0 => Limit::Positive,
        /// Frames in the estimate, the newest included; at least 4.
        pub max_frames: usize = 11,
        /// Fewest frames with which an estimate is tried; at least 4.
        pub min_frames: usize = 6,
        /// Longest time that the frames may span \[s\]; older ones are dropped.
        pub max_span_s: f64 = 4.0,
        /// Largest relative standard deviation of the scale with which the estimate is given out.
        pub max_scale_std: f64 = 0.3 => Limit::Positive,
        /// Prior standard deviation of each axis of the accelerometer's bias, here and where the window begins \[m/s^2\].
        pub accel_bias_std: f64 = 0.15 => Limit::Positive,
        /// Prior standard deviation of each axis of the gyro's bias, here where no rest was seen and where the window begins \[rad/s\].
        pub gyro_bias_std: f64 = 0.1 => Limit::Positive,
    }
);

impl InitConfig {
    /// Angle of `px` pixels near the principal point \[rad\].
    pub(super) fn angle(&self, px: f64) -> f64 {
        px / self.focal_px
    }

    /// By how much an image may move that counts as rest \[rad\].
    pub(crate) fn rest_angle(&self) -> f64 {
        self.angle(REST_TRACK_PX)
    }
}

impl Validate for InitConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        let (span, frames) = (self.max_span_s, self.max_frames);
        let longer = span.is_finite() && span > MIN_SPAN_S;
        faults.check(longer, "max_span_s", span, format!("above {MIN_SPAN_S}, and finite"));
        faults.check(self.min_frames >= 4, "min_frames", self.min_frames, "at least 4");
        let fits = (self.min_frames..=60).contains(&frames);
        faults.check(fits, "max_frames", frames, "from min_frames to 60");
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
            accel_bias_std: f64::NAN,
            min_frames: 2,
            max_span_s: 0.1,
            ..InitConfig::default()
        };
        let keys: Vec<_> = bad.faults().into_iter().map(|f| f.key).collect();
        assert_eq!(keys, ["focal_px", "accel_bias_std", "max_span_s", "min_frames"]);
    }
}
