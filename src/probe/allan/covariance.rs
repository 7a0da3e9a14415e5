//! How Allan variances scatter, and with each other, when the log holds the noise of the model.
//!
//! An overlapping Allan variance is a mean of squares of second differences z1 of the integrated signal; two of them, at m1 and m2, share
//! the signal. For Gaussian noise
//!
//! cov = (2 sum_h n(h) gamma(h)^2 + 4 mu1 mu2 sum_h n(h) gamma(h)) / (4 tau1^2 tau2^2 n1 n2),
//!
//! gamma(h) the covariance of a second difference at m1 with one at m2 that begins h later, n(h) the number of pairs that far apart, mu the
//! mean that a ramp gives. gamma follows from the generalised covariance of the integrated noise: -N^2 |d| / 2 (white),
//! B^2 d^2 ln|d| / (2 pi) (flicker), K^2 |d|^3 / 12 (walk), Q^2 at d = 0 (quantisation); what is missing from a covariance proper is a
//! polynomial, which second differences do not see.
//!
//! gamma is a sum over the noises, so the covariance is a quadratic form in the squares of their coefficients: its coefficients
//! are summed once for a length of log and serve every axis. gamma is smooth between the nine lags where ends meet: those count exactly,
//! long stretches between them by Gauss-Legendre on steps that double away from the ends.

// Triangles of small matrices: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use super::model::Squares;
use dpn_core::SampleRate;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Noises with a covariance: all but the ramp.
const KINDS: usize = 4;

/// Sums over lags for one pair of averages.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Of products of gammas, for unit coefficients.
    products: [[f64; KINDS]; KINDS],
    /// Of gammas.
    single: [f64; KINDS],
}

/// Covariances of the Allan variances of a log of some length at some averages, for any coefficients.
#[derive(Debug, Clone)]
pub struct Scatter {
    averages: Vec<usize>,
    samples: usize,
    period: f64,
    /// Row by row, the upper triangle.
    pairs: Vec<Sums>,
}

impl Scatter {
    /// Of a log of `samples` at `rate`, at `averages` (each at most half of the samples).
    pub fn new(averages: &[usize], samples: usize, rate: SampleRate) -> Self {
        let all: Vec<(usize, usize)> =
            (0..averages.len()).flat_map(|i| (i..averages.len()).map(move |j| (i, j))).collect();
        // In samples; periods come in later.
        let pairs = all.par_iter().map(|&(i, j)| sums(averages[i], averages[j], samples)).collect();
        Self { averages: averages.to_vec(), samples, period: rate.period(), pairs }
    }

    /// The covariance matrix of the Allan variances, row by row, under the model with `squares`.
    pub fn matrix(&self, squares: &Squares) -> Vec<Vec<f64>> {
        let n = self.averages.len();
        let mut matrix = vec![vec![0.0; n]; n];
        let mut pairs = self.pairs.iter();
        // Lengths count in samples: a coefficient takes the power of the period that its generalised covariance has.
        let dt = self.period;
        let [q, white, flicker, walk, ramp] = *squares;
        let scaled = [q, white * dt, flicker * dt * dt, walk * dt * dt * dt];
        for i in 0..n {
            for j in i..n {
                let Some(sums) = pairs.next() else { continue };
                let mut square = 0.0;
                for a in 0..KINDS {
                    for b in 0..KINDS {
                        square += scaled[a] * scaled[b] * sums.products[a][b];
                    }
                }
                let single: f64 = scaled.iter().zip(sums.single).map(|(s, v)| s * v).sum();
                let (m1, m2) = (self.averages[i] as f64, self.averages[j] as f64);
                let (tau1, tau2) = (m1 * dt, m2 * dt);
                let means = ramp * tau1 * tau1 * tau2 * tau2;
                let terms = |m: usize| (self.samples + 1).saturating_sub(2 * m).max(1) as f64;
                let n1n2 = terms(self.averages[i]) * terms(self.averages[j]);
                let value = (2.0 * square + 4.0 * means * single) / (4.0 * tau1 * tau1 * tau2 * tau2 * n1n2);
                matrix[i][j] = value;
                matrix[j][i] = value;
            }
        }
        matrix
    }
}

fn sums(m1: usize, m2: usize, samples: usize) -> Sums {
    let (m1, m2) = (m1 as i64, m2 as i64);
    let total = samples as i64 + 1;
    let (n1, n2) = (total - 2 * m1, total - 2 * m2);
    // Pairs (i, i + h) with i < n1, i + h < n2, both from 0.
    let count = |h: f64| (n1 as f64).min(n2 as f64 - h) - (-h).max(0.0);
    let (least, most) = (-(n1 - 1), n2 - 1);
    let mut sums = Sums::default();
    let mut add = |h: f64, weight: f64, exact: bool| {
        let weight = weight * count(h).max(0.0);
        let gammas = gammas(h, m1 as f64, m2 as f64, exact);
        for a in 0..KINDS {
            sums.single[a] += weight * gammas[a];
            for b in 0..KINDS {
                sums.products[a][b] += weight * gammas[a] * gammas[b];
            }
        }
    };
    // Where an end of the one meets an end of the other; beyond them only flicker noise is left, falling off by the square.
    let mut meet: Vec<i64> = (0..3).flat_map(|i| (0..3).map(move |j| i * m1 - j * m2)).collect();
    let reach = 6 * (m1 + m2);
    let ends = meet.iter().min().zip(meet.iter().max()).map(|(low, high)| [low - reach, high + reach]);
    meet.extend(ends.expect("three ends meet three"));
    for h in &mut meet {
        *h = (*h).clamp(least, most);
    }
    meet.sort_unstable();
    meet.dedup();
    for &h in &meet {
        add(h as f64, 1.0, true);
    }
    for pair in meet.windows(2) {
        between(pair[0], pair[1], &mut add);
    }
    sums
}

