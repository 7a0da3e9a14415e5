//! Levels learned on simulated flights, against the noise that was drawn.

use super::ComponentsConfig;
use crate::estimator::{Estimator, EstimatorConfig, Phase, Update};
use crate::preint::NoisySample;
use dpn_core::camera::CameraModel;
use dpn_core::noise::{AccelNoiseDensity, GyroNoiseDensity};
use dpn_core::{ImuNoise, ImuSample, SampleRate, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use std::sync::OnceLock;

/// True deviations: thrice the data sheet's, so that no level is held by a floor.
const TRUE_SCALE: f64 = 3.0;
const SEED: u64 = 51;

struct Case {
    flight: SimulatedFlight,
    frames: Vec<TrackFrame>,
    accel: f64,
    gyro: f64,
}

/// A flight with white noise of one level and nothing else but walking biases.
fn case() -> &'static Case {
    static CASE: OnceLock<Case> = OnceLock::new();
    CASE.get_or_init(|| {
        let mut config = FlightConfig::default();
        config.white.scale = TRUE_SCALE;
        config.white.schedule = false;
        config.vibration.scale = 0.0;
        let flight = simulate(Flight::RoomWild, SEED, &config).unwrap();
        let path = AnalyticPath::of(&flight);
        let stamps = camera_stamps(&path, SampleRate::from_hz(10.0).unwrap());
        let frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, SEED).unwrap();
        let accel = TRUE_SCALE * AccelNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200).get();
        let gyro = TRUE_SCALE * GyroNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200).get();
        Case { flight, frames, accel, gyro }
    })
}

/// The flight through an estimator that learns, told `factor` times the truth; `add` changes a sample so many seconds after the first.
fn run(factor: f64, add: impl Fn(f64, &mut ImuSample)) -> Vec<Update> {
    run_with(ComponentsConfig::default(), factor, add)
}

fn run_with(components: ComponentsConfig, factor: f64, add: impl Fn(f64, &mut ImuSample)) -> Vec<Update> {
    let case = case();
    let config = EstimatorConfig { components: Some(components), ..Default::default() };
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    let mut estimator = Estimator::new(config, CameraModel::euroc_cam0(), body_from_cam, 1).unwrap();
    let noise = ImuNoise::from_values([factor * case.accel; 3], [factor * case.gyro; 3]).unwrap();
    let samples = case.flight.recording.samples();
    let mut left = samples.iter().peekable();
    let mut updates = Vec::new();
    for frame in &case.frames {
        while let Some(sample) = left.next_if(|s| s.t <= frame.t.plus_seconds(0.006)) {
            let mut sample = *sample;
            add(sample.t.seconds_since(samples[0].t), &mut sample);
            estimator.feed_imu(NoisySample { sample, noise }).unwrap();
        }
        estimator.feed_frame(frame.clone()).unwrap();
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    updates
}

/// Geometric mean of each level over some updates, over the truth for the six of the samples.
fn mean_levels(updates: &[Update], factor: f64) -> [f64; 8] {
    let levels: Vec<_> = updates.iter().filter_map(|u| u.state.and(u.levels.as_deref().copied())).collect();
    std::array::from_fn(|k| {
        let sum: f64 = levels.iter().map(|l| l.inertial.0[k].ln()).sum();
        (sum / levels.len() as f64).exp() * if k < 6 { factor } else { 1.0 }
    })
}

#[test]
fn levels_come_out_near_what_was_drawn_where_at_least_that_is_told_and_rise_where_less_is() {
    for (factor, right) in [(0.5, 0.5..1.2), (1.0, 0.7..1.25), (4.0, 0.8..1.3)] {
        let updates = run(factor, |_, _| {});
        let found = mean_levels(&updates[updates.len() / 2..], factor);
        eprintln!("told x{factor}: {found:.3?}");
        // A span is 1.5 s and counts for 10: some seven at a time leave a deviation of a sixth on each axis. A gyroscope told too quiet is believed
        // before the images: little of its noise is left in its own residual, and it hardly comes up.
        for sensor in [&found[..3], &found[3..6]] {
            let mean = sensor.iter().product::<f64>().cbrt();
            assert!(right.contains(&mean), "told x{factor}: {found:?}");
        }
    }
}

#[test]
fn pixels_are_not_believed_closer_than_their_floor() {
    let quiet = ComponentsConfig { pixel_floor: 0.9, ..ComponentsConfig::default() };
    let told = EstimatorConfig::default().window.pixel_std;
    for (components, above) in [(ComponentsConfig::default(), false), (quiet, true)] {
        let updates = run_with(components, 1.0, |_, _| {});
        let last = updates.iter().rev().find_map(|u| u.levels.as_deref()).unwrap().pixel * told;
        assert!((last > 0.9 - 1e-9) == above && last >= components.pixel_floor - 1e-9, "{last} px");
    }
}

#[test]
fn a_jump_of_the_biases_raises_the_walks_and_not_the_white_noise() {
    let length = case().flight.recording.duration();
    let jump = |t: f64, sample: &mut ImuSample| {
        if t > 0.5 * length {
            sample.accel = sample.accel.map(|a| a + 0.3);
            sample.gyro = sample.gyro.map(|w| w + 0.01);
        }
    };
    let (calm, jumped) = (run(1.0, |_, _| {}), run(1.0, jump));
    assert!(jumped.iter().all(|u| !matches!(u.phase, Phase::Restarted(_))));
    let part = |updates: &[Update], from: f64, to: f64| {
        let n = updates.len() as f64;
        mean_levels(&updates[(from * n) as usize..(to * n) as usize], 1.0)
    };
    let (before, after) = (part(&calm, 0.5, 0.75), part(&jumped, 0.5, 0.75));
    eprintln!("without: {before:.3?}\nwith:    {after:.3?}");
    assert!(after[6] > 1.1 * before[6] && after[7] > 1.1 * before[7], "{before:?} {after:?}");
    let white = |levels: &[f64; 8]| levels[..6].iter().product::<f64>().powf(1.0 / 6.0);
    assert!((white(&after) / white(&before) - 1.0).abs() < 0.1, "{before:?} {after:?}");
    let last = jumped.iter().rev().find_map(|u| u.state).unwrap().bias;
    let calm = calm.iter().rev().find_map(|u| u.state).unwrap().bias;
    let off = (last.accel - calm.accel).add_scalar(-0.3).amax();
    assert!(off < 0.03, "{} {}", last.accel, calm.accel);
    let off = (last.gyro - calm.gyro).add_scalar(-0.01).amax();
    assert!(off < 1e-3, "{} {}", last.gyro, calm.gyro);
}
