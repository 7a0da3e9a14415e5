//! How the frame shakes: a line near 27 Hz and a broad band. Both are true motion, which the camera sees as well.
//!
//! EuRoC's ground truth turns and moves so as well; it was estimated with the same IMU, which makes this likely and no proof. Hence the line and the band are angles and displacements on the trajectory, and no noise.
//!
//! The line is one oscillation, phi' = 2 pi (f_low + wander), on all axes with its own phase, already when the motors idle. The band is white
//! noise, loud as the motors are (the square of their speed, in bursts), through a two-pole resonance
//! x_k = 2 r cos(w) x_{k-1} - r^2 x_{k-2} + e_k, once for an angle and twice for a displacement, one stream an axis, scaled
//! so that rate and acceleration have the deviation asked for.

use super::config::{AMPLITUDE_WANDER_S, IDLE_SPEED, LOW_LINE_HZ, LOW_LINE_WANDER_HZ, VibrationConfig};
use super::motor_speed;
use super::sum::levels;
use crate::flight::FlightPlan;
use crate::imu::ou::Wander;
use crate::trajectory::{ORDER, Shaking, UniformSpline};
use dpn_core::random::{Stream, StreamRng};
use nalgebra::{SVector, Vector1, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, SQRT_2, TAU};

/// Correlation time of the low line's frequency \[s\].
const LOW_LINE_WANDER_S: f64 = 0.3;
/// Knots of the motion \[s\], whatever the IMU's rate.
const KNOT_S: f64 = 0.005;

/// The frame's motion over a flight; none where vibration is off.
pub(crate) fn shaking(config: &VibrationConfig, plan: &FlightPlan, stream: &Stream) -> Option<Shaking> {
    if config.scale == 0.0 {
        return None;
    }
    // Control k acts about knot k - 2.
    let n = (plan.phases.duration() / KNOT_S).ceil() as usize + ORDER - 1;
    let at = |k: usize| (k as f64 - 2.0) * KNOT_S;
    let speed: Vec<f64> = (0..n).map(|k| motor_speed(plan, at(k).max(0.0))).collect();
    let mut motion = vec![SVector::<f64, 6>::zeros(); n];
    add_low_line(config, plan, &speed, stream, &mut motion);
    add_broad_band(config, plan, &speed, stream, &mut motion);
    let part = |first: usize| {
        let controls = motion.iter().map(|m| Vector3::new(m[first], m[first + 1], m[first + 2])).collect();
        UniformSpline::new(KNOT_S, controls)
    };
    Some(Shaking { displacement: part(0), angle: part(3) })
}

/// Adds the low line. Axes: displacement x, y, z, angle x, y, z.
fn add_low_line(
    config: &VibrationConfig,
    plan: &FlightPlan,
    speed: &[f64],
    stream: &Stream,
    to: &mut [SVector<f64, 6>],
) {
    let axes = levels(config, plan);
    let stream = stream.named("low-line");
    let mut rng = stream.named("place").rng();
    let mut phase = rng.random_range(0.0..TAU);
    let lag: [f64; 6] = std::array::from_fn(|_| rng.random_range(0.0..TAU));
    let wander_rng = stream.named("frequency").rng();
    let mut wander = Wander::new(LOW_LINE_WANDER_HZ, LOW_LINE_WANDER_S, KNOT_S, wander_rng);
    // It swells and fades more, and faster, than the rotors do.
    let swell = 4.0 * config.amplitude_wander;
    let swell_rng = stream.named("loudness").rng();
    let mut loudness = Wander::new(swell, 0.25 * AMPLITUDE_WANDER_S, KNOT_S, swell_rng);
    for (to, &motors) in to.iter_mut().zip(speed) {
        let hz = (LOW_LINE_HZ + wander.next()).max(1.0);
        phase += TAU * hz * KNOT_S;
        // exp of a normal has a mean square of exp(2 swell^2); the ramp ends at the idle speed.
        let ramp = (motors / IDLE_SPEED).min(1.0);
        let swing = SQRT_2 * ramp * (loudness.next() - swell * swell).exp();
        // A spline of order 6 smooths its control points by sinc^6.
        let kept = ((PI * hz * KNOT_S).sin() / (PI * hz * KNOT_S)).powi(ORDER as i32);
        for (a, axis) in axes.iter().enumerate() {
            let reach = kept * (TAU * hz).powi(derivative(a));
            to[a] += axis.low_line * swing / reach * (phase + lag[a]).sin();
        }
    }
}

