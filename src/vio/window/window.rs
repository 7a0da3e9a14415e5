//! The window's contents, and how a frame comes in.

use super::config::WindowConfig;
use super::frame::{Estimates, Frame, Seen, Standstill};
use super::landmark::Landmark;
use super::layout::Layout;
use super::linearisation::Linearisation;
use super::normal::{Factor, Normal};
use super::prior::Prior;
use crate::factors::reprojection::{PairGeometry, Sighting};
use crate::factors::rest;
use crate::preint::Preintegration;
use crate::state::NavState;
use dpn_core::Stamp;
use dpn_core::signal::stats::upper_median;
use nalgebra::{Isometry3, Vector3};
use std::collections::{HashMap, HashSet};

/// The sliding window.
#[derive(Debug, Clone)]
pub struct Window {
    pub(crate) config: WindowConfig,
    /// Whether points are followed through images, here or before: the loss turns where theirs does, and pixels have their floor.
    pub(crate) followed: bool,
    pub(crate) frames: Vec<Frame>,
    pub(crate) landmarks: Vec<Landmark>,
    /// Track number to place in `landmarks`; looked up, never walked.
    pub(crate) places: HashMap<u64, usize>,
    /// Tracks found wrong, for as long as the tracker goes on with them.
    pub(crate) ended: HashSet<u64>,
    pub(crate) body_from_cam: Isometry3<f64>,
    pub(crate) time_offset: f64,
    pub(crate) prior: Option<Prior>,
    pub(crate) scratch: Linearisation,
    pub(crate) factor: Factor,
    /// Whether `factor` is of undamped equations of the present frames: its inverse is then their covariance.
    pub(crate) factor_is_posterior: bool,
}

impl Window {
    /// Empty.
    pub fn new(config: WindowConfig, body_from_cam: Isometry3<f64>) -> Self {
        Self {
            config,
            followed: false,
            frames: Vec::new(),
            landmarks: Vec::new(),
            places: HashMap::new(),
            ended: HashSet::new(),
            body_from_cam,
            time_offset: 0.0,
            prior: None,
            scratch: Linearisation::default(),
            factor: Factor::default(),
            factor_is_posterior: false,
        }
    }

    /// The loss of a sighting `squared` variances from its landmark, and its weight.
    pub(crate) fn loss(&self, squared: f64) -> (f64, f64) {
        let config = &self.config;
        let turn = if self.followed { config.followed_loss_px / config.pixel_std } else { config.loss_scale };
        config.loss.evaluate(squared, turn)
    }

    /// The frames, oldest first.
    pub(crate) fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The newest frame.
    pub(crate) fn newest(&self) -> Option<&Frame> {
        self.frames.last()
    }

    /// The landmarks, in the order in which they came.
    pub(crate) fn landmarks(&self) -> &[Landmark] {
        &self.landmarks
    }

    /// The camera's place on the body.
    pub fn body_from_cam(&self) -> &Isometry3<f64> {
        &self.body_from_cam
    }

    /// Where the unknowns stand.
    pub(crate) fn layout(&self) -> Layout {
        Layout {
            frames: self.frames.len(),
            extrinsics: self.config.estimate_extrinsics,
            time_offset: self.config.estimate_time_offset,
        }
    }

