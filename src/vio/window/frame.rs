//! What a window holds of an image, and where all of it stands at present.

use crate::factors::reprojection::{PairGeometry, Sighting};
use crate::preint::Preintegration;
use crate::state::NavState;
use dpn_core::Stamp;
use nalgebra::{Isometry3, Vector3};

/// One image's instant.
#[derive(Debug, Clone)]
pub struct Frame {
    /// When it was taken.
    pub t: Stamp,
    /// What is believed of the body then.
    pub state: NavState,
    /// The IMU's samples since the frame before; `None` for the first of all.
    pub preint: Option<Preintegration>,
    /// The rest that it belongs to; `None` where something moved, or may have.
    pub rest: Option<Standstill>,
    /// What the body's turning added to the camera's velocity then, in the body frame \[m/s\].
    pub lever: Vector3<f64>,
}

impl Frame {
    /// Of the camera's centre, in the world \[m/s\].
    fn camera_velocity(&self) -> Vector3<f64> {
        self.state.vel_in_world + self.state.world_from_body.rotation * self.lever
    }

    /// What landmarks that this frame hosts and their sightings in `target` share.
    pub(super) fn seen_with(&self, target: &Self, body_from_cam: &Isometry3<f64>) -> PairGeometry {
        let pose = |frame: &Self| frame.state.world_from_body;
        PairGeometry::new(&pose(self), &pose(target), body_from_cam)
            .moving(&self.camera_velocity(), &target.camera_velocity())
    }
}

/// A rest, as one of its frames sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill {
    /// Its first frame's stamp.
    pub from: Stamp,
    /// By how much the image may have moved since \[rad\].
    pub angle: f64,
}

/// A frame's tracks as the window takes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The track's number.
    pub id: u64,
    /// What was measured.
    pub sighting: Sighting,
}

/// The present estimates of a window's states.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Estimates<'a> {
    pub(crate) frames: &'a [Frame],
    pub(crate) body_from_cam: &'a Isometry3<f64>,
    /// Of the camera's clock \[s\].
    pub(crate) time_offset: f64,
}
