//! What is kept of a run's frames: a line each, and what is judged of all of them, worked out while they come. Tracks themselves, some kilobytes a frame, go.

use super::recording::Recording;
use dpn_core::camera::CameraModel;
use dpn_core::signal::stats::upper_median;
use dpn_core::{ImuSample, Stamp, TrackFrame};
use dpn_vio::diagnosis::{Axes, AxesMeter, TrackHealth, TrackMeter};
use dpn_vio::estimator::without_spikes;
use std::borrow::Cow;

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
pub(super) struct FrameLog<'a> {
    samples: Cow<'a, [ImuSample]>,
    camera: CameraModel,
    before: Option<TrackFrame>,
    seen: Vec<SeenFrame>,
    tracks: TrackMeter,
    axes: AxesMeter,
}

impl<'a> FrameLog<'a> {
    /// Of a run over `recording`.
    pub(super) fn new(recording: &'a Recording) -> Self {
        Self {
            samples: without_spikes(recording.imu.samples()),
            camera: recording.camera,
            before: None,
            seen: Vec::new(),
            tracks: TrackMeter::default(),
            axes: AxesMeter::default(),
        }
    }

    /// Takes the next frame.
    pub(super) fn feed(&mut self, frame: &TrackFrame) {
        let mut way_px = None;
        self.tracks.frame(frame);
        if let Some(before) = &self.before {
            let shared = frame.shared(before);
            self.tracks.pair(before, frame, &shared);
            self.axes.pair(&self.samples, (before, frame), &shared, &self.camera);
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

    /// The frames, and how camera and gyro turn together.
    pub(super) fn finish(self, recording: &Recording) -> (Vec<SeenFrame>, Axes) {
        (self.seen, self.axes.axes(&recording.body_from_cam))
    }
}

#[cfg(test)]
mod tests {
    use super::super::recording::Recording;
    use super::*;
    use dpn_core::{ImuRecording, Track};
    use dpn_sim::tracks::CameraSettings;
    use dpn_train::split::Side;
    use nalgebra::{Isometry3, Vector2};

    #[test]
    fn the_way_is_the_median_of_shared_tracks() {
        let at = |s: i64| Stamp::from_ns(s * 1_000_000_000);
        let sample = |s| ImuSample { t: at(s), gyro: [0.0; 3], accel: [0.0, 0.0, 9.81] };
        let recording = Recording {
            name: "x".into(),
            side: Side::Test,
            imu: ImuRecording::new(vec![sample(0), sample(9)]).unwrap(),
            camera: CameraSettings::default().model().unwrap(),
            body_from_cam: Isometry3::identity(),
            truth: None,
            oracle: None,
            remarks: Vec::new(),
        };
        let frame = |t: i64, tracks: &[(u64, f64)]| TrackFrame {
            t: at(t),
            tracks: tracks.iter().map(|(id, x)| Track { id: *id, px: Vector2::new(*x, 7.0) }).collect(),
        };
        let mut log = FrameLog::new(&recording);
        log.feed(&frame(5, &[(1, 0.0), (2, 0.0), (3, 0.0)]));
        log.feed(&frame(6, &[(1, 1.0), (2, 2.0), (3, 30.0), (4, 9.0)]));
        log.feed(&frame(7, &[(9, 0.0)]));
        let ways: Vec<_> = log.seen().iter().map(|seen| (seen.tracks, seen.way_px)).collect();
        assert_eq!(ways, [(3, None), (4, Some(2.0)), (1, None)]);
        assert_eq!(log.health().frames, 3);
    }
}
