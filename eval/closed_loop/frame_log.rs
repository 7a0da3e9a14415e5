//! What is kept of a run's frames: a line each, and what is judged of all of them, worked out while they come. Tracks themselves, some kilobytes a frame, go.

use dpn_core::signal::stats::upper_median;
use dpn_core::{Stamp, TrackFrame};
use dpn_vio::diagnosis::{TrackHealth, TrackMeter};

/// A frame that was run, without its tracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenFrame {
    /// When.
    pub t: Stamp,
    /// How many tracks it had.
    pub tracks: usize,
    /// Median way of those that the frame before had too \[px\]; none where there are none.
    pub way_px: Option<f64>,
}

/// Takes frames as they come.
#[derive(Default)]
pub(super) struct FrameLog {
    before: Option<TrackFrame>,
    seen: Vec<SeenFrame>,
    tracks: TrackMeter,
}

impl FrameLog {
    /// Takes the next frame.
    pub(super) fn feed(&mut self, frame: &TrackFrame) {
        let mut way_px = None;
        self.tracks.frame(frame);
        if let Some(before) = &self.before {
            let shared = frame.shared(before);
            self.tracks.pair(before, frame, &shared);
            way_px = upper_median(shared.iter().map(|(before, px)| (px - before).norm()));
        }
        self.seen.push(SeenFrame { t: frame.t, tracks: frame.tracks.len(), way_px });
        self.before = Some(frame.clone());
    }

    /// The frames so far.
    pub(super) fn seen(&self) -> &[SeenFrame] {
        &self.seen
    }

    /// What the tracks are like.
    pub(super) fn health(&self) -> TrackHealth {
        self.tracks.health()
    }

    /// The frames.
    pub(super) fn finish(self) -> Vec<SeenFrame> {
        self.seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Track;
    use nalgebra::Vector2;

    #[test]
    fn the_way_is_the_median_of_shared_tracks() {
        let at = |s: i64| Stamp::from_ns(s * 1_000_000_000);
        let frame = |t: i64, tracks: &[(u64, f64)]| TrackFrame {
            readout_s: 0.0,
            clock_s: 0.0,
            t: at(t),
            tracks: tracks.iter().map(|(id, x)| Track { id: *id, px: Vector2::new(*x, 7.0) }).collect(),
        };
        let mut log = FrameLog::default();
        log.feed(&frame(5, &[(1, 0.0), (2, 0.0), (3, 0.0)]));
        log.feed(&frame(6, &[(1, 1.0), (2, 2.0), (3, 30.0), (4, 9.0)]));
        log.feed(&frame(7, &[(9, 0.0)]));
        let ways: Vec<_> = log.seen().iter().map(|seen| (seen.tracks, seen.way_px)).collect();
        assert_eq!(ways, [(3, None), (4, Some(2.0)), (1, None)]);
        assert_eq!(log.health().frames, 3);
    }
}
