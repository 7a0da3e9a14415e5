//! Flights with known truth for the tests of this folder, and tests of the whole.

use super::*;
use crate::preint::{NoisySample, Preintegration, PreintegrationConfig};
use crate::state::ImuBias;
use dpn_core::geometry::so3;
use dpn_core::random::Stream;
use dpn_core::time::Stamp;
use dpn_core::{GRAVITY, ImuNoise, ImuSample};
use nalgebra::{Isometry3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Samples a second.
const RATE: f64 = 200.0;

/// A camera mounted askew, as on EuRoC's vehicles.
pub(crate) fn body_from_cam() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(-0.0216, -0.0647, 0.0098), Vector3::new(0.02, -0.03, 1.55))
}

/// A hand-held sway of some decimetres and some degrees.
pub(crate) fn gentle_flight(seed: u64) -> impl Fn(f64) -> Isometry3<f64> {
    let mut rng = Stream::new(seed).named("gentle-flight").rng();
    struct Wave {
        place: Vector3<f64>,
        turn: Vector3<f64>,
        rate: f64,
        phase: f64,
    }
    let waves: Vec<Wave> = (0..3)
        .map(|_| Wave {
            place: Vector3::from_fn(|_, _| rng.random_range(-0.4..0.4)),
            turn: Vector3::from_fn(|_, _| rng.random_range(-0.15..0.15)),
            rate: rng.random_range(1.0..3.5),
            phase: rng.random_range(0.0..6.0),
        })
        .collect();
    move |t| {
        let sum = |of: fn(&Wave) -> Vector3<f64>| {
            waves.iter().map(|w| of(w) * (w.rate * t + w.phase).sin()).sum::<Vector3<f64>>()
        };
        Isometry3::from_parts(sum(|w| w.place).into(), so3::exp(&sum(|w| w.turn)))
    }
}

/// A flight as the initialiser sees it, with its truth.
pub(crate) struct Scene {
    pub frames: Vec<InitFrame>,
    pub preints: Vec<Preintegration>,
    /// World from camera.
    pub cameras: Vec<Isometry3<f64>>,
    pub velocities: Vec<Vector3<f64>>,
    pub bias: ImuBias,
}

impl Scene {
    /// `count` frames every `step` seconds along a path (world from body), tracks off by `noise_px`, the IMU noisy where those are.
    pub(crate) fn new(
        path: &dyn Fn(f64) -> Isometry3<f64>,
        count: usize,
        step: f64,
        noise_px: f64,
        seed: u64,
    ) -> Self {
        let mut rng = Stream::new(seed).named("scene").rng();
        let bias = ImuBias { accel: Vector3::new(0.12, -0.08, 0.1), gyro: Vector3::new(0.03, -0.02, 0.04) };
        let noisy = noise_px > 0.0;
        let points: Vec<Vector3<f64>> = (0..1500)
            .map(|_| {
                let d: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
                d.normalize() * rng.random_range(3.0..9.0)
            })
            .collect();
        let per_step = (step * RATE).round() as usize;
        let (mut frames, mut preints, mut cameras, mut velocities) = (vec![], vec![], vec![], vec![]);
        let h = 1e-4;
        for frame in 0..count {
            let at = |k: usize| (frame * per_step + k) as f64 / RATE;
            let t = at(0);
            let camera = path(t) * body_from_cam();
            let bearings = points.iter().enumerate().filter_map(|(id, p)| {
                let in_cam = camera.inverse_transform_point(&(*p).into()).coords;
                let seen =
                    in_cam.z > 0.5 && in_cam.x.abs() < 0.8 * in_cam.z && in_cam.y.abs() < 0.55 * in_cam.z;
                seen.then(|| {
                    let mut off =
                        || noise_px / 460.0 * Distribution::<f64>::sample(&StandardNormal, &mut rng);
                    let normal = Vector3::new(in_cam.x / in_cam.z + off(), in_cam.y / in_cam.z + off(), 1.0);
                    (id as u64, normal.normalize())
                })
            });
            frames.push(InitFrame::new(Stamp::from_ns(0).plus_seconds(t), bearings.collect()));
            cameras.push(camera);
            let place = |t: f64| path(t).translation.vector;
            velocities.push((place(t + h) - place(t - h)) / (2.0 * h));
            if frame + 1 == count {
                break;
            }
            let mut sample = |t: f64| {
                let mut off = |std: f64| -> Vector3<f64> {
                    Vector3::from_fn(|_, _| {
                        if noisy { std * Distribution::<f64>::sample(&StandardNormal, &mut rng) } else { 0.0 }
                    })
                };
                let turn = path(t - h).rotation.inverse() * path(t + h).rotation;
                let gyro = so3::log(&turn) / (2.0 * h) + bias.gyro + off(0.004);
                let accel_in_world = (place(t + h) - 2.0 * place(t) + place(t - h)) / (h * h);
                let force = path(t).rotation.inverse() * (accel_in_world + Vector3::new(0.0, 0.0, GRAVITY));
                let accel = force + bias.accel + off(0.08);
                NoisySample {
                    sample: ImuSample {
                        t: Stamp::from_ns(0).plus_seconds(t),
                        gyro: gyro.into(),
                        accel: accel.into(),
                    },
                    noise: ImuNoise::baseline(),
                }
            };
            let mut preint =
                Preintegration::new(PreintegrationConfig::default(), ImuBias::zero(), sample(at(0)));
            (1..=per_step).for_each(|k| preint.push(sample(at(k))));
            preints.push(preint);
        }
        // Exact scenes are told without bias of the gyro, which nothing there estimates.
        if !noisy {
            let known = ImuBias { accel: Vector3::zeros(), gyro: bias.gyro };
            preints.iter_mut().for_each(|p: &mut Preintegration| p.reintegrate(known));
        }
        Self { frames, preints, cameras, velocities, bias }
    }

