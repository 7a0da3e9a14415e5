//! Structure from motion up to scale, the frames' rotations given by the gyro.
//!
//! 1. Of all pairs of frames the one with most parallax after compensating rotation, by what the pair can triangulate; too little
//!    of it and there is nothing to see but rotation.
//! 2. Its translation by consensus ([`super::translation`]), of length 1: the unit of everything here. Points both frames see.
//! 3. Frame by frame, the one that sees most known points next: its position by weighted linear least squares on the points'
//!    directions, its rotation as given; the points that it completes.
//! 4. Bundle adjustment of cameras and points, rotations held near the gyro's; outliers out; again.

use super::adjustment::{self, OUTLIER_DEVIATIONS, rescale, solve, track_std_factor};
use super::config::{InitConfig, MIN_PARALLAX_PX, MIN_SHARED_TRACKS, TRACK_STD_PX};
use super::frame::{InitFrame, shared, tracks};
use super::outcome::WaitReason;
use super::robust;
use super::translation::{self, compensated_parallax};
use crate::factors::reprojection::PairGeometry;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, NavState, POSITION, ROTATION, VELOCITY};
use crate::window::Landmark;
use dpn_core::random::Stream;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

/// Pairs of frames that are tried before giving up.
const PAIRS_TRIED: usize = 4;
/// Points that a frame must see to get a position: it has three unknowns, and bare walls have few.
const MIN_POINTS: usize = 6;
/// Misfit, in deviations, up to which a triangulated point is used.
const MAX_MISFIT: f64 = 3.0;
/// Parallax, in deviations, from which a point is used.
const MIN_PARALLAX: f64 = 3.0;
/// Steps of each adjustment.
const STEPS: usize = 8;
/// Deviation of the gyro's rotation between frames that the bias's uncertainty does not cover \[rad\].
const ROTATION_FLOOR: f64 = 2e-3;
/// Deviation that holds a gauge.
const GAUGE_STD: f64 = 1e-5;

/// Cameras and points in a frame of arbitrary scale, whose rotation is the given rotations'.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    /// World from camera, a frame each.
    pub cameras: Vec<Isometry3<f64>>,
    /// The tracks that became points, by increasing id; their sightings are good to [`Self::track_std`].
    pub landmarks: Vec<Landmark>,
    /// Deviation of a track in one direction \[rad\], from the residuals.
    pub track_std: f64,
}

/// What the structure is built from: frames, world-from-camera rotations and their uncertainty.
pub(super) struct Input<'a> {
    /// The frames.
    pub frames: &'a [&'a InitFrame],
    /// World from camera by the gyro, a frame each.
    pub rotations: &'a [UnitQuaternion<f64>],
    /// Deviation of the gyro's bias that made them \[rad/s\].
    pub gyro_bias_std: f64,
}

/// Cameras and points; `Err` when it has to wait.
pub(super) fn build(
    input: &Input<'_>,
    config: &InitConfig,
    stream: &Stream,
) -> Result<Structure, WaitReason> {
    let noise = config.angle(TRACK_STD_PX);
    let tracks = tracks(input.frames, noise);
    let pairs = ranked_pairs(input, config)?;
    let mut most = 0;
    for (trial, (a, b)) in pairs.iter().take(PAIRS_TRIED).enumerate() {
        let mut rng = stream.index(trial as u64).rng();
        let common = shared(input.frames[*a], input.frames[*b]);
        let first_from_second = input.rotations[*a].inverse() * input.rotations[*b];
        let Some(found) = translation::estimate(&first_from_second, &common, noise, &mut rng) else {
            continue;
        };
        most = most.max(found.inliers.len());
        if 2 * found.inliers.len() < common.len() {
            continue;
        }
        let mut growing = Growing::new(input, &tracks, noise);
        growing.place(*a, Vector3::zeros());
        growing.place(*b, input.rotations[*a] * found.direction);
        growing.complete();
        while let Some(next) = growing.next() {
            let Some(centre) = growing.resect(next) else { break };
            growing.place(next, centre);
            growing.complete();
        }
        let placed = growing.cameras.iter().flatten().count();
        if placed < input.frames.len() {
            most = most.max(placed);
            continue;
        }
        if let Some(structure) = adjust(input, growing, (*a, *b)) {
            return Ok(structure);
        }
    }
    Err(WaitReason::NoStructure { consistent: most, needed: MIN_SHARED_TRACKS })
}

