//! Where each unknown of the window stands in the normal equations.
//!
//! ```text
//! velocity and biases, newest frame first (9 each) | camera (6) | time offset (1) | poses, oldest frame first (6 each)
//! ```
//! A frame's velocity and biases meet only their neighbours' and two poses; taken first, and from the newest, they leave the factor
//! of the matrix a narrow envelope. The newest pose stands last: its covariance is then the last corner of the factor, inverted.

use crate::state::{POSE_DIM, STATE_DIM};

/// Unknowns of a frame beside its pose: velocity, accelerometer bias, gyro bias.
pub(crate) const MOTION_DIM: usize = STATE_DIM - POSE_DIM;

/// Places of a window's unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Frames in the window.
    pub frames: usize,
    /// Whether the camera's place on the body is estimated.
    pub extrinsics: bool,
    /// Whether the camera clock's offset is estimated.
    pub time_offset: bool,
}

impl Layout {
    /// All unknowns but the landmarks.
    pub fn dim(&self) -> usize {
        self.first_pose() + POSE_DIM * self.frames
    }

    /// Velocity, accelerometer bias and gyro bias of a frame.
    pub(crate) fn motion(&self, frame: usize) -> usize {
        MOTION_DIM * (self.frames - 1 - frame)
    }

    /// Position and rotation of a frame.
    pub fn pose(&self, frame: usize) -> usize {
        self.first_pose() + POSE_DIM * frame
    }

    /// The camera's position and rotation in the body frame, where estimated.
    pub(crate) fn camera(&self) -> Option<usize> {
        self.extrinsics.then_some(MOTION_DIM * self.frames)
    }

    /// The camera clock's offset, where estimated.
    pub(crate) fn offset(&self) -> Option<usize> {
        self.time_offset.then_some(MOTION_DIM * self.frames + self.camera_dim())
    }

    /// Place of a state's `index`-th unknown, in the order of [`crate::state`].
    pub fn state(&self, frame: usize, index: usize) -> usize {
        if index < POSE_DIM { self.pose(frame) + index } else { self.motion(frame) + index - POSE_DIM }
    }

    /// The places of a frame's fifteen unknowns, motion first.
    pub fn frame_places(&self, frame: usize) -> impl Iterator<Item = usize> + use<> {
        let (motion, pose) = (self.motion(frame), self.pose(frame));
        (motion..motion + MOTION_DIM).chain(pose..pose + POSE_DIM)
    }

    fn camera_dim(&self) -> usize {
        if self.extrinsics { POSE_DIM } else { 0 }
    }

    fn first_pose(&self) -> usize {
        MOTION_DIM * self.frames + self.camera_dim() + usize::from(self.time_offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_taken_once() {
        for (extrinsics, time_offset) in [(false, false), (true, false), (false, true), (true, true)] {
            let layout = Layout { frames: 4, extrinsics, time_offset };
            let mut places: Vec<usize> = (0..4).flat_map(|f| layout.frame_places(f)).collect();
            places.extend(layout.camera().into_iter().flat_map(|c| c..c + POSE_DIM));
            places.extend(layout.offset());
            places.sort_unstable();
            assert_eq!(places, (0..layout.dim()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_newest_pose_stands_last() {
        let layout = Layout { frames: 3, extrinsics: true, time_offset: true };
        assert_eq!(layout.pose(2) + POSE_DIM, layout.dim());
    }
}
