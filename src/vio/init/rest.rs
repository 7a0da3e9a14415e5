//! Rest, as the tracks see it: nothing in the image moves against the first frame of the rest.
//!
//! The image decides, not the IMU: rotors that idle on the ground shake an accelerometer by 1 m/s^2 and the camera by nothing. A
//! bound on the mean rotation rate, the largest bias a gyro can have, keeps a camera that is blind (or looks at something that
//! moves along with it) from calling a turn rest.

use super::config::{InitConfig, MIN_REST_S, REST_TRACK_PX};
use super::frame::{InitFrame, shared};
use super::robust;
use dpn_core::time::Stamp;
use nalgebra::{Vector2, Vector3};

/// Tracks without which nothing is said.
const MIN_TRACKS: usize = 10;
/// With fewer tracks left of the frame that a rest is held against, the newest takes its place: tracks end while nothing moves.
const RENEWED_BELOW: usize = 2 * MIN_TRACKS;
/// A frame counts as at rest when frames this much later still are: it does not hold the first of the motion \[s\].
const SETTLED_S: f64 = 0.15;
/// Until the image shows that something moves a body may have moved for so long: at half a metre a second squared, ten metres before a wall, what
/// counts as rest is used up after .36 s \[s\].
const UNSEEN_S: f64 = 0.5;
/// Mean rotation rate that a gyro's bias can feign \[rad/s\].
const MAX_RATE: f64 = 0.15;

/// Bearings count whose cosine from the axis is above this: beside a fish-eye's edge a pixel is many times as much of the plane z = 1.
const NEAR_AXIS: f64 = 0.5;

/// Follows a sequence of frames and says until when they stood still.
#[derive(Debug, Clone, Default)]
pub(crate) struct RestWatch {
    /// The rest's first frame.
    from: Option<Stamp>,
    /// The frame that the others are held against, and by how much the image may have moved before it \[rad\].
    first: Option<(InitFrame, f64)>,
    /// The last frame that matched the first, and by how much the image may have moved by then \[rad\].
    last: Option<(Stamp, f64)>,
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
    /// By how much the image as a whole may have moved since its first frame \[rad\].
    pub moved: f64,
}

impl Rest {
    /// Of a rest that has ended: frames after this may have moved already, too little for the image.
    pub(crate) fn sure_until(&self) -> Stamp {
        self.from.plus_seconds((self.seconds - UNSEEN_S).max(0.0))
    }
}

impl RestWatch {
    /// Takes the next frame, `rate` being the gyro's mean size since the last \[rad/s\]; the rest that it is in or that it ends.
    pub(crate) fn push(&mut self, frame: &InitFrame, rate: f64, config: &InitConfig) -> Option<Rest> {
        let found = self.first.as_ref().and_then(|(first, before)| {
            let pairs = shared(first, frame);
            let still = rate <= MAX_RATE
                && pairs.len() >= MIN_TRACKS
                && robust::median(pairs.iter().map(|(a, b)| (a - b).norm())) <= config.angle(REST_TRACK_PX);
            let fades = pairs.len() < RENEWED_BELOW && frame.t.seconds_since(first.t) >= MIN_REST_S;
            still.then(|| (before.hypot(common_motion(&pairs)), fades))
        });
        let still = found.is_some();
        if let Some((moved, _)) = found {
            self.last = Some((frame.t, moved));
        }
        let rest = self.from.zip(self.last).map(|(from, (last, moved))| Rest {
            from,
            to: last.plus_seconds(-SETTLED_S).max(from),
            lasts: still,
            seconds: last.seconds_since(from),
            moved,
        });
        match found {
            Some((moved, true)) => self.first = Some((frame.clone(), moved)),
            Some(_) => {}
            None => {
                self.first = Some((frame.clone(), 0.0));
                self.from = Some(frame.t);
                self.last = None;
            }
        }
        rest.filter(|r| r.seconds >= MIN_REST_S)
    }
}