/// Pairs of frames with enough parallax, best first.
fn ranked_pairs(input: &Input<'_>, config: &InitConfig) -> Result<Vec<(usize, usize)>, WaitReason> {
    let (mut most_shared, mut most_parallax) = (0, 0.0f64);
    let mut pairs = Vec::new();
    for a in 0..input.frames.len() {
        for b in a + 1..input.frames.len() {
            let common = shared(input.frames[a], input.frames[b]);
            most_shared = most_shared.max(common.len());
            if common.len() < MIN_SHARED_TRACKS {
                continue;
            }
            let first_from_second = input.rotations[a].inverse() * input.rotations[b];
            let parallax = compensated_parallax(&first_from_second, &common);
            most_parallax = most_parallax.max(parallax);
            if parallax >= config.angle(MIN_PARALLAX_PX) {
                // What a pair knows of its translation's direction: parallax times the root of the tracks.
                pairs.push((parallax * (common.len() as f64).sqrt(), a, b));
            }
        }
    }
    if most_shared < MIN_SHARED_TRACKS {
        return Err(WaitReason::TooFewTracks { shared: most_shared, needed: MIN_SHARED_TRACKS });
    }
    if pairs.is_empty() {
        let turned = |r: &UnitQuaternion<f64>| input.rotations[0].angle_to(r);
        return Err(WaitReason::TooLittleParallax {
            parallax_px: most_parallax * config.focal_px,
            needed_px: MIN_PARALLAX_PX,
            rotation: input.rotations.iter().map(turned).fold(0.0, f64::max),
        });
    }
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    Ok(pairs.into_iter().map(|(_, a, b)| (a, b)).collect())
}

/// A known point and where a frame sees it, all in the world's axes.
struct Observation {
    /// From the host's camera, at depth 1.
    ray: Vector3<f64>,
    /// The host's camera.
    host: Vector3<f64>,
    inverse_depth: f64,
    /// Unit vector as measured by the frame.
    bearing: Vector3<f64>,
}

impl Observation {
    /// The point as seen from `centre`, times its inverse depth.
    fn point_from(&self, centre: &Vector3<f64>) -> Vector3<f64> {
        self.ray + self.inverse_depth * (self.host - centre)
    }
}

/// A structure to which frames are added.
struct Growing<'a> {
    input: &'a Input<'a>,
    tracks: &'a [Landmark],
    noise: f64,
    cameras: Vec<Option<Isometry3<f64>>>,
    /// A track each, as the cameras saw it from whom it got its depth.
    landmarks: Vec<Option<Landmark>>,
}

impl<'a> Growing<'a> {
    fn new(input: &'a Input<'a>, tracks: &'a [Landmark], noise: f64) -> Self {
        let (cameras, landmarks) = (vec![None; input.frames.len()], vec![None; tracks.len()]);
        Self { input, tracks, noise, cameras, landmarks }
    }

    fn place(&mut self, frame: usize, centre: Vector3<f64>) {
        self.cameras[frame] = Some(Isometry3::from_parts(centre.into(), self.input.rotations[frame]));
    }

    /// Triangulates what two placed frames see and has no depth yet.
    fn complete(&mut self) {
        let poses: Vec<Isometry3<f64>> = self.cameras.iter().map(|c| c.unwrap_or_default()).collect();
        for (track, landmark) in self.tracks.iter().zip(&mut self.landmarks) {
            if landmark.is_some() {
                continue;
            }
            let mut seen = track.clone();
            seen.sightings.retain(|(frame, _)| self.cameras[*frame].is_some());
            if seen.sightings.len() < 2 {
                continue;
            }
            seen.inverse_depth = seen.triangulate(&poses, MIN_PARALLAX * self.noise);
            *landmark = Some(seen).filter(|l| misfit(l, &poses).is_some_and(|m| m <= MAX_MISFIT));
        }
    }

