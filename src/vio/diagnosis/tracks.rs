//! Whether ids stay with their points.

use dpn_core::TrackFrame;
use dpn_core::signal::stats::upper_median;
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use serde::Serialize;

/// A track that ends farther than this from where the others' motion carries it has another point than before \[px\].
const JUMP_PX: f64 = 60.0;
/// Share of a frame's tracks by which their common motion is told: those that fit it best.
const FITTED: f64 = 0.7;
/// Fewer have no motion but their median's.
const FEWEST_FITTED: usize = 6;
/// Frames farther apart than this are not compared \[s\].
const LONGEST_STEP_S: f64 = 0.3;
/// With a lower share of tracks going on, ids do not stay with points.
const LEAST_CONTINUING: f64 = 0.1;
/// With a larger share of jumps, neither.
const MOST_JUMPS: f64 = 0.2;
/// Jumps worth a word.
const SOME_JUMPS: f64 = 0.02;

/// What tracks are like from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrackHealth {
    /// Frames.
    pub frames: usize,
    /// Mean number of tracks in a frame.
    pub mean_tracks: f64,
    /// Mean share of a frame's tracks that were in the frame before; 0 where no two frames can be compared.
    pub continuing: f64,
    /// Share of these that ended more than 60 px from where the others' affine motion carries them.
    pub jumps: f64,
    /// Longest time between two frames \[s\].
    pub longest_gap_s: f64,
}

impl TrackHealth {
    /// What makes these tracks useless; `None` where nothing does.
    pub fn fault(&self) -> Option<String> {
        if self.frames > 1 && self.mean_tracks > 1.0 && self.continuing < LEAST_CONTINUING {
            return Some(format!(
                "only {:.1} % of a frame's tracks have an id of the frame before; an id must stay with its point from frame to frame",
                100.0 * self.continuing
            ));
        }
        (self.jumps > MOST_JUMPS).then(|| {
            format!(
                "{:.0} % of the tracks jump by more than {JUMP_PX} px beyond the others from one frame to the next: an id must stay with its point, and never be given to another",
                100.0 * self.jumps
            )
        })
    }

    /// What is worth a word; `None` where nothing is.
    pub fn warning(&self) -> Option<String> {
        (self.jumps > SOME_JUMPS).then(|| {
            format!(
                "{:.1} % of the tracks jump by more than {JUMP_PX} px beyond the others from one frame to the next; are ids used again?",
                100.0 * self.jumps
            )
        })
    }
}

/// Looks at tracks as they come: memory does not grow with them.
#[derive(Debug, Clone, Default)]
pub struct TrackMeter {
    frames: usize,
    tracks: usize,
    pairs: usize,
    shares: f64,
    common: usize,
    jumps: usize,
    longest_gap_s: f64,
}

impl TrackMeter {
    /// Takes a frame.
    pub fn frame(&mut self, frame: &TrackFrame) {
        self.frames += 1;
        self.tracks += frame.tracks.len();
    }

    /// Takes the step to a frame from the one before, and what both see, as [`TrackFrame::shared`] gives it.
    pub fn pair(&mut self, before: &TrackFrame, frame: &TrackFrame, shared: &[(Vector2<f64>, Vector2<f64>)]) {
        let seconds = frame.t.seconds_since(before.t);
        self.longest_gap_s = self.longest_gap_s.max(seconds);
        if seconds > LONGEST_STEP_S || before.tracks.is_empty() || frame.tracks.is_empty() {
            return;
        }
        self.pairs += 1;
        self.shares += shared.len() as f64 / frame.tracks.len() as f64;
        self.common += shared.len();
        self.jumps += beyond_the_others(shared).iter().filter(|px| **px > JUMP_PX).count();
    }

    /// What the tracks so far are like.
    pub fn health(&self) -> TrackHealth {
        TrackHealth {
            frames: self.frames,
            mean_tracks: self.tracks as f64 / self.frames.max(1) as f64,
            continuing: self.shares / self.pairs.max(1) as f64,
            jumps: self.jumps as f64 / self.common.max(1) as f64,
            longest_gap_s: self.longest_gap_s,
        }
    }
}

