//! Where a flight goes, as far as its surroundings need to know: what is free, and where the body stood.

use crate::tracks::{Bounds, CameraPath};
use nalgebra::{Isometry3, Vector3};

/// Places are taken this often \[s\], less often on paths of more than [`MOST`] of them.
const STEP_S: f64 = 0.2;

/// Most places of a piece of the path.
const MOST: f64 = 4000.0;

/// A body that moves less than this \[m\] within [`REST_S`] stands on something.
const REST_M: f64 = 0.01;

/// Shortest rest \[s\].
const REST_S: f64 = 1.0;

/// Rests nearer to each other than this are on the same thing \[m\].
const SAME_M: f64 = 0.6;

/// A place where the body stood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    /// Where.
    pub(super) place: Vector3<f64>,
    /// Where the camera looked, seen from above: a unit vector.
    pub(super) ahead: Vector3<f64>,
}

/// A flight's surroundings.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    /// Its box.
    pub(crate) bounds: Bounds,
    /// Where the body was.
    places: Vec<Vector3<f64>>,
    /// Where it stood.
    pub(super) rests: Vec<Rest>,
}

impl Course {
    /// Of a path.
    pub(crate) fn of(path: &dyn CameraPath, body_from_cam: &Isometry3<f64>) -> Self {
        let mut course = Self { bounds: path.bounds(), places: Vec::new(), rests: Vec::new() };
        for (first, last) in path.pieces() {
            let length_s = last.seconds_since(first);
            let count = (length_s / STEP_S).clamp(1.0, MOST) as usize;
            let step_s = length_s / count as f64;
            let at = |i: usize| path.world_from_body(first.plus_seconds(i as f64 * step_s));
            let poses: Vec<_> = (0..=count).filter_map(at).collect();
            course.places.extend(poses.iter().map(|pose| pose.translation.vector));
            course.add_rests(&poses, step_s, body_from_cam);
        }
        course
    }

    /// Of a flight that goes everywhere in a box, and rests nowhere.
    #[cfg(test)]
    pub(crate) fn within(bounds: &Bounds) -> Self {
        const STEP_M: f64 = 0.3;
        let size = bounds.high - bounds.low;
        let [across, along] = [size.x, size.y].map(|side| (side / STEP_M).ceil() as usize);
        let places = (0..=across).flat_map(|i| {
            (0..=along).map(move |j| {
                let step = Vector3::new(i as f64 / across as f64, j as f64 / along as f64, 0.0);
                bounds.low + size.component_mul(&step)
            })
        });
        Self { bounds: *bounds, places: places.collect(), rests: Vec::new() }
    }

    fn add_rests(&mut self, poses: &[Isometry3<f64>], step_s: f64, body_from_cam: &Isometry3<f64>) {
        let least = (REST_S / step_s).ceil().max(1.0) as usize;
        for window in poses.windows(least + 1) {
            let place = window[0].translation.vector;
            let stays = |pose: &Isometry3<f64>| (pose.translation.vector - place).norm() < REST_M;
            let known = self.rests.iter().any(|rest| (rest.place - place).norm() < SAME_M);
            if known || !window.iter().all(stays) {
                continue;
            }
            let sight = window[0].rotation * (body_from_cam.rotation * Vector3::z());
            let ahead = Vector3::new(sight.x, sight.y, 0.0).try_normalize(0.1).unwrap_or(Vector3::x());
            self.rests.push(Rest { place, ahead });
        }
    }

    /// The lowest height of the body within `reach` of `place`, seen from above \[m\]; none where it never was.
    pub(super) fn lowest(&self, place: &Vector3<f64>, reach: f64) -> Option<f64> {
        let near = self.places.iter().filter(|at| (*at - place).xy().norm() < reach);
        near.map(|at| at.z).min_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;

    /// Stands, rises by a metre a second from 5 to 6 s, and stays in the air on wavering wings.
    struct TakeOff;

    impl CameraPath for TakeOff {
        fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
            let t = t.seconds_since(Stamp::from_ns(0));
            let waver = if t > 6.0 { 0.1 * (3.0 * t).sin() } else { 0.0 };
            Some(Isometry3::translation(1.0 + waver, 2.0, 0.5 + (t - 5.0).clamp(0.0, 1.0)))
        }

        fn pieces(&self) -> Vec<(Stamp, Stamp)> {
            vec![(Stamp::from_ns(0), Stamp::from_ns(20_000_000_000))]
        }

        fn bounds(&self) -> Bounds {
            Bounds { low: Vector3::new(0.9, 2.0, 0.5), high: Vector3::new(1.1, 2.0, 1.5) }
        }
    }

    #[test]
    fn a_body_rests_where_it_stands_and_not_where_it_hovers() {
        // The camera looks along the body's x.
        let body_from_cam = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
        let course = Course::of(&TakeOff, &body_from_cam);
        assert_eq!(course.rests.len(), 1, "{:?}", course.rests);
        assert!((course.rests[0].place - Vector3::new(1.0, 2.0, 0.5)).norm() < 1e-12);
        assert!((course.rests[0].ahead - Vector3::x()).norm() < 1e-12);
        assert_eq!(course.lowest(&Vector3::new(1.5, 2.0, 9.0), 0.6), Some(0.5));
        assert_eq!(course.lowest(&Vector3::new(3.0, 2.0, 0.5), 0.6), None);
    }
}
