//! The prior of what leaves: the oldest frame, its inertial interval and its landmarks, by Schur complement.
//!
//! The equations of all measurements that would be lost are set up at the present states; depths, then the frame's fifteen unknowns
//! are taken out; the rest is the new prior. On a linear problem no estimate changes by that.

use super::layout::Layout;
use super::linearisation::Linearisation;
use super::part::Part;
use super::prior::Prior;
use super::window::Window;

impl Window {
    /// The prior that stands for the oldest frame once it has left, in places of the frames that stay.
    pub(crate) fn prior_without_oldest(&mut self) -> Prior {
        let layout = self.layout();
        let mut at: Linearisation = std::mem::take(&mut self.scratch);
        at.compute(self, &layout, Part::Oldest, 0.0);
        let places: Vec<usize> = layout.frame_places(0).collect();
        let system = at.normal.without(&places);
        self.scratch = at;
        let frames = &self.frames[1..];
        Prior {
            layout: Layout { frames: frames.len(), ..layout },
            system,
            at: frames.iter().map(|f| f.state).collect(),
            at_camera: self.body_from_cam,
            at_offset: self.time_offset,
        }
    }
}
