//! White levels, scale and misalignment against a trajectory, on simulated flights whose noise is known.

use crate::degrade::Degradation;
use dpn_core::geometry::so3;
use dpn_core::trajectory::StampedPose;
use dpn_core::truth::TrueState;
use dpn_core::{ImuRecording, ImuSample};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_truth::{Against, Known, TruthError, against};
use nalgebra::{Isometry3, Vector3};
use std::ops::Range;
use std::sync::LazyLock;

/// A quarter of a minute of it is looked at.
const PART: Range<usize> = 2000..5000;

static FLIGHT: LazyLock<SimulatedFlight> = LazyLock::new(|| {
    let mut config = FlightConfig::default();
    config.vibration.scale = 0.0;
    config.white.schedule = false;
    simulate(Flight::RoomMedium, 5, &config).unwrap()
});

fn part(of: impl Fn(&ImuSample) -> ImuSample) -> ImuRecording {
    ImuRecording::new(FLIGHT.recording.samples()[PART].iter().map(of).collect()).unwrap()
}

fn poses(degradation: Degradation) -> Vec<StampedPose> {
    let truth = degradation.of(&FLIGHT, 1);
    let samples = &FLIGHT.recording.samples()[PART];
    let near = |s: &&TrueState| (samples[0].t..=samples[samples.len() - 1].t).contains(&s.t);
    let pose = |s: &TrueState| StampedPose { t: s.t, world_from_body: s.world_from_body };
    truth.states().iter().filter(near).map(pose).collect()
}

/// What was found over the root mean square of the white noise that was drawn, accelerometer and gyro, axis by axis.
fn ratios(found: &Against) -> [[f64; 3]; 2] {
    let period = FLIGHT.recording.rate().period();
    found.sensors.each_ref().map(|of| {
        let drawn = &FLIGHT.truth.white.of(of.sensor)[PART];
        [0, 1, 2].map(|axis| {
            let square = drawn.iter().map(|v| v[axis].powi(2)).sum::<f64>() / drawn.len() as f64;
            of.white[axis].density.value / (square * period).sqrt()
        })
    })
}

#[test]
fn levels_scale_and_misalignment_come_back_from_an_exact_trajectory() {
    // A gyro 1.5 % too large along z whose z sees 1 % of x.
    let recording = part(|s| {
        let mut sample = *s;
        sample.gyro[2] += 0.015 * s.gyro[2] + 0.01 * s.gyro[0];
        sample
    });
    let found = against(&recording, &poses(Degradation::NONE)).unwrap();
    for (of, ratios) in found.sensors.iter().zip(ratios(&found)) {
        assert!(of.white.iter().all(|white| white.known == Known::Figure), "{of:?}");
        let deviation = of.white[0].density.log_deviation();
        assert!(deviation < 0.08, "{deviation}");
        assert!(ratios.iter().all(|ratio| ratio.ln().abs() < 3.0 * deviation), "{} {ratios:?}", of.sensor);
        let mean = ratios.iter().sum::<f64>() / 3.0;
        assert!((mean - 1.0).abs() < 0.1, "{} {ratios:?}", of.sensor);
    }
    let [accel, gyro] = &found.sensors;
    assert!(!found.follows && accel.scale.iter().flatten().all(|s| s.value.abs() < 4.0 * s.std), "{accel:?}");
    let near = |told: Option<dpn_truth::Estimated<f64>>, value: f64| {
        let told = told.unwrap();
        assert!((told.value - value).abs() < 4.0 * told.std && told.std < 3e-3, "{value}: {told:?}");
    };
    near(gyro.scale[2], 0.015);
    near(gyro.misalignment[2][0], 0.01);
    near(gyro.scale[1], 0.0);
}

#[test]
fn motion_capture_tells_the_accelerometer_and_of_the_gyroscope_an_interval() {
    let mocap = Degradation {
        rate_hz: 100.0,
        position_std_m: 1e-3,
        rotation_std_deg: 0.1,
        smoothed_s: 0.05,
        ..Degradation::NONE
    };
    let found = against(&part(|s| *s), &poses(mocap)).unwrap();
    let [accel, gyro] = ratios(&found);
    assert!((accel.iter().sum::<f64>() / 3.0 - 1.0).abs() < 0.15, "{accel:?}");
    for (of, ratios) in found.sensors.iter().zip([accel, gyro]) {
        for (white, ratio) in of.white.iter().zip(ratios) {
            let deviations = ratio.ln() / white.density.log_deviation();
            // A bound has no lower end.
            let bound = if white.known == Known::AtMost { f64::INFINITY } else { 3.0 };
            assert!((-3.0..bound).contains(&deviations), "{} {ratio} {white:?}", of.sensor);
        }
    }
}

#[test]
fn a_trajectory_that_follows_the_gyroscope_tells_no_white_noise() {
    let recording = part(|s| *s);
    let samples = recording.samples();
    let start = FLIGHT.recording.samples()[0].t;
    let mut rotation = nalgebra::UnitQuaternion::identity();
    let pose = |(i, sample): (usize, &ImuSample)| {
        let exact = FLIGHT.trajectory.pose(sample.t.seconds_since(start));
        // Corrected ten times a second, between by the gyroscope alone.
        rotation = if i % 20 == 0 {
            exact.rotation
        } else {
            let before = &samples[i - 1];
            let rate = 0.5 * (Vector3::from(before.gyro) + Vector3::from(sample.gyro));
            rotation * so3::exp(&(rate * sample.t.seconds_since(before.t)))
        };
        StampedPose { t: sample.t, world_from_body: Isometry3::from_parts(exact.translation, rotation) }
    };
    let follows: Vec<StampedPose> = samples.iter().enumerate().map(pose).collect();
    let found = against(&recording, &follows).unwrap();
    let all = found.sensors.iter().flat_map(|of| of.white).all(|white| white.known == Known::AtLeast);
    assert!(found.follows && all, "{:?}", found.sensors);
}

#[test]
fn another_clock_is_found_and_another_scale_or_flight_is_named() {
    let (good, recording) = (poses(Degradation::NONE), part(|s| *s));
    let with = |change: &dyn Fn(&StampedPose) -> StampedPose| -> Vec<StampedPose> {
        good.iter().map(change).collect()
    };
    let hour = against(&recording, &with(&|p| StampedPose { t: p.t.plus_seconds(3600.03), ..*p })).unwrap();
    let ahead = hour.clock_s + 1e-3 * hour.report.delay_ms.value;
    assert!((ahead - 3600.03).abs() < 1e-3, "{ahead}");
    let half = with(&|p| {
        let shrunk = 0.5 * p.world_from_body.translation.vector;
        StampedPose {
            t: p.t,
            world_from_body: Isometry3::from_parts(shrunk.into(), p.world_from_body.rotation),
        }
    });
    let error = against(&recording, &half).unwrap_err();
    assert!(matches!(error, TruthError::NotMetric { scale } if (scale - 0.5).abs() < 0.03), "{error}");
    // The same path the other way round, an hour later: no shift brings its turns together.
    let last = good[good.len() - 1].t;
    let mut back = with(&|p| StampedPose { t: last.plus_seconds(3600.0 + last.seconds_since(p.t)), ..*p });
    back.reverse();
    assert!(matches!(against(&recording, &back).unwrap_err(), TruthError::NoOverlap { .. }));
    let few = against(&recording, &good[..20]).unwrap_err();
    assert!(matches!(few, TruthError::TooShort { poses: 20, .. }), "{few}");
}
