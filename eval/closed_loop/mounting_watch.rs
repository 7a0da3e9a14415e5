//! Whether the camera turns with the gyro as its calibration says, asked in the first seconds of motion of a run that has no end yet.

use dpn_core::camera::CameraModel;
use dpn_core::{GrayImage, ImuSample, TrackFrame};
use dpn_vio::diagnosis::{AxesMeter, AxesVerdict};
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::Fed;
use nalgebra::Isometry3;
use std::collections::VecDeque;

/// Pairs of frames between two looks: 5 s at 10 Hz.
const EVERY: usize = 50;
/// Pairs of the last look, and of the only one whose other verdicts are believed: parallax turns a camera by some degrees for a while.
const LAST: usize = 600;

/// Compares the turns of camera and gyro while a run goes on, until they say something.
pub(super) struct MountingWatch {
    camera: CameraModel,
    body_from_cam: Isometry3<f64>,
    meter: AxesMeter,
    /// From the last before the frame `before` on.
    samples: Vec<ImuSample>,
    before: Option<TrackFrame>,
    /// Frames that no sample has passed yet.
    waiting: VecDeque<TrackFrame>,
    asked: usize,
    done: bool,
}

impl MountingWatch {
    /// Of a camera at `body_from_cam` on the IMU.
    pub(super) fn new(camera: CameraModel, body_from_cam: Isometry3<f64>) -> Self {
        Self {
            camera,
            body_from_cam,
            meter: AxesMeter::default(),
            samples: Vec::new(),
            before: None,
            waiting: VecDeque::new(),
            asked: 0,
            done: false,
        }
    }

    /// Takes the next sample.
    pub(super) fn sample(&mut self, sample: &ImuSample) {
        if self.done {
            return;
        }
        if self.before.is_none() && self.waiting.is_empty() {
            // No camera yet, which may last.
            self.samples.clear();
        }
        self.samples.push(*sample);
    }

    /// Takes the next frame's tracks.
    pub(super) fn frame(&mut self, frame: &TrackFrame) {
        if !self.done {
            self.waiting.push_back(frame.clone());
        }
    }

    /// What is wrong, said once, as soon as it is known.
    pub(super) fn warning(&mut self) -> Option<String> {
        self.compare();
        if self.done || self.meter.pairs() < self.asked + EVERY {
            return None;
        }
        self.asked = self.meter.pairs();
        let axes = self.meter.axes(&self.body_from_cam);
        let last = self.asked >= LAST;
        self.done = last || matches!(axes.verdict, AxesVerdict::Swapped | AxesVerdict::Consistent);
        if !self.done {
            return None;
        }
        (self.samples, self.before) = (Vec::new(), None);
        axes.warning()
    }

    /// What all of a run that is over says, where nothing was known before.
    pub(super) fn last_warning(&mut self) -> Option<String> {
        self.compare();
        let asked_before = std::mem::replace(&mut self.done, true);
        if asked_before { None } else { self.meter.axes(&self.body_from_cam).warning() }
    }

    /// Compares the turns up to the newest sample.
    fn compare(&mut self) {
        let Some(newest) = self.samples.last().map(|sample| sample.t) else { return };
        while let Some(frame) = self.waiting.pop_front_if(|frame| frame.t < newest) {
            if let Some(before) = &self.before {
                let shared = frame.shared(before);
                self.meter.pair(&self.samples, (before, &frame), &shared, &self.camera);
            }
            let past = self.samples.partition_point(|sample| sample.t < frame.t);
            self.samples.drain(..past.saturating_sub(1));
            self.before = Some(frame);
        }
    }
}

impl FrontEndObserver for MountingWatch {
    fn end(&mut self, _: &GrayImage, fed: &Fed) {
        if let Some(frame) = &fed.frame {
            self.frame(frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_io::asl::{Sequence, discover};
    use dpn_io::read_tracks;
    use dpn_testing::packs;

    /// What is said of a recording, and when \[s\].
    fn said(sequence: &Sequence, frames: &[TrackFrame], swapped: bool) -> Option<(f64, String)> {
        let (imu, config) = (sequence.imu().unwrap(), sequence.camera_config().unwrap().unwrap());
        let mounting = config.body_from_cam;
        let mounting = if swapped { mounting.inverse() } else { mounting };
        let mut watch = MountingWatch::new(CameraModel::try_from(&config).unwrap(), mounting);
        let mut samples = imu.samples().iter().peekable();
        let mut all = Vec::new();
        for frame in frames {
            // A frame may come before its samples.
            watch.frame(frame);
            while let Some(sample) = samples.next_if(|sample| sample.t <= frame.t.plus_seconds(-0.02)) {
                watch.sample(sample);
            }
            let warning = watch.warning();
            all.extend(warning.map(|said| (frame.t.seconds_since(frames[0].t), said)));
            assert!(frame.t == frames[0].t || watch.samples.len() < 60, "what was used is kept");
        }
        assert!(all.len() < 2, "{all:?}");
        all.pop()
    }

    #[test]
    fn swapped_extrinsics_are_named_within_seconds_of_motion_and_nothing_else_is() {
        let Some([euroc, tracks]) = packs(["euroc", "tracks"]) else { return };
        for sequence in discover(&euroc).unwrap() {
            let name = sequence.name();
            let frames = read_tracks(&tracks.join(format!("{name}.txt"))).unwrap();
            assert_eq!(said(&sequence, &frames, false), None, "{name}");
            let (after, warning) = said(&sequence, &frames, true).expect(name);
            assert!(warning.contains("extrinsics are swapped"), "{name}: {warning}");
            assert!(after < 21.0, "{name}: after {after} s");
        }
    }
}
