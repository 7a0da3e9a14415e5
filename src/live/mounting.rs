//! Whether the camera turns with the gyro as its calibration says, asked in the first seconds of motion of a run that has no end yet.

use dpn_vio::clock::ClockWatch;
use dpn_vio::diagnosis::AxesVerdict;

/// Pairs of frames between two looks: 5 s at 10 Hz.
const EVERY: usize = 50;
/// Pairs of the last look, and of the only one whose other verdicts are believed: parallax turns a camera by some degrees for a while.
const LAST: usize = 600;

/// Looks at the turns of camera and gyro while a run goes on, until they say something.
#[derive(Default)]
pub(crate) struct MountingWatch {
    asked: usize,
    done: bool,
}

impl MountingWatch {
    /// What is wrong, said once, as soon as it is known.
    pub(crate) fn warning(&mut self, turns: &ClockWatch) -> Option<String> {
        if self.done || turns.compared_pairs() < self.asked + EVERY {
            return None;
        }
        self.asked = turns.compared_pairs();
        let axes = turns.axes();
        let last = self.asked >= LAST;
        self.done = last || matches!(axes.verdict, AxesVerdict::Swapped | AxesVerdict::Consistent);
        axes.warning().filter(|_| self.done)
    }

    /// What all of a run that is over says, where nothing was known before.
    pub(crate) fn last_warning(&mut self, turns: &ClockWatch) -> Option<String> {
        let asked_before = std::mem::replace(&mut self.done, true);
        if asked_before { None } else { turns.axes().warning() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::TrackFrame;
    use dpn_core::camera::CameraModel;
    use dpn_io::asl::{Sequence, discover};
    use dpn_io::read_tracks;
    use dpn_testing::packs;

    /// What is said of a recording, and when \[s\].
    fn said(sequence: &Sequence, frames: &[TrackFrame], swapped: bool) -> Option<(f64, String)> {
        let (imu, config) = (sequence.imu().unwrap(), sequence.camera_config().unwrap().unwrap());
        let mounting = config.body_from_cam;
        let mounting = if swapped { mounting.inverse() } else { mounting };
        let camera = CameraModel::try_from(&config).unwrap();
        let (mut turns, mut watch) =
            (ClockWatch::new(camera, mounting.rotation, None), MountingWatch::default());
        let mut samples = imu.samples().iter().peekable();
        let mut all = Vec::new();
        for frame in frames {
            while let Some(sample) = samples.next_if(|sample| sample.t <= frame.t) {
                turns.feed_imu(sample);
            }
            turns.feed_frame(frame);
            let warning = watch.warning(&turns);
            all.extend(warning.map(|said| (frame.t.seconds_since(frames[0].t), said)));
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