    /// Where its states stand.
    pub(crate) fn estimates(&self) -> Estimates<'_> {
        let Self { frames, body_from_cam, time_offset, .. } = self;
        Estimates { frames, body_from_cam, time_offset: *time_offset }
    }

    /// Takes over from a window whose frames are the last of this one's: where its states stand, what it rests on, which tracks it found wrong. The
    /// frames before go along with the first of them as one body: where they stand among themselves is as good as it was.
    pub(crate) fn take_estimates(&mut self, other: &Self) {
        let first = self.frames.len() - other.frames.len();
        let moved =
            other.frames[0].state.world_from_body * self.frames[first].state.world_from_body.inverse();
        for NavState { world_from_body, vel_in_world, .. } in
            self.frames[..first].iter_mut().map(|frame| &mut frame.state)
        {
            *world_from_body = moved * *world_from_body;
            *vel_in_world = moved.rotation * *vel_in_world;
        }
        for (frame, known) in self.frames[first..].iter_mut().zip(&other.frames) {
            (frame.state, frame.rest) = (known.state, known.rest);
        }
        self.body_from_cam = other.body_from_cam;
        self.time_offset = other.time_offset;
        self.ended.clone_from(&other.ended);
        self.factor_is_posterior = false;
    }

    /// A copy without the solver's memory, which is most of a window and nothing that lasts.
    pub(crate) fn copy(&mut self) -> Self {
        let (scratch, factor) = (std::mem::take(&mut self.scratch), std::mem::take(&mut self.factor));
        let copy = Self { factor_is_posterior: false, ..self.clone() };
        (self.scratch, self.factor) = (scratch, factor);
        copy
    }

    /// A prior that says nothing yet of the first frames; what it will say is about the states `at`, one a frame.
    pub(crate) fn prior_about(&self, at: Vec<NavState>) -> Prior {
        let layout = Layout { frames: at.len(), ..self.layout() };
        let system = Normal::zeros(layout.dim());
        Prior { layout, system, at, at_camera: self.body_from_cam, at_offset: self.time_offset }
    }

    /// Whether another frame makes it slide.
    pub(crate) fn is_full(&self) -> bool {
        self.frames.len() > self.config.key_frames
    }

    /// Puts a frame at the end and returns how many of its tracks go on from earlier frames.
    ///
    /// `preint` holds the samples since the frame before; `state` is where the solver starts.
    pub(crate) fn add_frame(
        &mut self,
        t: Stamp,
        state: NavState,
        preint: Option<Preintegration>,
        seen: &[Seen],
    ) -> usize {
        let frame = self.frames.len();
        self.factor_is_posterior = false;
        let lever = preint.as_ref().map_or_else(Vector3::zeros, |preint| {
            let rate = preint.samples().last().map_or_else(Vector3::zeros, |s| Vector3::from(s.sample.gyro));
            (rate - state.bias.gyro).cross(&self.body_from_cam.translation.vector)
        });
        self.frames.push(Frame { t, state, preint, rest: None, lever });
        let mut known = 0;
        let mut still_wrong = HashSet::new();
        for Seen { id, sighting } in seen {
            if self.ended.contains(id) {
                still_wrong.insert(*id);
                continue;
            }
            match self.places.get(id) {
                Some(&place) => {
                    self.landmarks[place].sightings.push((frame, *sighting));
                    known += 1;
                }
                None => {
                    self.places.insert(*id, self.landmarks.len());
                    self.landmarks.push(Landmark::new(*id, frame, *sighting));
                }
            }
        }
        self.ended = still_wrong;
        known
    }

    /// Says that nothing has moved until the newest frame since the rest's first.
    ///
    /// A rest is known only once it has lasted: frames that came meanwhile have stood still too, and left as if they might have moved they
    /// would carry the little velocity that was guessed for them.
    pub(crate) fn rest_since(&mut self, rest: Standstill) {
        for frame in self.frames.iter_mut().rev().take_while(|frame| frame.t >= rest.from) {
            frame.rest.get_or_insert(rest);
        }
    }

    /// Says that the newest frame is not part of the rest before it: frames after `sure` may have moved, by less than the `angle` \[rad\] that counts
    /// as rest. What this is in metres depends on how far away is what was seen; while no depth is known, nothing holds them.
    pub(crate) fn rest_ended(&mut self, sure: Stamp, angle: f64) {
        let depth = self.median_inverse_depth().map(|inverse| 1.0 / inverse);
        for frame in self.frames.iter_mut().rev().take_while(|frame| frame.t > sure) {
            frame.rest = frame.rest.zip(depth).map(|(rest, depth)| Standstill {
                angle: rest.angle.max(angle * (depth / rest::LEVER).max(1.0)),
                ..rest
            });
        }
    }

    /// The middle one of the known inverse depths \[1/m\].
    fn median_inverse_depth(&self) -> Option<f64> {
        upper_median(self.landmarks.iter().filter_map(|l| l.inverse_depth).filter(|d| *d > 0.0))
    }

    /// Fixes position and heading of the first frame, with what is known of it beforehand: of each axis of its biases the deviations
    /// `bias_std`, accelerometer \[m/s^2\] and gyro \[rad/s\].
    pub(crate) fn anchor(&mut self, bias_std: [f64; 2]) {
        self.prior = Some(self.prior_about(vec![self.frames[0].state]).anchored(bias_std));
    }

    /// Gives every landmark that has none a depth to start from: told by its rays where they part enough, else, once three frames
    /// saw it, the middle one of the others'. A point whose rays are parallel still says how the body turned and that it did not
    /// move far.
    pub(crate) fn triangulate(&mut self) {
        let world_from_cam: Vec<Isometry3<f64>> =
            self.frames.iter().map(|f| f.state.world_from_body * self.body_from_cam).collect();
        let middle = self.median_inverse_depth();
        for landmark in &mut self.landmarks {
            if landmark.inverse_depth.is_none() && landmark.sightings.len() > 1 {
                landmark.inverse_depth = landmark
                    .triangulate(&world_from_cam, self.config.min_triangulation_angle)
                    .or(middle.filter(|_| landmark.sightings.len() > 2));
            }
        }
    }

    /// What landmarks of `host` and their sightings in `target` share, at the present states.
    pub(crate) fn geometry(&self, host: usize, target: usize) -> PairGeometry {
        self.frames[host].seen_with(&self.frames[target], &self.body_from_cam)
    }

    /// A sighting when its image was really taken.
    #[inline]
    pub(crate) fn sighting_at_offset(&self, sighting: &Sighting) -> Sighting {
        if self.time_offset == 0.0 {
            return *sighting;
        }
        let ray = sighting.ray + self.time_offset * sighting.ray_rate;
        Sighting { ray, bearing: ray.normalize(), ..*sighting }
    }

    /// Drops landmarks for which `keep` is false, and renews the places.
    pub(crate) fn retain_landmarks(&mut self, mut keep: impl FnMut(&Landmark) -> bool) {
        self.landmarks.retain(|l| keep(l));
        self.places.clear();
        self.places.extend(self.landmarks.iter().enumerate().map(|(k, l)| (l.id, k)));
    }
}