/// By how much an image has moved as a whole, by shift, roll or growth, and by how much it may have unseen: three deviations of what the
/// tracks' own errors make of that \[rad\].
///
/// Least squares for `b - a = shift + growth * a + roll * perp(a)` over the tracks but the wildest.
fn common_motion(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let flows = pairs.iter().filter(|(a, b)| a.z > NEAR_AXIS && b.z > NEAR_AXIS);
    let flows: Vec<(Vector2<f64>, Vector2<f64>)> =
        flows.map(|(a, b)| (a.xy() / a.z, b.xy() / b.z - a.xy() / a.z)).collect();
    let most = 3.0 * robust::median(flows.iter().map(|(_, flow)| flow.norm()));
    let kept: Vec<_> = flows.iter().filter(|(_, flow)| flow.norm() <= most).collect();
    let count = kept.len().max(1) as f64;
    let centre = kept.iter().map(|(at, _)| at).sum::<Vector2<f64>>() / count;
    let shift = kept.iter().map(|(_, flow)| flow).sum::<Vector2<f64>>() / count;
    let (mut growth, mut roll, mut squares) = (0.0, 0.0, 0.0);
    for (at, flow) in &kept {
        let (at, flow) = (at - centre, flow - shift);
        growth += at.dot(&flow);
        roll += at.perp(&flow);
        squares += at.norm_squared();
    }
    let spread = (squares / count).sqrt().max(1e-3);
    let (growth, roll) = (growth / squares.max(1e-9), roll / squares.max(1e-9));
    let own = most / 3.0 / count.sqrt() / spread;
    shift.norm().max(growth.abs()).max(roll.abs()) + 3.0 * own
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::Rotation3;
    use rand::Rng;

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
    fn tracks_that_end_while_nothing_moves_end_no_rest() {
        let config = InitConfig::default();
        let mut watch = RestWatch::default();
        let mut last = None;
        for k in 0..200u64 {
            // Every frame one of forty tracks ends and another begins.
            let bearings = (k..k + 40).map(|id| {
                let (u, v) = ((id % 40) as f64 * 0.02 - 0.4, (id % 7) as f64 * 0.08 - 0.25);
                (id, Vector3::new(u, v, 1.0).normalize())
            });
            let t = Stamp::from_ns(0).plus_seconds(0.1 * k as f64);
            last = watch.push(&InitFrame::new(t, bearings.collect()), 0.02, &config);
        }
        let rest = last.unwrap();
        assert!(rest.lasts && rest.from == Stamp::from_ns(0), "{rest:?}");
    }

    #[test]
    fn common_motion_is_what_the_tracks_share() {
        let mut rng = Stream::new(3).named("rest").rng();
        let mut noise = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
        let rays: Vec<Vector3<f64>> =
            (0..150).map(|_| (noise(0.5) + Vector3::new(0.0, 0.0, 1.0)).normalize()).collect();
        let mut after = |turn: &Rotation3<f64>, forward: f64, size: f64| -> f64 {
            let seen = rays.iter().map(|a| {
                let b = turn * (3.0 * a - Vector3::new(0.0, 0.0, forward)) + 3.0 * noise(size);
                (*a, b.normalize())
            });
            common_motion(&seen.collect::<Vec<_>>())
        };
        let turn = |axis: Vector3<f64>| Rotation3::new(axis * 2e-3);
        let still = after(&Rotation3::identity(), 0.0, 6e-4);
        assert!((5e-5..6e-4).contains(&still), "{still}");
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let turned = after(&turn(axis), 0.0, 6e-4);
            assert!((1.5e-3..3.5e-3).contains(&turned), "{axis:?}: {turned}");
        }
        let nearer = after(&Rotation3::identity(), 6e-3, 6e-4);
        assert!((1.3e-3..3.5e-3).contains(&nearer), "{nearer}");
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
