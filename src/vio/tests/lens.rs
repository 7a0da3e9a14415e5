//! Tracks through a lens that is not as it was calibrated: learned, and the path is better for it; one that is as calibrated is left as it is.

use dpn_core::camera::CameraModel;
use dpn_core::{ImuNoise, SampleRate, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_vio::estimator::RunReport;
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use nalgebra::{Vector2, Vector3};

/// A field of waves some hundreds of pixels long, `size` px an axis and rms.
fn field(px: &Vector2<f64>, size: f64) -> Vector2<f64> {
    let wave = |x: f64, y: f64, phase: f64| (px.x / x + px.y / y + phase).sin();
    size * Vector2::new(
        wave(70.0, 90.0, 0.3) + wave(-110.0, 60.0, 1.0),
        wave(95.0, -65.0, 2.0) + wave(60.0, 140.0, 4.0),
    )
}

fn flight() -> (SimulatedFlight, Vec<TrackFrame>) {
    let mut config = FlightConfig::default();
    config.vibration.scale = 0.0;
    let flight = simulate(Flight::RoomMedium, 3, &config).unwrap();
    let path = AnalyticPath::of(&flight);
    let stamps = camera_stamps(&path, SampleRate::from_hz(10.0).unwrap());
    let mut frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, 3).unwrap();
    let end = frames[0].t.plus_seconds(60.0);
    frames.retain(|f| f.t <= end);
    (flight, frames)
}

/// The path told of tracks that are `size` off, and the report.
fn runs(
    flight: &SimulatedFlight,
    frames: &[TrackFrame],
    size: f64,
    learn: bool,
) -> (Vec<Vector3<f64>>, RunReport) {
    let mut config = EstimatorConfig::default();
    config.lens.learn = learn;
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    let mut estimator =
        Estimator::new(config, CameraModel::euroc_cam0(), body_from_cam, "flight", 1).unwrap();
    let noise = ImuNoise::from_values([0.08; 3], [0.004; 3]).unwrap();
    let mut left = flight.recording.samples().iter().peekable();
    let mut path = Vec::new();
    for frame in frames {
        while let Some(sample) = left.next_if(|s| s.t <= frame.t.plus_seconds(0.006)) {
            estimator.feed_imu(NoisySample { sample: *sample, noise }).unwrap();
        }
        let mut frame = frame.clone();
        for track in &mut frame.tracks {
            track.px += field(&track.px, size);
        }
        estimator.feed_frame(frame).unwrap();
        while let Some(update) = estimator.next_update() {
            if let Some(state) = update.state {
                path.push(state.world_from_body.translation.vector);
            }
        }
    }
    (path, estimator.report().clone())
}

/// How far two paths are apart at their common last poses, root mean square \[m\].
fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[a.len() - n..], &b[b.len() - n..]);
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum();
    (squares / n as f64).sqrt()
}

#[test]
fn a_lens_that_is_off_is_learned_and_one_that_is_not_left_alone() {
    let (flight, frames) = flight();
    let (exact, report) = runs(&flight, &frames, 0.0, false);
    assert_eq!(report.lens_px, None);
    let (off, _) = runs(&flight, &frames, 0.4, false);
    let (learned, report) = runs(&flight, &frames, 0.4, true);
    let (before, after) = (apart(&off, &exact), apart(&learned, &exact));
    let px = report.lens_px.unwrap();
    println!("{before:.4} m apart, {after:.4} m once the lens is learned as {px:.2} px off");
    assert!(after < 0.6 * before, "{before} m, {after} m");
    assert!((0.4..0.8).contains(&px), "{px} px");
    let (as_calibrated, report) = runs(&flight, &frames, 0.0, true);
    let px = report.lens_px.unwrap();
    println!(
        "{:.4} m apart where the lens is as calibrated, learned as {px:.2} px off",
        apart(&as_calibrated, &exact)
    );
    assert!(px < 0.3 && apart(&as_calibrated, &exact) < 0.5 * before, "{px} px");
}
