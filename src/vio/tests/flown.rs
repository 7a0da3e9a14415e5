//! A simulated flight with its tracks, and the odometry over it, samples or tracks changed on their way.

use dpn_core::camera::CameraModel;
use dpn_core::{ImuNoise, ImuSample, SampleRate, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_vio::estimator::{RunReport, Update};
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use nalgebra::Vector3;

/// A flight's first seconds and its tracks at 10 Hz.
pub(crate) struct Case {
    pub(crate) flight: SimulatedFlight,
    pub(crate) frames: Vec<TrackFrame>,
}

/// `seconds` of a flight that shakes `vibration` times as much as one does.
pub(crate) fn make(kind: Flight, seed: u64, vibration: f64, seconds: f64) -> Case {
    make_tracked(kind, seed, vibration, seconds, &TracksConfig::default())
}

/// The same with other tracks.
pub(crate) fn make_tracked(
    kind: Flight,
    seed: u64,
    vibration: f64,
    seconds: f64,
    tracks: &TracksConfig,
) -> Case {
    let mut config = FlightConfig::default();
    config.vibration.scale = vibration;
    let flight = simulate(kind, seed, &config).unwrap();
    let path = AnalyticPath::of(&flight);
    let stamps = camera_stamps(&path, SampleRate::from_hz(10.0).unwrap());
    let mut frames = simulate_tracks(tracks, &path, &stamps, seed).unwrap();
    let end = frames[0].t.plus_seconds(seconds);
    frames.retain(|f| f.t <= end);
    Case { flight, frames }
}

/// Told 0.08 m/s^2 and 0.004 rad/s times `factor`.
pub(crate) fn run(
    case: &Case,
    config: EstimatorConfig,
    factor: f64,
    sample: impl Fn(&mut ImuSample),
    frame: impl Fn(&mut TrackFrame),
) -> (Vec<Update>, RunReport) {
    let noise = ImuNoise::from_values([0.08 * factor; 3], [0.004 * factor; 3]).unwrap();
    run_told(case, config, noise, sample, frame)
}

/// Told `noise`.
pub(crate) fn run_told(
    case: &Case,
    config: EstimatorConfig,
    noise: ImuNoise,
    sample: impl Fn(&mut ImuSample),
    frame: impl Fn(&mut TrackFrame),
) -> (Vec<Update>, RunReport) {
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    let mut estimator = Estimator::new(config, CameraModel::euroc_cam0(), body_from_cam, 1).unwrap();
    let mut left = case.flight.recording.samples().iter().copied().peekable();
    let mut updates = Vec::new();
    for mut seen in case.frames.iter().cloned() {
        while let Some(mut read) = left.next_if(|s| s.t <= seen.t.plus_seconds(0.006)) {
            sample(&mut read);
            estimator.feed_imu(NoisySample { sample: read, noise }).unwrap();
        }
        frame(&mut seen);
        estimator.feed_frame(seen).unwrap();
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    (updates, estimator.report().clone())
}

fn positions(updates: &[Update]) -> Vec<Option<Vector3<f64>>> {
    updates.iter().map(|u| u.state.map(|state| state.world_from_body.translation.vector)).collect()
}

/// Root mean square of how far two runs are apart \[m\].
pub(crate) fn apart(a: &[Update], b: &[Update]) -> f64 {
    let both = positions(a).into_iter().zip(positions(b)).filter_map(|(a, b)| Some((a? - b?).norm_squared()));
    let squares: Vec<f64> = both.collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
