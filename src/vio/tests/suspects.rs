//! A calibration that is off where turns do not show it: what it is of is named, with its size and sign.

use crate::flown::{Case, make, make_tracked, run};
use dpn_core::{ImuSample, TrackFrame};
use dpn_sim::Flight;
use dpn_sim::tracks::{CameraSettings, TracksConfig};
use dpn_vio::EstimatorConfig;
use dpn_vio::components::ComponentsConfig;
use dpn_vio::estimator::Suspect;

const SECONDS: f64 = 30.0;

fn found(
    case: &Case,
    time_offset_s: Option<f64>,
    sample: impl Fn(&mut ImuSample),
    frame: impl Fn(&mut TrackFrame),
) -> Option<Suspect> {
    let mut config =
        EstimatorConfig { components: Some(ComponentsConfig::default()), ..EstimatorConfig::default() };
    config.front_end.time_offset_s = time_offset_s;
    run(case, config, 1.0, sample, frame).1.suspect
}

#[test]
fn what_residuals_point_at_is_what_was_changed_and_a_sound_flight_has_none() {
    let sound = make(Flight::RoomMedium, 3, 0.0, SECONDS);
    assert_eq!(found(&sound, None, |_| (), |_| ()), None);

    let mut elsewhere = CameraSettings::default();
    elsewhere.body_from_cam[0][3] += 0.15;
    let tracks = TracksConfig { camera: Some(elsewhere), ..TracksConfig::default() };
    let case = make_tracked(Flight::RoomMedium, 3, 0.0, SECONDS, &tracks);
    let seen = found(&case, None, |_| (), |_| ());
    let Some(Suspect::Place { off: [x, y, z] }) = seen else { panic!("{seen:?}") };
    assert!((0.07..0.18).contains(&x) && y.hypot(z) < 0.05, "{seen:?}");

    let seen = found(&sound, None, |sample| sample.gyro = sample.gyro.map(|rate| 0.9 * rate), |_| ());
    let Some(Suspect::GyroScale { off, .. }) = seen else { panic!("{seen:?}") };
    assert!(off.iter().all(|off| (-0.13..0.0).contains(off)), "{seen:?}");

    // Late, and told that it is not.
    let seen = found(&sound, Some(0.0), |_| (), |frame| frame.t = frame.t.plus_seconds(0.02));
    let Some(Suspect::Clock { off_s }) = seen else { panic!("{seen:?}") };
    assert!((-0.025..-0.006).contains(&off_s), "{seen:?}");
}
