//! Carried by hand, put down, flown: whatever the rest's length, nothing moves in it and the first seconds of flight are as good as others.

use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::{ImuNoise, ImuSample, SampleRate, Stamp};
use dpn_sim::Trajectory;
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::trajectory::{ORDER, UniformSpline};
use dpn_vio::estimator::{Phase, Update};
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use nalgebra::{Vector1, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// Knots of the splines \[s\].
const KNOT_S: f64 = 0.25;
/// In somebody's hands, to and fro, and in the air \[s\].
const CARRIED_S: f64 = 12.0;
const FLOWN_S: f64 = 14.0;
/// Deviations of a sample \[m/s^2, rad/s\], and of what a start believes of the biases below.
const NOISE: [f64; 2] = [0.08, 0.004];
const BIAS: [[f64; 3]; 2] = [[-0.03, 0.16, 0.06], [-0.002, 0.021, 0.077]];

/// A body that is shaken in a box of half a metre, stands for `rest_s`, rises and circles.
fn carried_and_flown(rest_s: f64) -> Trajectory {
    let knots = |seconds: f64| (seconds / KNOT_S).round() as usize;
    let ease = |u: f64| u * u * (3.0 - 2.0 * u);
    let (mut position, mut yaw) = (Vec::new(), Vec::new());
    for k in 0..knots(CARRIED_S) {
        let (t, u) = (KNOT_S * k as f64, k as f64 / knots(CARRIED_S) as f64);
        // Down on the ground at its end.
        let size = ease((4.0 * (1.0 - u)).min(1.0));
        let sway = |metres: f64, hertz: f64| metres * size * (TAU * hertz * t).sin();
        position.push(Vector3::new(sway(0.25, 0.47), sway(0.25, 0.61), 0.4 * size + sway(0.2, 0.83)));
        yaw.push(Vector1::new(sway(0.5, 0.23)));
    }
    position.extend(std::iter::repeat_n(Vector3::zeros(), knots(rest_s) + ORDER - 1));
    yaw.extend(std::iter::repeat_n(Vector1::zeros(), knots(rest_s) + ORDER - 1));
    for k in 0..knots(FLOWN_S) {
        let t = KNOT_S * k as f64;
        let (up, round) = (ease((t / 4.0).min(1.0)), 0.5 * (t - 3.0).max(0.0));
        position.push(Vector3::new(2.0 * round.sin(), 2.0 - 2.0 * round.cos(), 1.3 * up));
        yaw.push(Vector1::new(0.6 * round));
    }
    Trajectory::new(UniformSpline::new(KNOT_S, position), UniformSpline::new(KNOT_S, yaw))
}

/// The default estimator over all of it, told the true noise.
fn updates(trajectory: &Trajectory, seed: u64) -> Vec<Update> {
    let path = AnalyticPath::new(trajectory.clone(), Stamp::from_ns(0));
    let stamps = camera_stamps(&path, SampleRate::from_hz(20.0).unwrap());
    let frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, seed).unwrap();
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    let mut estimator =
        Estimator::new(EstimatorConfig::default(), CameraModel::euroc_cam0(), body_from_cam, seed).unwrap();
    frames.into_iter().for_each(|frame| estimator.feed_frame(frame).unwrap());
    let mut rng = Stream::new(seed).named("samples").rng();
    let noise = ImuNoise::from_values([NOISE[0]; 3], [NOISE[1]; 3]).unwrap();
    for i in 0..(200.0 * trajectory.duration()) as i64 {
        let t = Stamp::from_ns(5_000_000 * i);
        let state = trajectory.state(t.seconds_since(Stamp::from_ns(0)));
        let mut read = |ideal: Vector3<f64>, sensor: usize| -> [f64; 3] {
            std::array::from_fn(|k| {
                ideal[k] + BIAS[sensor][k] + NOISE[sensor] * rng.sample::<f64, _>(StandardNormal)
            })
        };
        let (accel, gyro) = (read(state.specific_force_in_body, 0), read(state.gyro_in_body, 1));
        estimator.feed_imu(NoisySample { sample: ImuSample { t, gyro, accel }, noise }).unwrap();
    }
    std::iter::from_fn(|| estimator.next_update()).collect()
}

/// The largest error of the way from the first pose within `from..=to` \[s\], whatever the alignment, and the longest way itself \[m\].
fn moved(updates: &[Update], truth: &Trajectory, from: f64, to: f64) -> (f64, f64) {
    let posed = updates.iter().filter_map(|update| {
        let t = update.t.seconds_since(Stamp::from_ns(0));
        let pose = update.state?.world_from_body;
        (from..=to).contains(&t).then(|| (pose.translation.vector, truth.pose(t).translation.vector))
    });
    let posed: Vec<_> = posed.collect();
    let (p0, true0) = posed[0];
    let ways = posed.iter().map(|(p, truth)| ((p - p0).norm(), (truth - true0).norm()));
    ways.fold((0.0, 0.0), |(worst, longest), (way, truth)| (worst.max((way - truth).abs()), longest.max(way)))
}

#[test]
fn nothing_creeps_in_a_rest_and_the_first_seconds_of_flight_are_as_good_as_others() {
    for rest_s in [1.0, 10.0, 60.0] {
        let trajectory = carried_and_flown(rest_s);
        let updates = updates(&trajectory, 1);
        let restarted = updates.iter().find(|u| matches!(u.phase, Phase::Restarted(_)));
        assert!(restarted.is_none(), "{rest_s} s of rest: {restarted:?}");
        let up = CARRIED_S + rest_s;
        let (_, crept) = moved(&updates, &trajectory, CARRIED_S + 0.5, up);
        let (first, way) = moved(&updates, &trajectory, up, up + 0.5 * FLOWN_S);
        let (later, _) = moved(&updates, &trajectory, up + 0.5 * FLOWN_S, up + FLOWN_S);
        eprintln!(
            "{rest_s} s of rest: crept {crept:.4} m; first {first:.4} m off over {way:.2} m, then {later:.4} m"
        );
        assert!(crept < 0.02, "{rest_s} s of rest: crept by {crept} m");
        assert!(first < 0.07 && later < 0.07, "{rest_s} s of rest: {first} m, {later} m");
    }
}
