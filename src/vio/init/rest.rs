//! Rest, as the tracks see it: nothing in the image moves against the first frame of the rest.
//!
//! The image decides, not the IMU: rotors that idle on the ground shake an accelerometer by 1 m/s^2 and the camera by nothing. A
//! bound on the mean rotation rate, the largest bias a gyro can have, keeps a camera that is blind (or looks at something that
//! moves along with it) from calling a turn rest.

use super::config::InitConfig;
use super::frame::{InitFrame, shared};
use super::robust;
use dpn_core::time::Stamp;

/// Tracks without which nothing is said.
const MIN_TRACKS: usize = 10;
/// A frame counts as at rest when frames this much later still are: it does not hold the first of the motion \[s\].
const SETTLED_S: f64 = 0.15;
/// Mean rotation rate that a gyro's bias can feign \[rad/s\].
const MAX_RATE: f64 = 0.15;

/// Follows a sequence of frames and says until when they stood still.
#[derive(Debug, Clone, Default)]
pub(crate) struct RestWatch {
    first: Option<InitFrame>,
    last: Option<Stamp>,
}

/// A rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    /// Its first frame.
    pub from: Stamp,
    /// The last frame that surely belongs to it.
    pub to: Stamp,
    /// Whether the newest frame is part of it.
    pub lasts: bool,
    /// From its first frame to the newest that matches \[s\].
    pub seconds: f64,
}

impl RestWatch {
    /// Takes the next frame, `rate` being the gyro's mean size since the last \[rad/s\]; the rest that it is in or that it ends.
    pub(crate) fn push(&mut self, frame: &InitFrame, rate: f64, config: &InitConfig) -> Option<Rest> {
        let still = self.first.as_ref().is_some_and(|first| {
            let mut moves: Vec<f64> = shared(first, frame).iter().map(|(a, b)| (a - b).norm()).collect();
            rate <= MAX_RATE
                && moves.len() >= MIN_TRACKS
                && robust::median(&mut moves) <= config.angle(config.rest_track_px)
        });
        if still {
            self.last = Some(frame.t);
        }
        let rest = self.first.as_ref().zip(self.last).map(|(first, last)| Rest {
            from: first.t,
            to: last.plus_seconds(-SETTLED_S).max(first.t),
            lasts: still,
            seconds: last.seconds_since(first.t),
        });
        if !still {
            self.first = Some(frame.clone());
            self.last = None;
        }
        rest.filter(|r| r.seconds >= config.min_rest_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Forty tracks, moved in the image by `px`, at `t` seconds.
    fn frame(t: f64, px: f64) -> InitFrame {
        let bearings = (0..40u64).map(|id| {
            let (u, v) = (id as f64 * 0.02 - 0.4, (id % 7) as f64 * 0.08 - 0.25);
            (id, Vector3::new(u + px / 460.0, v, 1.0).normalize())
        });
        InitFrame::new(Stamp::from_ns(0).plus_seconds(t), bearings.collect())
    }

    #[test]
    fn a_rest_is_seen_once_it_is_long_enough_and_ends_before_the_motion() {
        let config = InitConfig::default();
        let mut watch = RestWatch::default();
        for k in 0..5 {
            assert_eq!(watch.push(&frame(0.1 * f64::from(k), 0.3), 0.02, &config), None);
        }
        for k in 5..10 {
            let rest = watch.push(&frame(0.1 * f64::from(k), 0.3), 0.02, &config).unwrap();
            assert!(rest.lasts && (rest.seconds - 0.1 * f64::from(k)).abs() < 1e-9);
        }
        let ended = watch.push(&frame(1.0, 9.0), 0.02, &config).unwrap();
        assert!(!ended.lasts);
        assert!((ended.to.seconds_since(Stamp::from_ns(0)) - 0.75).abs() < 1e-9);
        assert_eq!(watch.push(&frame(1.1, 20.0), 0.02, &config), None);
    }

    #[test]
    fn a_slow_move_and_a_blind_turn_are_no_rest() {
        let config = InitConfig::default();
        let (mut slow, mut blind) = (RestWatch::default(), RestWatch::default());
        for k in 0..40 {
            let t = 0.1 * f64::from(k);
            assert_eq!(slow.push(&frame(t, 5.0 * t), 0.02, &config), None);
            assert_eq!(blind.push(&frame(t, 0.0), 0.4, &config), None);
        }
    }
}
