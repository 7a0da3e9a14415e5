//! Structure from motion up to scale, the frames' rotations given by the gyro.
//!
//! 1. Of all pairs of frames the one with most parallax after compensating rotation, by what the pair can triangulate; too little
//!    of it and there is nothing to see but rotation.
//! 2. Its translation by consensus ([`super::translation`]), of length 1: the unit of everything here. Points both frames see.
//! 3. Frame by frame, the one that sees most known points next: its position by weighted linear least squares on the points'
//!    directions, its rotation as given; the points that it completes.
//! 4. Bundle adjustment of cameras and points, rotations held near the gyro's; outliers out; again.

use super::bundle::{Bundle, BundleState, Camera, Landmark, Layout, Prior};
use super::config::InitConfig;
use super::frame::{Feature, InitFrame, features, shared};
use super::outcome::WaitReason;
use super::robust;
use super::translation::{self, compensated_parallax};
use super::triangulate::triangulate;
use crate::state::ImuBias;
use dpn_core::random::Stream;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

/// Pairs of frames that are tried before giving up.
const PAIRS_TRIED: usize = 4;
/// Points that a frame must see to get a position.
const MIN_POINTS: usize = 8;
/// Misfit, in deviations, up to which a triangulated point is used.
const MAX_MISFIT: f64 = 3.0;
/// Steps of each bundle adjustment.
const BUNDLE_STEPS: usize = 8;
/// Deviations beyond which a view is dropped.
const OUTLIER_DEVIATIONS: f64 = 4.0;
/// Deviation of the gyro's rotation between frames that the bias's uncertainty does not cover \[rad\].
const ROTATION_FLOOR: f64 = 2e-3;
/// Deviation that holds a gauge.
const GAUGE_STD: f64 = 1e-5;

/// Cameras and points in a frame of arbitrary scale, whose rotation is the given rotations'.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    /// World from camera, a frame each.
    pub cameras: Vec<Isometry3<f64>>,
    /// The tracks that became points.
    pub features: Vec<Feature>,
    /// Their places, a feature each, from [`Self::origin`].
    pub landmarks: Vec<Landmark>,
    /// From where points are parametrised.
    pub origin: Vector3<f64>,
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
    let noise = config.angle(config.track_std_px);
    let features = features(input.frames, 2);
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
        let mut growing = Growing::new(input, &features, *a, noise);
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
    Err(WaitReason::NoStructure { consistent: most, needed: config.min_shared_tracks })
}

/// Pairs of frames with enough parallax, best first.
fn ranked_pairs(input: &Input<'_>, config: &InitConfig) -> Result<Vec<(usize, usize)>, WaitReason> {
    let (mut most_shared, mut most_parallax) = (0, 0.0f64);
    let mut pairs = Vec::new();
    for a in 0..input.frames.len() {
        for b in a + 1..input.frames.len() {
            let common = shared(input.frames[a], input.frames[b]);
            most_shared = most_shared.max(common.len());
            if common.len() < config.min_shared_tracks {
                continue;
            }
            let first_from_second = input.rotations[a].inverse() * input.rotations[b];
            let parallax = compensated_parallax(&first_from_second, &common);
            most_parallax = most_parallax.max(parallax);
            if parallax >= config.angle(config.min_parallax_px) {
                // What a pair knows of its translation's direction: parallax times the root of the tracks.
                pairs.push((parallax * (common.len() as f64).sqrt(), a, b));
            }
        }
    }
    if most_shared < config.min_shared_tracks {
        return Err(WaitReason::TooFewTracks { shared: most_shared, needed: config.min_shared_tracks });
    }
    if pairs.is_empty() {
        let turned = |r: &UnitQuaternion<f64>| input.rotations[0].angle_to(r);
        return Err(WaitReason::TooLittleParallax {
            parallax_px: most_parallax * config.focal_px,
            needed_px: config.min_parallax_px,
            rotation: input.rotations.iter().map(turned).fold(0.0, f64::max),
        });
    }
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    Ok(pairs.into_iter().map(|(_, a, b)| (a, b)).collect())
}

/// A structure to which frames are added.
struct Growing<'a> {
    input: &'a Input<'a>,
    features: &'a [Feature],
    reference: usize,
    noise: f64,
    cameras: Vec<Option<Camera>>,
    poses: Vec<Isometry3<f64>>,
    landmarks: Vec<Option<Landmark>>,
}

impl<'a> Growing<'a> {
    fn new(input: &'a Input<'a>, features: &'a [Feature], reference: usize, noise: f64) -> Self {
        let frames = input.frames.len();
        Self {
            input,
            features,
            reference,
            noise,
            cameras: vec![None; frames],
            poses: vec![Isometry3::identity(); frames],
            landmarks: vec![None; features.len()],
        }
    }

    /// All is seen from the reference frame's centre, where it was placed.
    fn origin(&self) -> Vector3<f64> {
        self.poses[self.reference].translation.vector
    }

    fn place(&mut self, frame: usize, centre: Vector3<f64>) {
        let pose = Isometry3::from_parts(centre.into(), self.input.rotations[frame]);
        self.cameras[frame] = Some(Camera::new(&pose, &Isometry3::identity()));
        self.poses[frame] = pose;
    }

    /// Triangulates what two placed frames see and has no place yet.
    fn complete(&mut self) {
        let origin = self.origin();
        for (feature, landmark) in self.features.iter().zip(&mut self.landmarks) {
            if landmark.is_some() {
                continue;
            }
            let views = feature.views.iter().filter_map(|(f, b)| Some((self.cameras[*f].as_ref()?, *b)));
            if views.clone().count() < 2 {
                continue;
            }
            *landmark = triangulate(&origin, views, self.noise)
                .filter(|t| {
                    t.misfit <= MAX_MISFIT
                        && t.landmark.inverse_distance > -2.0 * t.inverse_distance_std
                        && t.inverse_distance_std.is_finite()
                })
                .map(|t| t.landmark);
        }
    }

