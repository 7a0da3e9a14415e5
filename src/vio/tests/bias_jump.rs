//! Biases that jump in flight, at a known time, by a known change: found within a second, no run lost, poses as good as before.

use crate::flown::{Case, apart, make, run};
use dpn_core::ImuSample;
use dpn_sim::Flight;
use dpn_vio::components::{ComponentsConfig, Levels};
use dpn_vio::estimator::{BiasJump, Phase, Update};
use dpn_vio::{EstimatorConfig, ImuBias};
use nalgebra::Vector3;
use std::sync::OnceLock;

const SECONDS: f64 = 45.0;
/// Seconds after the first frame.
const JUMP: f64 = 25.0;

fn calm() -> &'static Case {
    static CASE: OnceLock<Case> = OnceLock::new();
    CASE.get_or_init(|| make(Flight::RoomMedium, 3, 0.0, SECONDS))
}

fn flown(case: &Case, factor: f64, learn: bool, accel: f64, gyro: f64) -> Vec<Update> {
    let config = EstimatorConfig { components: learn.then(ComponentsConfig::default), ..Default::default() };
    let start = case.frames[0].t;
    let jumps = |sample: &mut ImuSample| {
        if sample.t.seconds_since(start) > JUMP {
            sample.accel = sample.accel.map(|a| a + accel);
            sample.gyro = sample.gyro.map(|w| w + gyro);
        }
    };
    run(case, config, factor, jumps, |_| ()).0
}

fn found(updates: &[Update]) -> Vec<&BiasJump> {
    updates.iter().filter_map(|u| u.jump.as_deref()).collect()
}

/// That a run with a jump goes as the one without, but for the bias.
fn survives(case: &Case, factor: f64, learn: bool, jumps: &[(f64, f64)]) {
    let without = flown(case, factor, learn, 0.0, 0.0);
    assert!(found(&without).is_empty(), "x{factor}, no jump: {:?}", found(&without));
    let bias = |updates: &[Update]| updates.last().unwrap().state.unwrap().bias;
    let start = case.frames[0].t;
    for &(accel, gyro) in jumps {
        let name = format!("x{factor}, learn {learn}, jump of {accel} m/s^2, {gyro} rad/s");
        let with = flown(case, factor, learn, accel, gyro);
        assert!(!with.iter().any(|u| matches!(u.phase, Phase::Restarted(_))), "{name}");
        let at = with.iter().find(|u| u.jump.is_some()).map(|u| u.t.seconds_since(start));
        let jumps = found(&with);
        assert_eq!(jumps.len(), 1, "{name}: {jumps:?}");
        let [before, after] = jumps[0].between.map(|t| t.seconds_since(start));
        assert!(before <= JUMP && JUMP <= after + 0.1, "{name}: {before} to {after}");
        assert!(at.unwrap() < JUMP + 1.0, "{name}: found at {at:?}");
        let change = ImuBias {
            accel: bias(&with).accel - bias(&without).accel,
            gyro: bias(&with).gyro - bias(&without).gyro,
        };
        assert!((change.accel - Vector3::repeat(accel)).amax() < 0.03, "{name}: {change:?}");
        assert!((change.gyro - Vector3::repeat(gyro)).amax() < 0.001, "{name}: {change:?}");
        let (far, levels) = (apart(&with, &without), with.last().unwrap().levels.clone());
        assert!(far < 0.01, "{name}: {far} m apart");
        if let (Some(last), Some(last_without)) = (levels, &without.last().unwrap().levels) {
            let white = |levels: &Levels| levels.inertial.0[..6].iter().product::<f64>().powf(1.0 / 6.0);
            let ratio = white(&last) / white(last_without);
            assert!((0.9..1.1).contains(&ratio), "{name}: the white noise by {ratio}");
            let walks = |levels: &Levels| levels.inertial.0[6] * levels.inertial.0[7];
            // It is read when it leaves the window, and fades within some ten seconds.
            let rise = |(with, without): (&Update, &Update)| {
                Some(walks(with.levels.as_deref()?) / walks(without.levels.as_deref()?))
            };
            let highest = with.iter().zip(&without).filter_map(rise).fold(0.0, f64::max);
            assert!(highest > 1.2, "{name}: walks rise by {highest}");
        }
    }
}

#[test]
fn a_jump_is_found_within_a_second_and_nothing_is_lost() {
    survives(calm(), 1.0, false, &[(0.2, 0.02), (1.0, 0.1), (2.0, 0.0)]);
    survives(calm(), 4.0, false, &[(0.0, 0.02), (2.0, 0.1)]);
}

#[test]
fn what_learns_its_noise_takes_it_for_the_walk() {
    survives(calm(), 1.0, true, &[(0.2, 0.02), (0.5, 0.05), (2.0, 0.1)]);
}

#[test]
fn vibration_hides_none() {
    let shaken = make(Flight::RoomMedium, 3, 1.0, SECONDS);
    survives(&shaken, 1.0, true, &[(0.2, 0.02), (2.0, 0.1)]);
    survives(&shaken, 4.0, false, &[(0.5, 0.0)]);
}