    /// Points with a depth that a frame sees.
    fn known(&self, frame: usize) -> Vec<Observation> {
        self.tracks
            .iter()
            .zip(&self.landmarks)
            .filter_map(|(track, landmark)| {
                let landmark = landmark.as_ref()?;
                let host = self.cameras[landmark.host()]?;
                let (_, seen) = track.sightings.iter().find(|(f, _)| *f == frame)?;
                Some(Observation {
                    ray: host.rotation * landmark.host_sighting().ray,
                    host: host.translation.vector,
                    inverse_depth: landmark.inverse_depth?,
                    bearing: self.input.rotations[frame] * seen.bearing,
                })
            })
            .collect()
    }

    /// The frame without a place that sees most points.
    fn next(&self) -> Option<usize> {
        (0..self.cameras.len())
            .filter(|f| self.cameras[*f].is_none())
            .map(|f| (self.known(f).len(), f))
            .max_by_key(|(count, f)| (*count, std::cmp::Reverse(*f)))
            .filter(|(count, _)| *count >= MIN_POINTS)
            .map(|(_, f)| f)
    }

    /// The centre from which a frame sees the known points where it sees them.
    ///
    /// `(I - f f^T)(m + l (c_host - c)) = 0` (ray `m`, inverse depth `l`, bearing `f`) is linear in `c`; a residual counts by the angle that it is.
    fn resect(&self, frame: usize) -> Option<Vector3<f64>> {
        let known = self.known(frame);
        let mut centre: Option<Vector3<f64>> = None;
        for round in 0..6 {
            let (mut moments, mut right) = (Matrix3::zeros(), Vector3::zeros());
            // As with the gyro's bias, the weights' scale comes down from that of a first, blind solution.
            let scale = self.noise * [8.0, 8.0, 4.0, 2.0, 1.5, 1.5][round];
            for seen in &known {
                let across = Matrix3::identity() - seen.bearing * seen.bearing.transpose();
                let weight = centre.map_or(1.0, |c| {
                    let point = seen.point_from(&c);
                    let length = point.norm().max(1e-3);
                    let squared = ((across * point).norm() / length / scale).powi(2);
                    robust::weight(squared) / (length * length)
                });
                moments += weight * seen.inverse_depth * seen.inverse_depth * across;
                right += weight * seen.inverse_depth * across * seen.point_from(&Vector3::zeros());
            }
            centre = Some(moments.cholesky()?.solve(&right));
        }
        let centre = centre.filter(|c| c.iter().all(|x| x.is_finite()))?;
        let limit = 2.0 * OUTLIER_DEVIATIONS * self.noise;
        let agree = known.iter().filter(|seen| {
            let point = seen.point_from(&centre);
            point.dot(&seen.bearing) > 0.0 && point.cross(&seen.bearing).norm() < limit * point.norm()
        });
        let agree = agree.count();
        (agree >= MIN_POINTS && 2 * agree >= known.len()).then_some(centre)
    }
}

/// Root mean square of a point's residuals \[deviations\].
fn misfit(landmark: &Landmark, world_from_cam: &[Isometry3<f64>]) -> Option<f64> {
    landmark.rms(|host, target| {
        PairGeometry::new(&world_from_cam[host], &world_from_cam[target], &Isometry3::identity())
    })
}

