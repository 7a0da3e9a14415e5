//! How a frame goes out: the oldest into the prior, or the second newest, which said nothing new, without trace.

use super::config::Handover;
use super::landmark::{Landmark, MIN_INVERSE_DEPTH};
use super::window::Window;
use crate::factors::inertial::inertial_residual;
use nalgebra::{Isometry3, Point3, Vector3};

/// Which frame leaves a full window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leaving {
    /// The oldest: the second newest is a key frame.
    Oldest,
    /// The second newest: it saw what its neighbours saw.
    SecondNewest,
}

impl Window {
    /// Which frame has to go: the second newest stays where it moved enough against the key frame before it, or lost its tracks.
    pub(crate) fn leaving(&self, focal_px: f64) -> Leaving {
        let n = self.frames.len();
        if n < 3 {
            return Leaving::Oldest;
        }
        // The first and the last frame of a rest say all there is to say of it. Without its first nothing would tie the last to
        // where the body came to stand but the samples between them, integrated for as long as the rest lasts.
        if let Some(rest) = self.frames[n - 2].rest {
            let first = self.frames[n - 3].t < rest.from;
            return if self.frames[n - 1].rest.is_some() && !first {
                Leaving::SecondNewest
            } else {
                Leaving::Oldest
            };
        }
        let parallax = self.parallax(n - 3, n - 2);
        let moved = parallax.mean * focal_px >= self.config.key_frame_parallax_px;
        let seen = self.landmarks.iter().filter(|l| l.seen_by(n - 2)).count();
        let renewed = (parallax.common as f64) < self.config.key_frame_min_share * seen as f64;
        if moved || renewed || parallax.common < self.config.key_frame_min_tracks {
            Leaving::Oldest
        } else {
            Leaving::SecondNewest
        }
    }

    /// Whether the newest frame did not see a landmark.
    fn has_ended(&self, landmark: &Landmark) -> bool {
        landmark.last_frame() + 1 < self.frames.len()
    }

    /// The part of sighting `k` of a landmark's information with which it enters the prior when the `leaving` oldest frames leave.
    ///
    /// Of `m` sightings of which `g` go, `g/(m - 1)` are handed over: as much as when the frames left one after the other, each time `1/(m - 1)` of
    /// what there was.
    pub(super) fn handed_part(&self, landmark: &Landmark, k: usize, leaving: usize) -> f64 {
        let rows = (landmark.sightings.len().max(2) - 1) as f64;
        let going = landmark.sightings_before(leaving);
        let left = landmark.sightings[k].1.left;
        match self.config.handover {
            Handover::Split if k < going || self.has_ended(landmark) => left,
            // The last one keeps half of that: it is the next host, and one of which nothing is left holds no landmark.
            Handover::Split => left * (1.0 - (rows - going as f64).max(0.5) / rows),
            Handover::Reuse | Handover::Consume => 1.0,
        }
    }

    /// Lets a frame go. Of the oldest, returns the inertial residual of the interval that leaves with it: the sum of squares in
    /// standard deviations over position, rotation and velocity (9 degrees of freedom).
    pub fn slide(&mut self, leaving: Leaving) -> Option<f64> {
        match leaving {
            Leaving::Oldest => {
                let whitened = self.oldest_inertial_residual();
                self.slide_oldest(1);
                whitened
            }
            Leaving::SecondNewest => {
                self.slide_second_newest();
                None
            }
        }
    }

    /// Lets the `leaving` oldest frames go at once, into one prior; nothing changes where that is none.
    pub(crate) fn slide_oldest(&mut self, leaving: usize) {
        if leaving == 0 {
            return;
        }
        let prior = self.prior_without_oldest(leaving);
        let newest = self.frames.len() - 1;
        let last_cameras: Vec<_> =
            self.frames.iter().map(|f| f.state.world_from_body * self.body_from_cam).collect();
        let handover = self.config.handover;
        let mut landmarks = std::mem::take(&mut self.landmarks);
        landmarks.retain_mut(|landmark| {
            if landmark.host() >= leaving {
                return true;
            }
            let point = landmark.point(&last_cameras[landmark.host()]);
            let used = landmark.handed_over(leaving);
            if handover == Handover::Split {
                for k in 0..used {
                    landmark.sightings[k].1.left -= self.handed_part(landmark, k, leaving);
                }
            }
            let going = landmark.sightings_before(leaving);
            // What is in the prior must not be counted again, what has lost its host's frame cannot stay.
            let gone = match (handover, used) {
                (_, 0) | (Handover::Reuse, _) => going,
                (Handover::Split, _) if landmark.last_frame() == newest => going,
                // The newest goes on, as the anchor of what comes.
                (Handover::Consume, all) if landmark.last_frame() == newest => all - 1,
                (_, used) => used,
            };
            landmark.sightings.drain(..gone);
            // A depth that was not told, or a point behind a camera, is found anew.
            landmark.inverse_depth = None;
            let Some((host, _)) = landmark.sightings.first() else { return false };
            landmark.inverse_depth = point.and_then(|p| inverse_depth(&last_cameras[*host], p));
            true
        });
        self.landmarks = landmarks;
        self.prior = Some(prior);
        self.frames.drain(..leaving);
        self.factor_is_posterior = false;
        self.frames[0].preint = None;
        for landmark in &mut self.landmarks {
            for (frame, _) in &mut landmark.sightings {
                *frame -= leaving;
            }
        }
        let last = self.frames.len() - 1;
        self.retain_landmarks(|l| l.sightings.len() > 1 || l.last_frame() == last);
    }

