//! Where the landmarks are: for whoever looks on.

use super::window::Window;
use nalgebra::{Point3, Vector3};

impl Window {
    /// Number and place of every landmark whose depth is known, in the world \[m\].
    pub fn points_in_world(&self) -> Vec<(u64, Point3<f64>)> {
        let point = |landmark: &super::Landmark| -> Option<(u64, Vector3<f64>)> {
            let host = self.frames.get(landmark.host())?;
            let world_from_cam = host.state.world_from_body * self.body_from_cam;
            Some((landmark.id, landmark.point(&world_from_cam)?))
        };
        self.landmarks.iter().filter_map(point).map(|(id, place)| (id, place.into())).collect()
    }
}
