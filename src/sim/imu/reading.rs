//! What the simulated IMU reads along a flight: the parts drawn one by one, then added and rounded.

use super::series::ImuSeries;
use super::truth::ImuTruth;
use super::vibration::VibrationConfig;
use super::{bias, quantise, vibration, white};
use crate::config::FlightConfig;
use crate::flight::{Flight, FlightPlan};
use crate::trajectory::Trajectory;
use dpn_core::random::Stream;

/// What all parts of a flight's IMU are drawn below.
fn stream(flight: Flight, seed: u64) -> Stream {
    Stream::new(seed).named("flight").named(flight.name()).named("imu")
}

/// The planned trajectory with the motion of the frame on it: where the body, and all that is mounted on it, really is.
pub(crate) fn flown(plan: &FlightPlan, seed: u64, config: &VibrationConfig) -> Trajectory {
    let stream = stream(plan.flight, seed).named("vibration");
    match vibration::shaking(config, plan, &stream) {
        Some(shaking) => plan.trajectory.clone().shaken(shaking),
        None => plan.trajectory.clone(),
    }
}

/// All parts, and the reading itself, at each of `times` \[s after the flight's start\].
pub(crate) fn read(
    plan: &FlightPlan,
    trajectory: &Trajectory,
    times: &[f64],
    seed: u64,
    config: &FlightConfig,
) -> (ImuTruth, ImuSeries) {
    let n = times.len();
    let stream = stream(plan.flight, seed);
    let white = white::draw(&config.white, plan.flight, n, &stream.named("white"));
    let mut truth = ImuTruth {
        clean: clean(trajectory, times),
        vibration: vibration::draw(
            &config.vibration,
            plan,
            times,
            config.rate_hz,
            &stream.named("vibration"),
        ),
        bias: bias::draw(&config.bias, config.rate_hz, n, &stream.named("bias")),
        white: white.noise,
        white_sigma: white.sigma,
        quantisation: ImuSeries::default(),
    };
    let mut reading = truth.unrounded();
    truth.quantisation = quantise::round(&config.quantisation, &mut reading);
    (truth, reading)
}

fn clean(trajectory: &Trajectory, times: &[f64]) -> ImuSeries {
    let mut series = ImuSeries::default();
    for &t in times {
        let state = trajectory.state(t);
        series.gyro.push(state.gyro_in_body.into());
        series.accel.push(state.specific_force_in_body.into());
    }
    series
}