    /// Feeds the scene until an answer comes: the answer and the index of its newest frame.
    fn run(&self, config: InitConfig) -> (Option<(Initialised, usize)>, WaitReason) {
        self.run_on(&mut Initialiser::new(config, body_from_cam(), Stream::new(1)).unwrap())
    }

    fn run_on(&self, init: &mut Initialiser) -> (Option<(Initialised, usize)>, WaitReason) {
        let mut last = WaitReason::TooFewFrames { frames: 0, needed: 0 };
        for (k, frame) in self.frames.iter().enumerate() {
            let preint = k.checked_sub(1).map(|p| self.preints[p].clone());
            match init.push_frame(frame.clone(), preint) {
                InitOutcome::Ready(found) => return (Some((*found, k)), last),
                InitOutcome::Wait(reason) => last = reason,
            }
        }
        (None, last)
    }
}

/// Estimated spread of the frames over the true one.
fn scale_of(found: &Initialised, scene: &Scene) -> f64 {
    let truth: Vec<Vector3<f64>> = found
        .frames
        .iter()
        .map(|f| {
            let at = scene.frames.iter().position(|s| s.t == f.t).unwrap();
            (scene.cameras[at] * body_from_cam().inverse()).translation.vector
        })
        .collect();
    let estimate: Vec<Vector3<f64>> =
        found.frames.iter().map(|f| f.state.world_from_body.translation.vector).collect();
    let spread = |p: &[Vector3<f64>]| {
        let mean = p.iter().sum::<Vector3<f64>>() / p.len() as f64;
        p.iter().map(|x| (x - mean).norm_squared()).sum::<f64>().sqrt()
    };
    spread(&estimate) / spread(&truth)
}

#[test]
fn gentle_flights_are_initialised_within_what_they_say_of_themselves() {
    for seed in 0..6 {
        let scene = Scene::new(&gentle_flight(seed), 60, 0.1, 0.5, seed);
        let (found, last) = scene.run(InitConfig::default());
        let (found, newest) = found.unwrap_or_else(|| panic!("seed {seed}: {last}"));
        let scale = scale_of(&found, &scene);
        assert!(
            (scale - 1.0).abs() < 4.0 * found.scale_std,
            "seed {seed}: scale {scale}, {}",
            found.scale_std
        );
        let state = found.frames.last().unwrap().state;
        let body = scene.cameras[newest] * body_from_cam().inverse();
        let up = |rotation: nalgebra::UnitQuaternion<f64>| rotation.inverse() * Vector3::z();
        let tilt = up(state.world_from_body.rotation).angle(&up(body.rotation));
        assert!(tilt < 4.0 * found.gravity_std && found.gravity_std < 0.05, "{tilt} {}", found.gravity_std);
        let speed = state.world_from_body.rotation.inverse() * state.vel_in_world
            - body.rotation.inverse() * scene.velocities[newest];
        assert!(speed.norm() < 0.15, "seed {seed}: velocity off by {:.3} m/s", speed.norm());
        assert!((found.bias.gyro - scene.bias.gyro).norm() < 5e-3);
    }
}

#[test]
fn what_an_early_start_says_of_its_scale_covers_its_error() {
    /// Flights.
    const FLIGHTS: u64 = 24;
    let mut squares = 0.0;
    for seed in 0..FLIGHTS {
        let (found, last) = Scene::new(&gentle_flight(seed), 20, 0.1, 0.5, seed).run(InitConfig::default());
        let (found, newest) = found.unwrap_or_else(|| panic!("seed {seed}: {last}"));
        assert!(newest <= 14, "seed {seed}: only at frame {newest}");
        let scene = Scene::new(&gentle_flight(seed), 20, 0.1, 0.5, seed);
        squares += (scale_of(&found, &scene).ln() / found.scale_std).powi(2);
    }
    // The accelerometer's noise here is a quarter of the least that is believed: the deviation covers the error about twice over in variance.
    let mean = squares / FLIGHTS as f64;
    assert!((0.2..1.0).contains(&mean), "mean square error over variance {mean:.2}");
}

