//! Bootstrap intervals: percentile, and bias-corrected and accelerated (BCa).
//!
//! A statistic of n cases is computed anew on resamples of n cases drawn with replacement; pairs stay together, since it is indices that
//! are drawn. Percentile: quantiles of the resampled values at alpha and 1 - alpha. BCa: at
//!
//! Phi(z0 + (z0 + z) / (1 - a (z0 + z))),   z = Phi^-1 of either level,
//!
//! with z0 = Phi^-1 of the share of resamples below the observed value, ties counted half, and a = sum u^3 / (6 (sum u^2)^(3/2)), u the mean of
//! the leave-one-out values minus each. Quantiles are linear between order statistics (numpy's default), as scipy's are. With fewer than some
//! ten cases either interval is too narrow; a median's BCa leans on a coarse leave-one-out (it takes two or three values), so prefer the
//! percentile interval there. Source: B. Efron and R. J. Tibshirani, "An introduction to the bootstrap", 1993, sec. 14.3.

use super::error::{StatsError, finite, probability};
use dpn_core::random::Stream;
use dpn_core::signal::stats::{mean, median_in_place, quantiles};
use rand::Rng;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// How an interval is made of resamples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalKind {
    /// Quantiles of the resampled values.
    Percentile,
    /// Bias-corrected and accelerated.
    Bca,
}

/// How to resample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bootstrap {
    /// How many resamples; at least 1.
    pub resamples: usize,
    /// Probability inside the interval, in (0, 1).
    pub confidence: f64,
    /// How the interval is made.
    pub kind: IntervalKind,
}

impl Default for Bootstrap {
    /// 10,000 resamples, 95 %, percentile.
    fn default() -> Self {
        Self { resamples: 10_000, confidence: 0.95, kind: IntervalKind::Percentile }
    }
}

/// A statistic with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The statistic of the sample itself.
    pub observed: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Interval of a statistic of `n` cases, computed from their indices, with repetition; the draws come from the start of `stream`.
///
/// # Errors
/// Fewer than two cases; no resample; a confidence outside (0, 1); a statistic that is not finite on the sample, on a resample or, for BCa, with a
/// case left out; for BCa, resamples that lie all on one side of the observed value.
pub fn bootstrap(
    n: usize,
    statistic: impl Fn(&[usize]) -> f64,
    options: &Bootstrap,
    stream: &Stream,
) -> Result<Interval, StatsError> {
    probability("confidence", options.confidence)?;
    if n < 2 {
        return Err(StatsError::TooFew { what: "a bootstrap", needed: 2, found: n });
    }
    if options.resamples == 0 {
        return Err(StatsError::BadArgument { name: "resamples", value: 0.0, bound: "1 or more" });
    }
    let sample: Vec<usize> = (0..n).collect();
    let observed = statistic(&sample);
    let mut rng = stream.rng();
    let mut drawn = vec![0; n];
    let distribution: Vec<f64> = (0..options.resamples)
        .map(|_| {
            // u32, so that the draws are the same on machines of other word sizes.
            drawn.fill_with(|| rng.random_range(0..n as u32) as usize);
            statistic(&drawn)
        })
        .collect();
    let left_out = match options.kind {
        IntervalKind::Percentile => Vec::new(),
        IntervalKind::Bca => (0..n)
            .map(|out| {
                let kept: Vec<usize> = sample.iter().copied().filter(|i| *i != out).collect();
                statistic(&kept)
            })
            .collect(),
    };
    interval(observed, &distribution, &left_out, options)
}

/// Interval of the median of `x`.
///
/// # Errors
/// As [`bootstrap`]; a value that is not finite.
pub fn median_interval(x: &[f64], options: &Bootstrap, stream: &Stream) -> Result<Interval, StatsError> {
    finite(x)?;
    let statistic = |cases: &[usize]| {
        let mut drawn: Vec<f64> = cases.iter().map(|&i| x[i]).collect();
        median_in_place(&mut drawn)
    };
    bootstrap(x.len(), statistic, options, stream)
}

/// Interval of `mean(a) / mean(b)` over pairs.
///
/// # Errors
/// As [`bootstrap`]; different lengths; a value that is not finite.
pub fn ratio_of_means_interval(
    a: &[f64],
    b: &[f64],
    options: &Bootstrap,
    stream: &Stream,
) -> Result<Interval, StatsError> {
    if a.len() != b.len() {
        return Err(StatsError::Unpaired { first: a.len(), second: b.len() });
    }
    finite(a)?;
    finite(b)?;
    let of = |x: &[f64], cases: &[usize]| mean(&cases.iter().map(|&i| x[i]).collect::<Vec<_>>());
    bootstrap(a.len(), |cases| of(a, cases) / of(b, cases), options, stream)
}

/// The interval that a set of resampled values makes.
fn interval(
    observed: f64,
    distribution: &[f64],
    left_out: &[f64],
    options: &Bootstrap,
) -> Result<Interval, StatsError> {
    finite(&[observed])?;
    finite(distribution)?;
    finite(left_out)?;
    let tail = 0.5 * (1.0 - options.confidence);
    let mut levels = [tail, 1.0 - tail];
    // Resamples that are all the observed value leave nothing to correct.
    let scattered = distribution.iter().any(|v| *v != observed);
    if options.kind == IntervalKind::Bca && scattered {
        let normal = Normal::standard();
        let bias = normal.inverse_cdf(share_below(observed, distribution)?);
        let acceleration = acceleration(left_out);
        levels = levels.map(|level| {
            let z = bias + normal.inverse_cdf(level);
            normal.cdf(bias + z / (1.0 - acceleration * z))
        });
    }
    let ends = quantiles(distribution, &levels);
    Ok(Interval { observed, low: ends[0], high: ends[1] })
}