/// Calls `add` with lags and weights that stand for all whole lags strictly between `a` and `b`.
fn between(a: i64, b: i64, add: &mut impl FnMut(f64, f64, bool)) {
    const FEW: i64 = 24;
    /// Gauss-Legendre with four points on [-1, 1].
    const NODES: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    ];
    if b - a - 1 <= FEW {
        for h in a + 1..b {
            add(h as f64, 1.0, true);
        }
        return;
    }
    // Four lags at each end one by one, then steps that double towards the middle.
    for k in 1..=4 {
        add((a + k) as f64, 1.0, true);
        add((b - k) as f64, 1.0, true);
    }
    let (low, high) = (a as f64 + 4.5, b as f64 - 4.5);
    let middle = 0.5 * (low + high);
    let mut stretch = |from: f64, to: f64| {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        for (node, weight) in NODES {
            add(centre + half * node, half * weight, false);
        }
    };
    let (mut from, mut step) = (0.0, 4.0);
    while low + from < middle {
        let to = (from + step).min(middle - low);
        stretch(low + from, low + to);
        stretch(high - to, high - from);
        from = to;
        step *= 2.0;
    }
}

/// Covariance of a second difference over `m1` with one over `m2` that begins `h` later, for unit coefficients, in samples.
fn gammas(h: f64, m1: f64, m2: f64, exact: bool) -> [f64; KINDS] {
    const WEIGHTS: [f64; 3] = [1.0, -2.0, 1.0];
    let mut out = [0.0; KINDS];
    for (i, a) in WEIGHTS.into_iter().enumerate() {
        for (j, b) in WEIGHTS.into_iter().enumerate() {
            let d = (h + j as f64 * m2 - i as f64 * m1).abs();
            let weight = a * b;
            if d == 0.0 {
                out[0] += if exact { weight } else { 0.0 };
                continue;
            }
            out[1] -= weight * d / 2.0;
            out[2] += weight * d * d * d.ln() / (2.0 * PI);
            out[3] += weight * d * d * d / 12.0;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::model::variance;

    /// At lag zero, second difference with itself: twice tau squared times the Allan variance of the model.
    #[test]
    fn the_variance_of_a_second_difference_is_the_models() {
        for m in [1.0, 5.0, 1000.0] {
            let gammas = gammas(0.0, m, m, true);
            for k in 0..KINDS {
                let mut squares = [0.0; 5];
                squares[k] = 1.0;
                assert!((gammas[k] / (2.0 * m * m * variance(&squares, m)) - 1.0).abs() < 1e-6, "{k} {m}");
            }
        }
    }

    #[test]
    fn summing_in_steps_is_summing_lag_by_lag() {
        for (m1, m2, samples) in
            [(1usize, 1usize, 3000usize), (3, 40, 3000), (30, 800, 3000), (900, 1000, 3000)]
        {
            let quick = sums(m1, m2, samples);
            let mut slow = Sums::default();
            let (n1, n2) = (samples as i64 + 1 - 2 * m1 as i64, samples as i64 + 1 - 2 * m2 as i64);
            for h in -(n1 - 1)..n2 {
                let count = (n1.min(n2 - h) - (-h).max(0)) as f64;
                let g = gammas(h as f64, m1 as f64, m2 as f64, true);
                for a in 0..KINDS {
                    slow.single[a] += count * g[a];
                    for b in 0..KINDS {
                        slow.products[a][b] += count * g[a] * g[b];
                    }
                }
            }
            for a in 0..KINDS {
                for b in 0..KINDS {
                    let scale = (slow.products[a][a] * slow.products[b][b]).sqrt();
                    let off = (quick.products[a][b] - slow.products[a][b]).abs() / scale;
                    assert!(off < 0.01, "{m1} {m2} {a} {b}: {off}");
                }
            }
        }
    }

    /// White noise, one sample an average: the differences of neighbours have variance 2 and correlation -1/2, so the mean of n of
    /// their squares halved has variance (2 + 4 / 4) / n, less an end.
    #[test]
    fn white_noise_at_one_sample_has_the_scatter_of_the_textbook() {
        let rate = SampleRate::from_hz(1.0).unwrap();
        let scatter = Scatter::new(&[1], 10_000, rate).matrix(&[0.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((scatter[0][0] * 9999.0 / 3.0 - 1.0).abs() < 1e-3, "{}", scatter[0][0]);
    }
}
