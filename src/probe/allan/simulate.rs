//! Signals of a sensor at rest whose five coefficients are known, to hold the fit to.

use dpn_core::SampleRate;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

/// Draws `samples` of a signal with the coefficients whose squares are given.
///
/// A sample is the mean of the noise over its period, as the model has it. Flicker noise is a sum of first-order processes, three to a
/// decade of time constants, from a hundredth of a sample to ten lengths of the log.
pub(crate) fn at_rest(squares: &[f64; 5], samples: usize, rate: SampleRate, rng: &mut impl Rng) -> Vec<f64> {
    let [quantisation, white, flicker, walk, ramp] = squares.map(f64::sqrt);
    let dt = rate.period();
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    let mut processes: Vec<Process> = if flicker > 0.0 {
        let decades = (1000.0 * samples.max(1) as f64).log10();
        (0..=(3.0 * decades).ceil() as i32)
            .map(|k| Process::new(flicker, 100.0 * (-f64::from(k) * APART).exp(), normal()))
            .collect()
    } else {
        Vec::new()
    };
    let mut bias = 0.0;
    let mut angle_before = quantisation * normal();
    (0..samples)
        .map(|i| {
            bias += walk * dt.sqrt() * normal();
            let angle = quantisation * normal();
            let mut value =
                ramp * i as f64 * dt + bias + (angle - angle_before) / dt + white / dt.sqrt() * normal();
            angle_before = angle;
            for process in &mut processes {
                value += process.next(normal(), normal());
            }
            value
        })
        .collect()
}

/// Distance of time constants in their logarithm: three to a decade.
const APART: f64 = std::f64::consts::LN_10 / 3.0;

/// A first-order process, its end and its mean over a step drawn together.
struct Process {
    state: f64,
    keep: f64,
    /// Share of the state in the step's mean.
    share: f64,
    /// Of the first normal in the end, of the first and of the second in the mean.
    ends: f64,
    both: f64,
    mean: f64,
}

impl Process {
    /// With `a` steps to a time constant's inverse; equal variance to each constant gives the density B^2 / (2 pi f).
    fn new(flicker: f64, a: f64, normal: f64) -> Self {
        let std = flicker * (APART / PI).sqrt();
        let keep = (-a).exp();
        let gone = -(-a).exp_m1();
        let ends = (1.0 - keep * keep).sqrt();
        // Variance of the mean's own part, and what it shares with the end; by series where they cancel.
        let variance = if a < 0.01 {
            a * (2.0 / 3.0 - a * (0.5 - a * 7.0 / 30.0))
        } else {
            (2.0 * a - 3.0 + 4.0 * keep - keep * keep) / (a * a)
        };
        let both = gone * gone / a / ends;
        Self {
            state: std * normal,
            keep,
            share: gone / a,
            ends: std * ends,
            both: std * both,
            mean: std * (variance - both * both).max(0.0).sqrt(),
        }
    }

    fn next(&mut self, first: f64, second: f64) -> f64 {
        let mean = self.share * self.state + self.both * first + self.mean * second;
        self.state = self.keep * self.state + self.ends * first;
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::deviation::variances;
    use crate::allan::model::variance;
    use dpn_core::random::Stream;

    /// One kind of noise at a time: the mean Allan variance of many logs is the model's, at one sample too.
    #[test]
    fn each_noise_has_the_models_allan_variance() {
        let rate = SampleRate::from_hz(20.0).unwrap();
        for k in 0..5 {
            let mut squares = [0.0; 5];
            squares[k] = 1.0;
            let averages = [1, 4, 30, 200];
            let mut sums = [0.0; 4];
            let logs = 60;
            for log in 0..logs {
                let mut rng = Stream::new(log).named("simulate").index(k as u64).rng();
                let got = variances(&at_rest(&squares, 4000, rate, &mut rng), rate, &averages);
                sums.iter_mut().zip(got).for_each(|(s, v)| *s += v / logs as f64);
            }
            for (m, got) in averages.into_iter().zip(sums) {
                let ratio = got / variance(&squares, m as f64 / 20.0);
                // A bias that stands still within a sample walks half a sample's worth more at one sample.
                let expected = if k == 3 { 1.0 + 0.5 / (m * m) as f64 } else { 1.0 };
                assert!(
                    (ratio / expected - 1.0).abs() < if m == 200 { 0.12 } else { 0.03 },
                    "{k} {m}: {ratio}"
                );
            }
        }
    }
}
