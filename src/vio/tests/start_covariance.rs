//! The covariance of the first pose after a start: errors over flights and seeds are as large as it says.

use crate::flown::{make_tracked, run_told};
use dpn_core::noise::{AccelNoiseDensity, GyroNoiseDensity};
use dpn_core::{ImuNoise, SampleRate};
use dpn_sim::Flight;
use dpn_sim::tracks::{AnalyticPath, CameraPath, TracksConfig};
use dpn_vio::EstimatorConfig;
use nalgebra::{UnitQuaternion, Vector3};

/// NEES of the first pose's position, about the pose that the estimator took for known: position and heading. Then what the scale's deviation was said to be
/// at first and eight seconds later.
fn start(kind: Flight, seed: u64) -> (f64, [f64; 2]) {
    let tracks = TracksConfig { drift_px: 0.0, outlier_share: 0.0, ..TracksConfig::default() };
    let case = make_tracked(kind, seed, 0.0, 25.0, &tracks);
    let path = AnalyticPath::of(&case.flight);
    let mut config = EstimatorConfig { covariance: true, ..EstimatorConfig::default() };
    config.window.pixel_std = 0.5;
    config.window.loss_scale = 3.0;
    let noise = ImuNoise::from_values(
        [AccelNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200).get(); 3],
        [GyroNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200).get(); 3],
    )
    .unwrap();
    let (updates, report) = run_told(&case, config, noise, |_| (), |_| ());
    let first = updates.iter().find(|update| update.state.is_some());
    let first = first.unwrap_or_else(|| panic!("{kind:?} {seed}: no start"));
    let (state, covariance) = (first.state.unwrap(), first.covariance.as_ref().unwrap());
    let anchor = report.anchor.unwrap();
    let truth = |t| path.world_from_body(t).unwrap();
    let from = truth(anchor.t);
    let turn = anchor.world_from_body.rotation * from.rotation.inverse();
    let yaw = 2.0 * turn.coords.z.atan2(turn.coords.w);
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    let moved = heading * (truth(first.t).translation.vector - from.translation.vector);
    let error = state.world_from_body.translation.vector - anchor.world_from_body.translation.vector - moved;
    let position = covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let nees = error.dot(&(position.try_inverse().unwrap() * error));
    let later = updates
        .iter()
        .find(|update| update.state.is_some() && update.t.seconds_since(first.t) >= 8.0)
        .unwrap();
    (nees, [first, later].map(|update| update.scale_std.unwrap()))
}

#[test]
fn the_first_pose_errs_as_much_as_its_covariance_says() {
    let kinds = [Flight::HallLines, Flight::RoomMedium];
    let starts: Vec<_> = kinds.iter().flat_map(|kind| (0..10).map(|seed| start(*kind, seed))).collect();
    let nees: Vec<f64> = starts.iter().map(|(nees, _)| *nees).collect();
    let mean = nees.iter().sum::<f64>() / nees.len() as f64;
    // Twenty errors of three degrees of freedom: 1.8 to 4.5 but for one draw in a hundred. With the first of the motion held at rest it was 49, the climb
    // up to a tenth short.
    assert!((1.8..4.5).contains(&mean), "{mean}: {nees:.1?}");
    for (_, [first, later]) in &starts {
        assert!(later < first && *later < 0.01, "scale known to {first:.4}, then to {later:.4}");
    }
}