#[test]
fn the_noise_that_is_told_hardly_moves_the_answer() {
    let scene = Scene::new(&gentle_flight(3), 60, 0.1, 0.5, 3);
    let (plain, _) = scene.run(InitConfig::default());
    let plain = plain.unwrap();
    let mut loud = Scene::new(&gentle_flight(3), 60, 0.1, 0.5, 3);
    for preint in &mut loud.preints {
        let noise = ImuNoise::from_values([0.64; 3], [0.032; 3]).unwrap();
        let samples = preint.samples().iter().map(|s| NoisySample { noise, ..*s });
        let mut samples = samples.collect::<Vec<_>>().into_iter();
        let mut again =
            Preintegration::new(PreintegrationConfig::default(), ImuBias::zero(), samples.next().unwrap());
        samples.for_each(|s| again.push(s));
        *preint = again;
    }
    let (told, _) = loud.run(InitConfig::default());
    let told = told.unwrap();
    assert!(told.1.abs_diff(plain.1) <= 6, "frame {} and {}", plain.1, told.1);
    assert!((scale_of(&told.0, &loud) - 1.0).abs() < 0.12);
}

#[test]
fn straight_flight_and_turning_on_the_spot_are_waited_through() {
    let straight = |t: f64| Isometry3::new(Vector3::new(0.8 * t, 0.2 * t, 0.0), Vector3::zeros());
    let sure = InitConfig { max_scale_std: 0.04, ..InitConfig::default() };
    let (found, last) = Scene::new(&straight, 50, 0.1, 0.5, 2).run(sure);
    assert!(found.is_none(), "scale {:?}", found.map(|f| f.0.scale_std));
    assert_eq!(last.name(), "scale-uncertain");
    let turning = |t: f64| Isometry3::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.6 * t));
    let (found, last) = Scene::new(&turning, 50, 0.1, 0.5, 2).run(InitConfig::default());
    assert!(found.is_none());
    assert!(["too-little-parallax", "scale-uncertain"].contains(&last.name()), "{last}");
}

#[test]
fn rest_is_waited_through_and_its_bias_is_told() {
    let rest = |_: f64| Isometry3::new(Vector3::new(1.0, 0.0, 0.5), Vector3::new(0.1, -0.2, 0.3));
    let scene = Scene::new(&rest, 30, 0.1, 0.5, 4);
    let mut init = Initialiser::new(InitConfig::default(), body_from_cam(), Stream::new(1)).unwrap();
    let (found, last) = scene.run_on(&mut init);
    assert!(found.is_none());
    let WaitReason::AtRest { seconds } = last else { panic!("{last}") };
    assert!(seconds > 2.0);
    assert!((init.resting_gyro_bias().unwrap() - scene.bias.gyro).norm() < 1e-3);
}

#[test]
fn a_take_off_from_rest_is_initialised_from_its_rest() {
    // 1.5 s of rest, then a climb that sways.
    let path = |t: f64| {
        let s = (t - 1.5).max(0.0);
        let up = if s < 1.0 { 0.5 * s * s } else { s - 0.5 };
        Isometry3::new(
            Vector3::new(0.3 * (1.0 - (1.3 * s).cos()), 0.1 * s * s, 0.6 * up),
            Vector3::new(0.1 * (1.0 - (2.0 * s).cos()), 0.0, 0.05 * s),
        )
    };
    let scene = Scene::new(&path, 60, 0.1, 0.5, 5);
    let (found, last) = scene.run(InitConfig::default());
    let (found, newest) = found.unwrap_or_else(|| panic!("{last}"));
    assert!(found.from_rest);
    assert!(newest < 40, "only at frame {newest}");
    assert!((scale_of(&found, &scene) - 1.0).abs() < 4.0 * found.scale_std);
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let scene = Scene::new(&gentle_flight(2), 60, 0.1, 0.5, 2);
    assert_eq!(scene.run(InitConfig::default()).0, scene.run(InitConfig::default()).0);
}

#[test]
fn settings_out_of_bounds_are_refused() {
    let config = InitConfig { min_frames: 1, ..InitConfig::default() };
    let faults = Initialiser::new(config, body_from_cam(), Stream::new(1)).unwrap_err();
    assert_eq!(faults[0].key, "min_frames");
}
