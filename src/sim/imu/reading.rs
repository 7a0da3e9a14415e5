//! What the simulated IMU reads along a flight: the parts drawn one by one, then added and rounded.

use super::series::ImuSeries;
use super::truth::ImuTruth;
use super::{bias, quantise, vibration, white};
use crate::config::FlightConfig;
use crate::flight::FlightPlan;
use dpn_core::random::Stream;

/// All parts, and the reading itself, at each of `times` \[s after the flight's start\].
pub(crate) fn read(
    plan: &FlightPlan,
    times: &[f64],
    seed: u64,
    config: &FlightConfig,
) -> (ImuTruth, ImuSeries) {
    let n = times.len();
    let stream = Stream::new(seed).named("flight").named(plan.flight.name()).named("imu");
    let white = white::draw(&config.white, plan.flight, n, &stream.named("white"));
    let mut truth = ImuTruth {
        clean: clean(plan, times),
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

fn clean(plan: &FlightPlan, times: &[f64]) -> ImuSeries {
    let mut series = ImuSeries::default();
    for &t in times {
        let state = plan.trajectory.state(t);
        series.gyro.push(state.gyro_in_body.into());
        series.accel.push(state.specific_force_in_body.into());
    }
    series
}
