//! One tracked point in the window: who saw it, and how deep it is on the first ray.

use crate::factors::reprojection::{PairGeometry, Sighting};
use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

/// Points farther than this are all alike \[1/m\]. A bound, because the other side of infinity fits a motion the wrong way round.
pub(crate) const MIN_INVERSE_DEPTH: f64 = 1e-3;

/// A landmark and the frames that saw it.
#[derive(Debug, Clone)]
pub struct Landmark {
    /// The track's number.
    pub id: u64,
    /// Frame of the window and measurement, frames rising; the first one is the host.
    pub sightings: Vec<(usize, Sighting)>,
    /// Inverse depth on the host's ray, along its z \[1/m\]; `None` until it can be told.
    pub inverse_depth: Option<f64>,
}

impl Landmark {
    /// Seen for the first time.
    pub(crate) fn new(id: u64, frame: usize, sighting: Sighting) -> Self {
        Self { id, sightings: vec![(frame, sighting)], inverse_depth: None }
    }

    /// The frame that anchors it.
    pub(crate) fn host(&self) -> usize {
        self.sightings[0].0
    }

    /// The measurement that anchors it.
    pub(crate) fn host_sighting(&self) -> &Sighting {
        &self.sightings[0].1
    }

    /// The frame that saw it last.
    pub(crate) fn last_frame(&self) -> usize {
        self.sightings[self.sightings.len() - 1].0
    }

    /// How many of its sightings are of the window's first `frames`.
    pub(super) fn sightings_before(&self, frames: usize) -> usize {
        self.sightings.partition_point(|(frame, _)| *frame < frames)
    }

    /// How many of its sightings enter the prior when the window's `leaving` oldest frames leave: all where its host leaves and its depth is known.
    pub(crate) fn handed_over(&self, leaving: usize) -> usize {
        let sightings = self.sightings.len();
        let goes = self.host() < leaving && self.inverse_depth.is_some() && sightings > 1;
        if goes { sightings } else { 0 }
    }

    /// Whether `frame` saw it.
    pub(crate) fn seen_by(&self, frame: usize) -> bool {
        self.sightings.iter().any(|(f, _)| *f == frame)
    }

    /// The point where it is, in the frame that `world_from_cam` of the host maps to.
    pub(crate) fn point(&self, world_from_host_cam: &Isometry3<f64>) -> Option<Vector3<f64>> {
        let inverse_depth = self.inverse_depth?;
        (inverse_depth > 0.0).then(|| {
            (world_from_host_cam * nalgebra::Point3::from(self.host_sighting().ray / inverse_depth)).coords
        })
    }

    /// Inverse depth from the rays of all sightings, linear: the smallest singular direction of the rays' normals.
    ///
    /// `None` where the rays are too parallel to say (below `min_angle` \[rad\] between the host's and every other) or meet behind a camera.
    pub(crate) fn triangulate(&self, world_from_cam: &[Isometry3<f64>], min_angle: f64) -> Option<f64> {
        let host = &world_from_cam[self.host()];
        // Normal equations of "the point lies on every ray", in the host's camera; the centre of the host's rays is its origin.
        let mut a = Matrix3::zeros();
        let mut b = Vector3::zeros();
        let mut widest: f64 = 0.0;
        let host_bearing = self.host_sighting().bearing;
        for (frame, sighting) in &self.sightings {
            let host_from_cam = host.inverse() * world_from_cam[*frame];
            let direction = host_from_cam.rotation * sighting.bearing;
            let off_ray = Matrix3::identity() - direction * direction.transpose();
            a += off_ray;
            b += off_ray * host_from_cam.translation.vector;
            widest = widest.max(direction.cross(&host_bearing).norm());
        }
        if widest < min_angle {
            return None;
        }
        let eigen = SymmetricEigen::new(a);
        if eigen.eigenvalues.min() < 1e-12 {
            return None;
        }
        let point = a.try_inverse()? * b;
        let in_front = self.sightings.iter().all(|(frame, sighting)| {
            let cam_from_host = world_from_cam[*frame].inverse() * host;
            (cam_from_host * nalgebra::Point3::from(point)).coords.dot(&sighting.bearing) > 0.0
        });
        (in_front && point.z > 0.0).then(|| (1.0 / point.z).max(MIN_INVERSE_DEPTH))
    }

    /// Root mean square of its residuals but the host's own \[standard deviations, one axis\].
    pub(crate) fn rms(&self, geometry: impl Fn(usize, usize) -> PairGeometry) -> Option<f64> {
        let inverse_depth = self.inverse_depth?;
        let others = &self.sightings[1..];
        let sum: f64 = others
            .iter()
            .map(|(frame, seen)| {
                geometry(self.host(), *frame)
                    .residual(self.host_sighting(), seen, inverse_depth)
                    .norm_squared()
            })
            .sum();
        (!others.is_empty()).then(|| (sum / (2.0 * others.len() as f64)).sqrt())
    }
}