/// Adds the broad band.
fn add_broad_band(
    config: &VibrationConfig,
    plan: &FlightPlan,
    speed: &[f64],
    stream: &Stream,
    to: &mut [SVector<f64, 6>],
) {
    // Loudness of the whole frame: posture, battery, wind; bursts give the tails that the real residual has.
    let quiet = config.amplitude_wander;
    let loudness_rng = stream.named("loudness").rng();
    let mut loudness = Wander::new(quiet, 2.0 * AMPLITUDE_WANDER_S, KNOT_S, loudness_rng);
    let loudness: Vec<f64> = speed.iter().map(|_| (loudness.next() - quiet * quiet).exp()).collect();
    let swell = 2.5 * config.amplitude_wander;
    for (a, axis) in levels(config, plan).iter().enumerate() {
        let mut rng = stream.named("broad-band").index(a as u64).rng();
        let burst_rng = stream.named("burst").index(a as u64).rng();
        let mut burst = Wander::new(swell, 0.125 * AMPLITUDE_WANDER_S, KNOT_S, burst_rng);
        let mut band = Band::new(axis.broad_band_hz, derivative(a));
        for ((to, &motors), &loud) in to.iter_mut().zip(speed).zip(&loudness) {
            let swing = motors * motors * loud * (burst.next() - swell * swell).exp();
            to[a] += axis.broad_band * band.next(swing * normal(&mut rng));
        }
    }
}

fn normal(rng: &mut StreamRng) -> f64 {
    rng.sample(StandardNormal)
}

/// Which derivative of axis `a`'s motion the IMU reads: acceleration of a displacement, rate of an angle.
fn derivative(a: usize) -> i32 {
    if a < 3 { 2 } else { 1 }
}

/// White noise through resonances at one frequency, about as wide as it is high; scaled so that the spline through its values has a derivative of
/// unit deviation.
struct Band {
    phi: [f64; 2],
    gain: f64,
    past: [[f64; 2]; 2],
    poles: usize,
}

impl Band {
    /// Two poles for a first derivative, four for a second, which would else grow with frequency.
    fn new(centre_hz: f64, derivative: i32) -> Self {
        let angle = TAU * centre_hz * KNOT_S;
        // Half width pi f dt in the exponent: quality about 1.
        let r = (-0.5 * angle).exp();
        let phi = [2.0 * r * angle.cos(), -r * r];
        let mut band = Self { phi, gain: 1.0, past: [[0.0; 2]; 2], poles: derivative as usize };
        // Unit white noise through a filter has the sum of the squares of its impulse response for a variance.
        let pulse = |k: usize| if k == ORDER { 1.0 } else { 0.0 };
        let response = (0..RESPONSE).map(|k| Vector1::new(band.next(pulse(k)))).collect();
        let spline = UniformSpline::new(KNOT_S, response);
        let squares = |share: f64| -> f64 {
            let jets = (0..RESPONSE - ORDER).map(|k| spline.jet((k as f64 + share) * KNOT_S));
            jets.map(|jet| if derivative == 1 { jet.first[0] } else { jet.second[0] }.powi(2)).sum()
        };
        // The spline's variance swings between knots: its mean over a knot, by the mid-point rule.
        let variance = [0.125, 0.375, 0.625, 0.875].map(squares).iter().sum::<f64>() / 4.0;
        Self { phi, gain: 1.0 / variance.sqrt(), past: [[0.0; 2]; 2], poles: derivative as usize }
    }

    fn next(&mut self, drive: f64) -> f64 {
        let mut value = self.gain * drive;
        for past in &mut self.past[..self.poles] {
            value += self.phi[0] * past[0] + self.phi[1] * past[1];
            *past = [value, past[0]];
        }
        value
    }
}

/// Knots after which the slowest band (1 Hz, a memory of 64 knots) has forgotten a pulse.
const RESPONSE: usize = 2000;

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn what_the_imu_reads_of_a_band_has_unit_deviation_at_any_centre() {
        for (centre, derivative) in [(5.0, 1), (12.0, 1), (12.0, 2), (40.0, 1), (40.0, 2)] {
            let mut rng = Stream::new(1).rng();
            let mut band = Band::new(centre, derivative);
            let n = 100_000;
            let controls = (0..n).map(|_| Vector1::new(band.next(normal(&mut rng)))).collect();
            let spline = UniformSpline::new(KNOT_S, controls);
            // Not at the knots alone: an IMU of any rate reads it.
            let reading = |i: usize| {
                let jet = spline.jet(0.5 + i as f64 * 0.004_1);
                if derivative == 1 { jet.first[0] } else { jet.second[0] }
            };
            let variance = (0..n).map(|i| reading(i).powi(2)).sum::<f64>() / n as f64;
            // At 5 Hz the memory is about 13 knots: 6,300 independent values, a standard error of 1.8 %.
            assert!((variance - 1.0).abs() < 0.07, "{centre} {derivative}: {variance}");
        }
    }
}
