//! Signals of a sensor at rest whose five coefficients are known, to hold the fit to.

use super::model::Squares;
use dpn_core::SampleRate;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

/// Draws `samples` of a signal with the coefficients whose squares are given.
///
/// Flicker noise is a sum of first-order processes, three to a decade of time constants, from half a sample to ten lengths of the log.
pub fn at_rest(squares: &Squares, samples: usize, rate: SampleRate, rng: &mut impl Rng) -> Vec<f64> {
    let [quantisation, white, flicker, walk, ramp] = squares.map(f64::sqrt);
    let dt = rate.period();
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    // Equal variance to each time constant gives the density B^2 / (2 pi f).
    let apart = 10f64.ln() / 3.0;
    let decades = (20.0 * samples.max(1) as f64).log10();
    let mut processes: Vec<(f64, f64, f64)> = (0..=(3.0 * decades).ceil() as i32)
        .map(|k| {
            let keep = (-2.0 * (-f64::from(k) * apart).exp()).exp();
            let std = flicker * (apart / PI).sqrt();
            (keep, std * (1.0 - keep * keep).sqrt(), std * normal())
        })
        .collect();
    let mut bias = 0.0;
    let mut angle_before = quantisation * normal();
    (0..samples)
        .map(|i| {
            bias += walk * dt.sqrt() * normal();
            let angle = quantisation * normal();
            let mut value =
                ramp * i as f64 * dt + bias + (angle - angle_before) / dt + white / dt.sqrt() * normal();
            angle_before = angle;
            if flicker > 0.0 {
                for (keep, drive, state) in &mut processes {
                    *state = *keep * *state + *drive * normal();
                    value += *state;
                }
            }
            value
        })
        .collect()
}