    /// Points with a place that a frame sees: their places and directions in it.
    fn known(&self, frame: usize) -> Vec<(Landmark, Vector3<f64>)> {
        self.features
            .iter()
            .zip(&self.landmarks)
            .filter_map(|(feature, landmark)| {
                let landmark = (*landmark)?;
                feature.views.iter().find(|(f, _)| *f == frame).map(|(_, b)| (landmark, *b))
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
    /// `(I - f f^T)(u + rho (origin - c)) = 0` is linear in `c`; a residual counts by the angle that it is.
    fn resect(&self, frame: usize) -> Option<Vector3<f64>> {
        let known = self.known(frame);
        let origin = self.origin();
        let mut centre: Option<Vector3<f64>> = None;
        for round in 0..6 {
            let (mut moments, mut right) = (Matrix3::zeros(), Vector3::zeros());
            // As with the gyro's bias, the weights' scale comes down from that of a first, blind solution.
            let scale = self.noise * [8.0, 8.0, 4.0, 2.0, 1.5, 1.5][round];
            for (landmark, measured) in &known {
                let f = self.input.rotations[frame] * measured;
                let rho = landmark.inverse_distance;
                let across = Matrix3::identity() - f * f.transpose();
                let weight = centre.map_or(1.0, |c| {
                    let seen = landmark.direction + rho * (origin - c);
                    let length = seen.norm().max(1e-3);
                    let squared = ((across * seen).norm() / length / scale).powi(2);
                    robust::weight(squared) / (length * length)
                });
                moments += weight * rho * rho * across;
                right += weight * rho * across * (landmark.direction + rho * origin);
            }
            centre = Some(moments.cholesky()?.solve(&right));
        }
        let centre = centre.filter(|c| c.iter().all(|x| x.is_finite()))?;
        let pose = Isometry3::from_parts(centre.into(), self.input.rotations[frame]);
        let camera = Camera::new(&pose, &Isometry3::identity());
        let limit = 2.0 * OUTLIER_DEVIATIONS * self.noise;
        let agree = known
            .iter()
            .filter(|(l, m)| camera.residual(&origin, l, m).is_some_and(|r| r.norm() < limit))
            .count();
        (agree >= MIN_POINTS && 2 * agree >= known.len()).then_some(centre)
    }
}

/// Bundle adjustment of all cameras and points; `None` when too little stays.
fn adjust(input: &Input<'_>, growing: Growing<'_>, (a, b): (usize, usize)) -> Option<Structure> {
    let origin = growing.origin();
    let cameras: Vec<Camera> = growing.cameras.into_iter().collect::<Option<_>>()?;
    let mut used = Vec::new();
    let (mut landmarks, mut views) = (Vec::new(), Vec::new());
    for (index, feature) in growing.features.iter().enumerate() {
        let seen = feature.views.iter().map(|(f, m)| (&cameras[*f], *m));
        let Some(found) = triangulate(&origin, seen, growing.noise) else { continue };
        if found.misfit <= 2.0 * MAX_MISFIT && found.inverse_distance_std.is_finite() {
            used.push(index);
            landmarks.push(found.landmark);
            views.push(feature.views.clone());
        }
    }
    let layout = Layout::visual(cameras.len());
    let mut priors = vec![
        Prior::Position { frame: a, value: growing.poses[a].translation.vector, std: GAUGE_STD },
        Prior::Distance { from: a, to: b, value: 1.0, std: GAUGE_STD },
    ];
    for (frame, rotation) in input.rotations.iter().enumerate() {
        let seconds = input.frames[frame].t.seconds_since(input.frames[a].t).abs();
        let std = if frame == a { GAUGE_STD } else { ROTATION_FLOOR + input.gyro_bias_std * seconds };
        priors.push(Prior::Rotation { frame, value: *rotation, std });
    }
    let mut bundle = Bundle {
        layout,
        body_from_cam: Isometry3::identity(),
        origin,
        state: BundleState {
            velocities: vec![Vector3::zeros(); cameras.len()],
            bias: ImuBias::zero(),
            landmarks,
            poses: growing.poses,
        },
        views,
        track_std: growing.noise,
        inertial: Vec::new(),
        priors,
    };
    for _ in 0..2 {
        bundle.solve(BUNDLE_STEPS);
        let std = robust::std_of_median(robust::median(&mut bundle.view_residuals()));
        bundle.track_std = std.clamp(0.2 * growing.noise, 3.0 * growing.noise);
        let kept = bundle.drop_outliers(OUTLIER_DEVIATIONS * bundle.track_std, 2);
        used = kept.into_iter().map(|k| used[k]).collect();
    }
    let seen_by = |frame: usize| bundle.views.iter().flatten().filter(|(f, _)| *f == frame).count();
    if (0..layout.frames()).any(|f| seen_by(f) < MIN_POINTS) || !bundle.state.is_finite() {
        return None;
    }
    let features = used
        .iter()
        .zip(bundle.views)
        .map(|(index, views)| Feature { id: growing.features[*index].id, views })
        .collect();
    Some(Structure {
        cameras: bundle.state.poses,
        features,
        landmarks: bundle.state.landmarks,
        origin,
        track_std: bundle.track_std,
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
            assert!(structure.features.len() > 40);
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