/// How far each track ends from where the others carry it \[px\]: an affine motion, for a camera that rolls moves its corners against each other.
fn beyond_the_others(shared: &[(Vector2<f64>, Vector2<f64>)]) -> Vec<f64> {
    let moves: Vec<_> = shared.iter().map(|(before, px)| px - before).collect();
    let middle = median(&moves);
    let mut off: Vec<f64> = moves.iter().map(|m| (m - middle).norm()).collect();
    let fitted = (FITTED * shared.len() as f64) as usize;
    for _ in 0..if fitted < FEWEST_FITTED { 0 } else { 3 } {
        let mut order: Vec<usize> = (0..shared.len()).collect();
        order.sort_by(|a, b| off[*a].total_cmp(&off[*b]));
        let (mut normal, mut right) = (Matrix3::zeros(), Matrix2x3::zeros());
        for (before, px) in order[..fitted].iter().map(|i| &shared[*i]) {
            let at = Vector3::new(before.x, before.y, 1.0);
            normal += at * at.transpose();
            right += px * at.transpose();
        }
        // Points on one line say nothing beyond their median.
        let Some(inverse) = normal.cholesky().map(|factor| factor.inverse()) else { break };
        let motion = right * inverse;
        off = shared.iter().map(|(p, px)| (px - motion * Vector3::new(p.x, p.y, 1.0)).norm()).collect();
    }
    off
}

/// The median of each coordinate.
fn median(moves: &[Vector2<f64>]) -> Vector2<f64> {
    let of = |k: usize| upper_median(moves.iter().map(|m| m[k])).unwrap_or(0.0);
    Vector2::new(of(0), of(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{Stamp, Track};

    fn track_health(frames: &[TrackFrame]) -> TrackHealth {
        let mut meter = TrackMeter::default();
        frames.iter().for_each(|frame| meter.frame(frame));
        frames.windows(2).for_each(|pair| meter.pair(&pair[0], &pair[1], &pair[1].shared(&pair[0])));
        meter.health()
    }

    /// 128 points that drift by 3 px a frame, their ids by `id`.
    fn frames(id: impl Fn(u64, u64) -> u64) -> Vec<TrackFrame> {
        let track = |frame: u64, point: u64| Track {
            id: id(frame, point),
            px: Vector2::new((37 * point % 700) as f64 + 3.0 * frame as f64, (53 * point % 450) as f64),
        };
        let frame = |f: u64| TrackFrame {
            readout_s: 0.0,
            clock_s: 0.0,
            t: Stamp::from_ns(100_000_000 * f as i64),
            tracks: (0..128).map(|p| track(f, p)).collect(),
        };
        (0..20).map(frame).collect()
    }

    #[test]
    fn ids_that_stay_are_sound() {
        let health = track_health(&frames(|_, p| p));
        assert_eq!((health.continuing, health.jumps), (1.0, 0.0));
        assert!((health.longest_gap_s - 0.1).abs() < 1e-9 && health.mean_tracks == 128.0);
        assert_eq!((health.fault(), health.warning()), (None, None));
    }

    #[test]
    fn ids_that_wander_or_are_always_new_are_faults_and_a_few_jumps_a_warning() {
        let wandering = track_health(&frames(|f, p| p ^ (37 * f % 128)));
        assert!(wandering.fault().unwrap().contains("jump by more than 60 px"), "{wandering:?}");
        let new = track_health(&frames(|f, p| 128 * f + p));
        assert!(new.fault().unwrap().starts_with("only 0.0 %"), "{new:?}");
        let few = track_health(&frames(|f, p| if p < 8 { p ^ (f % 8) } else { p }));
        assert!(few.fault().is_none() && few.warning().is_some(), "{few:?}");
    }

    #[test]
    fn a_camera_that_rolls_fast_reuses_no_id() {
        let centre = Vector2::new(350.0, 225.0);
        let mut rolling = frames(|_, p| p);
        for (i, frame) in rolling.iter_mut().enumerate() {
            let turn = nalgebra::Rotation2::new(0.4 * i as f64);
            frame.tracks.iter_mut().for_each(|track| track.px = centre + turn * (track.px - centre));
        }
        assert_eq!(track_health(&rolling).jumps, 0.0);
    }

    #[test]
    fn no_frames_have_no_fault() {
        assert_eq!(track_health(&[]).fault(), None);
        assert_eq!(track_health(&frames(|_, p| p)[..1]).fault(), None);
    }
}
