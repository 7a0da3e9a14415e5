//! How fast tracks move, from one frame to the next: what a camera clock's offset multiplies.

use crate::window::Seen;
use dpn_core::Stamp;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Rays of the last frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct RayRates {
    last: Option<Stamp>,
    /// Looked up, never walked.
    rays: HashMap<u64, Vector3<f64>>,
}

impl RayRates {
    /// Fills in each track's rate where the last frame saw it too, and remembers this frame.
    pub(crate) fn add(&mut self, t: Stamp, seen: &mut [Seen]) {
        if let Some(seconds) = self.last.map(|last| t.seconds_since(last)).filter(|s| *s > 0.0) {
            for Seen { id, sighting } in seen.iter_mut() {
                if let Some(before) = self.rays.get(id) {
                    sighting.ray_rate = (sighting.ray - before) / seconds;
                }
            }
        }
        self.last = Some(t);
        self.rays.clear();
        self.rays.extend(seen.iter().map(|s| (s.id, s.sighting.ray)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factors::reprojection::Sighting;
    use dpn_core::camera::CameraModel;
    use nalgebra::Vector2;

    #[test]
    fn a_track_seen_twice_has_a_rate_and_a_new_one_none() {
        let camera = CameraModel::euroc_cam0();
        let seen = |id, u| {
            let sighting = Sighting::new(&camera, &Vector2::new(u, 240.0), 0.5).unwrap();
            Seen { id, sighting }
        };
        let mut rates = RayRates::default();
        rates.add(Stamp::from_ns(0), &mut [seen(1, 360.0)]);
        let mut second = [seen(1, 370.0), seen(2, 100.0)];
        rates.add(Stamp::from_ns(100_000_000), &mut second);
        let moved = seen(1, 370.0).sighting.ray - seen(1, 360.0).sighting.ray;
        assert!((second[0].sighting.ray_rate - moved / 0.1).norm() < 1e-12);
        assert_eq!(second[1].sighting.ray_rate, Vector3::zeros());
    }
}