/// Share of `distribution` below `observed`, ties counted half; refuses 0 and 1.
fn share_below(observed: f64, distribution: &[f64]) -> Result<f64, StatsError> {
    let count =
        |keep: fn(&f64, &f64) -> bool| distribution.iter().filter(|v| keep(v, &observed)).count() as f64;
    let share = (count(|v, o| v < o) + count(|v, o| v <= o)) / (2 * distribution.len()) as f64;
    let side = if share <= 0.0 { "below" } else { "above" };
    if share <= 0.0 || share >= 1.0 {
        return Err(StatsError::OneSided { side, observed });
    }
    Ok(share)
}

fn acceleration(left_out: &[f64]) -> f64 {
    let centre = mean(left_out);
    let power = |k: i32| left_out.iter().map(|v| (centre - v).powi(k)).sum::<f64>();
    let squares = power(2);
    if squares > 0.0 { power(3) / (6.0 * squares.powf(1.5)) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        name: String,
        samples: Vec<Vec<f64>>,
        distribution: Vec<f64>,
        observed: f64,
        percentile_90: [f64; 2],
        percentile_95: [f64; 2],
        bca_90: [f64; 2],
        bca_95: [f64; 2],
    }

    #[derive(Deserialize)]
    struct Golden {
        bootstrap: Vec<Row>,
    }

    #[allow(clippy::type_complexity)]
    fn statistic<'a>(row: &'a Row) -> Box<dyn Fn(&[usize]) -> f64 + 'a> {
        let picked = |x: &[f64], cases: &[usize]| cases.iter().map(|&i| x[i]).collect::<Vec<_>>();
        match row.name.as_str() {
            "median" => Box::new(move |c| dpn_core::signal::stats::median(&picked(&row.samples[0], c))),
            _ => Box::new(move |c| mean(&picked(&row.samples[0], c)) / mean(&picked(&row.samples[1], c))),
        }
    }

    #[test]
    fn intervals_of_scipys_resamples_are_scipys() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in &golden.bootstrap {
            let statistic = statistic(row);
            let n = row.samples[0].len();
            let left_out: Vec<f64> =
                (0..n).map(|out| statistic(&(0..n).filter(|i| *i != out).collect::<Vec<_>>())).collect();
            for (kind, confidence, expected) in [
                (IntervalKind::Percentile, 0.9, row.percentile_90),
                (IntervalKind::Percentile, 0.95, row.percentile_95),
                (IntervalKind::Bca, 0.9, row.bca_90),
                (IntervalKind::Bca, 0.95, row.bca_95),
            ] {
                let options = Bootstrap { confidence, kind, resamples: row.distribution.len() };
                let got = interval(row.observed, &row.distribution, &left_out, &options).unwrap();
                for (got, expected) in [got.low, got.high].into_iter().zip(expected) {
                    assert!((got - expected).abs() < 1e-9, "{} {kind:?}: {got} {expected}", row.name);
                }
            }
        }
    }

    /// The percentile interval of a median has a known law: a resample's median is at most x_(k) with a binomial probability.
    #[test]
    fn the_medians_interval_is_that_of_the_binomial_law() {
        let x: Vec<f64> = (1..=11).map(f64::from).collect();
        let options = Bootstrap { resamples: 40_000, ..Bootstrap::default() };
        let got = median_interval(&x, &options, &Stream::new(1).named("test").named("median")).unwrap();
        // P(median <= k): at least six of eleven draws at most k. By scipy, binom.sf(5, 11, k / 11): k = 2 .0072, 3 .0512; 8 .9488, 9 .9928.
        assert_eq!((got.observed, got.low, got.high), (6.0, 3.0, 9.0));
    }

    #[test]
    fn one_stream_gives_the_same_bits_and_another_other_ones() {
        let a: Vec<f64> = (1..=20).map(|i| f64::from(i).sqrt()).collect();
        let b: Vec<f64> = (1..=20).map(|i| 1.0 + f64::from(i * i % 7)).collect();
        let run = |seed| {
            let stream = Stream::new(seed).named("bootstrap");
            ratio_of_means_interval(&a, &b, &Bootstrap::default(), &stream).unwrap()
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }

    #[test]
    fn what_has_no_interval_says_why() {
        let stream = Stream::new(1).named("test");
        let bca = Bootstrap { resamples: 200, kind: IntervalKind::Bca, ..Bootstrap::default() };
        let same = median_interval(&[2.0; 5], &bca, &stream).unwrap();
        assert_eq!((same.low, same.high), (2.0, 2.0));
        assert!(median_interval(&[2.0], &bca, &stream).is_err());
        assert!(median_interval(&[2.0, f64::NAN], &bca, &stream).is_err());
        assert!(ratio_of_means_interval(&[1.0, 2.0], &[1.0], &bca, &stream).is_err());
        let none = Bootstrap { resamples: 0, ..bca };
        assert!(median_interval(&[1.0, 2.0], &none, &stream).is_err());
        let largest = |cases: &[usize]| cases.len() as f64 * 100.0 + *cases.iter().max().unwrap() as f64;
        let only_once = |cases: &[usize]| {
            if cases[..] == [0, 1, 2, 3, 4, 5, 6, 7] { 1e6 } else { largest(cases) }
        };
        let error = bootstrap(8, only_once, &bca, &stream).unwrap_err();
        assert!(error.to_string().starts_with("no resample lies above the observed 1000000"), "{error}");
    }
}