/// Adjusts all cameras and points; `None` when too little stays.
fn adjust(input: &Input<'_>, growing: Growing<'_>, (a, b): (usize, usize)) -> Option<Structure> {
    let poses: Vec<Isometry3<f64>> = growing.cameras.into_iter().collect::<Option<_>>()?;
    // The "bodies" are the cameras.
    let mut window = adjustment::window(Isometry3::identity(), MIN_PARALLAX * growing.noise);
    for (frame, pose) in input.frames.iter().zip(&poses) {
        let state = NavState { world_from_body: *pose, ..NavState::identity() };
        window.add_frame(frame.t, state, None, &[]);
    }
    window.landmarks = growing.tracks.to_vec();
    window.triangulate();
    window.retain_landmarks(|l| misfit(l, &poses).is_some_and(|m| m <= 2.0 * MAX_MISFIT));

    let mut prior = window.prior_about(window.frames().iter().map(|f| f.state).collect());
    for (frame, InitFrame { t, .. }) in input.frames.iter().enumerate() {
        let seconds = t.seconds_since(input.frames[a].t).abs();
        let std = if frame == a { GAUGE_STD } else { ROTATION_FLOOR + input.gyro_bias_std * seconds };
        prior.hold(frame, ROTATION, std);
        // Without inertial measurements these are no unknowns.
        [VELOCITY, ACCEL_BIAS, GYRO_BIAS].into_iter().for_each(|index| prior.hold(frame, index, 1.0));
    }
    prior.hold(a, POSITION, GAUGE_STD);
    let along = (poses[b].translation.vector - poses[a].translation.vector).try_normalize(1e-9)?;
    prior.hold_along(&[(a, POSITION, -along), (b, POSITION, along)], GAUGE_STD);
    window.prior = Some(prior);

    let mut track_std = growing.noise;
    for _ in 0..2 {
        solve(&mut window, STEPS);
        let found = track_std_factor(&window, |_| 0.0) * track_std;
        let found = found.clamp(0.2 * growing.noise, 3.0 * growing.noise);
        rescale(&mut window, found / track_std);
        track_std = found;
        window.reject_outliers();
    }
    window.retain_landmarks(|l| l.inverse_depth.is_some());
    let seen_by = |frame: usize| window.landmarks().iter().filter(|l| l.seen_by(frame)).count();
    if (0..poses.len()).any(|f| seen_by(f) < MIN_POINTS) {
        return None;
    }
    Some(Structure {
        cameras: window.frames().iter().map(|f| f.state.world_from_body).collect(),
        landmarks: window.landmarks,
        track_std,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::init::tests::{Scene, gentle_flight};

    #[test]
    fn cameras_and_points_come_out_up_to_one_scale() {
        for seed in 0..4 {
            let scene = Scene::new(&gentle_flight(seed), 8, 0.2, 0.5, seed);
            let frames: Vec<&InitFrame> = scene.frames.iter().collect();
            let rotations: Vec<_> = scene.cameras.iter().map(|c| c.rotation).collect();
            let input = Input { frames: &frames, rotations: &rotations, gyro_bias_std: 1e-3 };
            let structure = build(&input, &InitConfig::default(), &Stream::new(1)).unwrap();
            let spread = |poses: &[Isometry3<f64>]| -> Vec<Vector3<f64>> {
                let mean =
                    poses.iter().map(|p| p.translation.vector).sum::<Vector3<f64>>() / poses.len() as f64;
                poses.iter().map(|p| p.translation.vector - mean).collect()
            };
            let (found, truth) = (spread(&structure.cameras), spread(&scene.cameras));
            let scale = truth.iter().zip(&found).map(|(t, f)| t.dot(f)).sum::<f64>()
                / found.iter().map(Vector3::norm_squared).sum::<f64>();
            let size = truth.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
            let off: f64 =
                truth.iter().zip(&found).map(|(t, f)| (t - scale * f).norm_squared()).sum::<f64>().sqrt();
            assert!(off < 0.05 * size, "seed {seed}: shape off by {:.1} %", 100.0 * off / size);
            assert!(structure.landmarks.len() > 40);
        }
    }

    #[test]
    fn a_camera_that_only_turns_is_told_so() {
        let still =
            |t: f64| Isometry3::new(Vector3::zeros(), Vector3::new(0.3 * t, 0.1 * t, 0.2 * (2.0 * t).sin()));
        let scene = Scene::new(&still, 8, 0.2, 0.5, 1);
        let frames: Vec<&InitFrame> = scene.frames.iter().collect();
        let rotations: Vec<_> = scene.cameras.iter().map(|c| c.rotation).collect();
        let input = Input { frames: &frames, rotations: &rotations, gyro_bias_std: 1e-3 };
        let reason = build(&input, &InitConfig::default(), &Stream::new(1)).unwrap_err();
        assert!(
            matches!(reason, WaitReason::TooLittleParallax { parallax_px, rotation, .. } if parallax_px < 2.0 && rotation > 0.2),
            "{reason}"
        );
    }
}
