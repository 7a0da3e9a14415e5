//! What came in while there is no state, to be worked off again once the camera's clock is found to be off.

use super::imu_buffer::ImuBuffer;
use crate::clock::REACH_S;
use crate::preint::NoisySample;
use dpn_core::{Stamp, TrackFrame};
use std::collections::VecDeque;

/// Frames are kept so long \[s\].
const KEPT_S: f64 = 6.0;

/// Frames of the last seconds, and the samples about them.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    frames: VecDeque<TrackFrame>,
    samples: VecDeque<NoisySample>,
}

impl History {
    /// Takes a sample.
    pub(super) fn sample(&mut self, sample: NoisySample) {
        self.samples.push_back(sample);
    }

    /// Takes a frame that was worked off without coming to a state, at `t` on the IMU's clock.
    pub(super) fn frame(&mut self, frame: TrackFrame, t: Stamp) {
        while self.frames.front().is_some_and(|first| frame.t.seconds_since(first.t) > KEPT_S) {
            self.frames.pop_front();
        }
        self.frames.push_back(frame);
        self.forget_before(t.plus_seconds(-KEPT_S));
    }

    /// There is a state at `t`: the frames before are in it.
    pub(super) fn running(&mut self, t: Stamp) {
        self.frames.clear();
        self.forget_before(t);
    }

    /// The frames, and all samples since.
    pub(super) fn take(&mut self) -> (VecDeque<TrackFrame>, ImuBuffer) {
        let mut imu = ImuBuffer::default();
        self.samples.iter().for_each(|sample| imu.push(*sample));
        (std::mem::take(&mut self.frames), imu)
    }

    fn forget_before(&mut self, t: Stamp) {
        let first = t.plus_seconds(-2.0 * REACH_S);
        while self.samples.get(1).is_some_and(|second| second.sample.t <= first) {
            self.samples.pop_front();
        }
    }
}