    fn slide_second_newest(&mut self) {
        let gone = self.frames.len() - 2;
        let body_from_cam = self.body_from_cam;
        let camera = |frame: usize| self.frames[frame].state.world_from_body * body_from_cam;
        let (gone_camera, next_camera) = (camera(gone), camera(gone + 1));
        if let Some(prior) = self.prior.take() {
            self.prior = Some(if prior.layout.frames > gone { prior.without(gone) } else { prior });
        }
        for landmark in &mut self.landmarks {
            let Some(k) = landmark.sightings.iter().position(|(f, _)| *f == gone) else { continue };
            if k == 0 {
                let point = landmark.point(&gone_camera);
                landmark.inverse_depth = point.and_then(|p| inverse_depth(&next_camera, p));
            }
            landmark.sightings.remove(k);
        }
        let frame = self.frames.remove(gone);
        self.factor_is_posterior = false;
        if let (Some(mut earlier), Some(later)) = (frame.preint, self.frames[gone].preint.take()) {
            earlier.append(&later);
            self.frames[gone].preint = Some(earlier);
        }
        for landmark in &mut self.landmarks {
            for (f, _) in &mut landmark.sightings {
                if *f > gone {
                    *f -= 1;
                }
            }
        }
        self.retain_landmarks(|l| !l.sightings.is_empty());
    }

    fn oldest_inertial_residual(&self) -> Option<f64> {
        let preint = self.frames.get(1)?.preint.as_ref()?;
        let residual = inertial_residual(preint, &self.frames[0].state, &self.frames[1].state);
        let covariance = preint.covariance().fixed_view::<9, 9>(0, 0).into_owned();
        let head = residual.fixed_rows::<9>(0).into_owned();
        covariance.cholesky().map(|c| head.dot(&c.solve(&head)))
    }

    /// Takes out sightings that do not agree with their landmark, and ends the tracks that made them. Returns how many.
    pub(crate) fn reject_outliers(&mut self) -> usize {
        let limit = self.config.outlier_px / self.config.pixel_std;
        let mut ended = Vec::new();
        let mut landmarks = std::mem::take(&mut self.landmarks);
        landmarks.retain_mut(|landmark| {
            let Some(inverse_depth) = landmark.inverse_depth else { return true };
            if !inverse_depth.is_finite() {
                landmark.inverse_depth = None;
                return true;
            }
            let seen_by_host = self.sighting_at_offset(landmark.host_sighting());
            let host = landmark.host();
            let before = landmark.sightings.len();
            let mut first = true;
            landmark.sightings.retain(|(frame, seen)| {
                if std::mem::take(&mut first) {
                    return true;
                }
                let seen = self.sighting_at_offset(seen);
                self.geometry(host, *frame).residual(&seen_by_host, &seen, inverse_depth).norm() <= limit
            });
            if landmark.sightings.len() < before {
                ended.push(landmark.id);
                return landmark.sightings.len() > 1;
            }
            true
        });
        self.landmarks = landmarks;
        self.retain_landmarks(|_| true);
        self.ended.extend(&ended);
        ended.len()
    }
}

/// The inverse depth of a point of the world in front of a camera.
fn inverse_depth(world_from_cam: &Isometry3<f64>, point: Vector3<f64>) -> Option<f64> {
    let z = (world_from_cam.inverse() * Point3::from(point)).z;
    (z > 0.0).then(|| (1.0 / z).max(MIN_INVERSE_DEPTH))
}
