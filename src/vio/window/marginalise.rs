//! The prior of what leaves: the oldest frames, their inertial intervals and their landmarks, by Schur complement.
//!
//! The equations of all measurements that would be lost are set up at the present states; depths, then the frames' fifteen unknowns each
//! are taken out; the rest is the new prior. On a linear problem no estimate changes by that.

use super::layout::Layout;
use super::linearisation::Linearisation;
use super::part::Part;
use super::prior::Prior;
use super::window::Window;

impl Window {
    /// The prior that stands for the `leaving` oldest frames once they have left, in places of the frames that stay.
    pub(super) fn prior_without_oldest(&mut self, leaving: usize) -> Prior {
        let layout = self.layout();
        let mut at: Linearisation = std::mem::take(&mut self.scratch);
        at.compute(self, &layout, Part::Oldest(leaving), 0.0);
        let places: Vec<usize> = (0..leaving).flat_map(|frame| layout.frame_places(frame)).collect();
        let system = at.normal.without(&places);
        self.scratch = at;
        let frames = &self.frames[leaving..];
        Prior {
            layout: Layout { frames: frames.len(), ..layout },
            system,
            at: frames.iter().map(|f| f.state).collect(),
            at_camera: self.body_from_cam,
            at_offset: self.time_offset,
        }
    }
}
