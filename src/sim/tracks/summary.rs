//! What tracks are like, as figures: how many, how long they live.

use dpn_core::TrackFrame;
use std::collections::BTreeMap;

/// Figures of a recording's tracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackSummary {
    /// Frames.
    pub frames: usize,
    /// Tracks in all.
    pub tracks: usize,
    /// Mean number of tracks in a frame.
    pub mean_in_frame: f64,
    /// Smallest number of tracks in a frame.
    pub least_in_frame: usize,
    /// Mean number of frames a track is in.
    pub mean_life: f64,
    /// Median of the same.
    pub median_life: usize,
}

/// Counts; all zero without a frame or a track.
pub fn summarise(frames: &[TrackFrame]) -> TrackSummary {
    let mut lives: BTreeMap<u64, usize> = BTreeMap::new();
    for track in frames.iter().flat_map(|frame| &frame.tracks) {
        *lives.entry(track.id).or_default() += 1;
    }
    let seen: usize = lives.values().sum();
    let mut sorted: Vec<usize> = lives.values().copied().collect();
    sorted.sort_unstable();
    let share = |of: usize| if of == 0 { 0.0 } else { seen as f64 / of as f64 };
    TrackSummary {
        frames: frames.len(),
        tracks: lives.len(),
        mean_in_frame: share(frames.len()),
        least_in_frame: frames.iter().map(|frame| frame.tracks.len()).min().unwrap_or(0),
        mean_life: share(lives.len()),
        median_life: sorted.get(sorted.len() / 2).copied().unwrap_or(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{Stamp, Track};
    use nalgebra::Vector2;

    #[test]
    fn counts_are_those_of_a_small_case() {
        let frame = |t, ids: &[u64]| TrackFrame {
            readout_s: 0.0,
            clock_s: 0.0,
            t: Stamp::from_ns(t),
            tracks: ids.iter().map(|&id| Track { id, px: Vector2::zeros() }).collect(),
        };
        let frames = [frame(0, &[1, 2]), frame(1, &[2, 3, 4]), frame(2, &[2]), frame(3, &[])];
        let expected = TrackSummary {
            frames: 4,
            tracks: 4,
            mean_in_frame: 1.5,
            least_in_frame: 0,
            mean_life: 1.5,
            median_life: 1,
        };
        assert_eq!(summarise(&frames), expected);
        assert_eq!(summarise(&[]).mean_life, 0.0);
    }
}
