//! Real images of a vehicle carried by hand, its real IMU: what a short span shows is the start.
//!
//! The bounds are what VINS-Mono's whole pipeline (C++, its own tracker and defaults) reaches on the same span; `imu_cov = "vins"` is its
//! covariance.

use dpn_core::estimate::NoiseSpec;
use dpn_eval::closed_loop::{RunInfo, SequenceSet, Span, TrackSource, TruthKind, drive, judge};
use dpn_eval::noise::{Fresh, Recorded, track};
use dpn_testing::pack;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::FedTracks;
use dpn_vio::preint::ImuCov;

/// VINS-Mono's ATE \[m\] at x1, x2, x4.
const PEER: [(&str, f64); 3] = [("x1", 5.8e-3), ("x2", 5.2e-3), ("x4", 4.9e-3)];

#[test]
fn a_short_span_of_real_images_is_followed_no_worse_than_by_vins_mono() {
    let Some(dir) = pack("motion") else { return };
    let images = TrackSource::Images { skip_missing: false };
    let source = SequenceSet::one(&dir.join("MH_01_easy_start"), images).unwrap();
    let recording = source.recording(0, 0).unwrap();
    let mut config = EstimatorConfig::default();
    config.imu.imu_cov = ImuCov::Vins;
    config.fed_tracks = FedTracks::Followed;
    let camera = source.camera_input(0, 0, &Span::from(0.0)).unwrap();
    let tracked = camera.tracks(&recording, &config.front_end, 0).unwrap();
    let recorded = Recorded { name: &recording.name, imu: &recording.imu, oracle: None };
    for (spec, peer) in PEER {
        let noise: NoiseSpec = spec.parse().unwrap();
        let stream = dpn_core::random::Stream::new(0);
        let told = track(&noise, &recording.imu, &Fresh { recorded, networks: &[] }, &stream).unwrap();
        let driven = drive(&config, &recording, tracked.run(), &told, 0).unwrap();
        let info = RunInfo {
            camera: "images".into(),
            truth: TruthKind::Published,
            noise,
            seed: 0,
            from_s: 0.0,
            to_s: None,
            front_end: None,
        };
        let row = judge(&recording, &info, &driven).unwrap().row;
        let (ate, scale) = (row.ate_se3.unwrap(), row.scale_error.unwrap());
        eprintln!("{spec}: {:.2} mm, scale {:+.2} %", 1e3 * ate, 1e2 * scale);
        assert!(ate < peer, "{spec}: {ate} m, VINS-Mono {peer} m");
        assert!(scale.abs() < 0.0125, "{spec}: {scale}");
    }
}
