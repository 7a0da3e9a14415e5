//! Bootstrap intervals.
//!
//! A statistic of n cases is computed anew on resamples of n cases drawn with replacement; pairs stay together, since it is indices that
//! are drawn. The interval's ends are quantiles of the resampled values at alpha and 1 - alpha (percentile interval), linear between
//! order statistics (numpy's default), as scipy's are. With fewer than some ten cases it is too narrow. Source: B. Efron and R. J. Tibshirani,
//! "An introduction to the bootstrap", 1993, sec. 13.3.

use super::error::{StatsError, finite, probability};
use dpn_core::random::Stream;
use dpn_core::signal::stats::{median_in_place, quantiles};
use rand::Rng;
use serde::{Deserialize, Serialize};

/// How to resample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bootstrap {
    /// How many resamples; at least 1.
    pub resamples: usize,
    /// Probability inside the interval, in (0, 1).
    pub confidence: f64,
}

impl Default for Bootstrap {
    /// 10,000 resamples, 95 %.
    fn default() -> Self {
        Self { resamples: 10_000, confidence: 0.95 }
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
/// Fewer than two cases; no resample; a confidence outside (0, 1); a statistic that is not finite on the sample or on a resample.
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
    interval(observed, &distribution, options)
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

/// The interval that a set of resampled values makes.
fn interval(observed: f64, distribution: &[f64], options: &Bootstrap) -> Result<Interval, StatsError> {
    finite(&[observed])?;
    finite(distribution)?;
    let tail = 0.5 * (1.0 - options.confidence);
    let ends = quantiles(distribution, &[tail, 1.0 - tail]);
    Ok(Interval { observed, low: ends[0], high: ends[1] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        name: String,
        distribution: Vec<f64>,
        observed: f64,
        percentile_90: [f64; 2],
        percentile_95: [f64; 2],
    }

    #[derive(Deserialize)]
    struct Golden {
        bootstrap: Vec<Row>,
    }

    #[test]
    fn intervals_of_scipys_resamples_are_scipys() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in &golden.bootstrap {
            for (confidence, expected) in [(0.9, row.percentile_90), (0.95, row.percentile_95)] {
                let options = Bootstrap { confidence, resamples: row.distribution.len() };
                let got = interval(row.observed, &row.distribution, &options).unwrap();
                for (got, expected) in [got.low, got.high].into_iter().zip(expected) {
                    assert!((got - expected).abs() < 1e-9, "{}: {got} {expected}", row.name);
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
        // Values of which no two means are equal.
        let a: Vec<f64> = (1..=20).map(|i| f64::from(i).sqrt()).collect();
        let mean = |cases: &[usize]| cases.iter().map(|&i| a[i]).sum::<f64>() / cases.len() as f64;
        let run = |seed| {
            bootstrap(a.len(), mean, &Bootstrap::default(), &Stream::new(seed).named("bootstrap")).unwrap()
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }

    #[test]
    fn what_has_no_interval_says_why() {
        let stream = Stream::new(1).named("test");
        let options = Bootstrap { resamples: 200, ..Bootstrap::default() };
        let same = median_interval(&[2.0; 5], &options, &stream).unwrap();
        assert_eq!((same.low, same.high), (2.0, 2.0));
        assert!(median_interval(&[2.0], &options, &stream).is_err());
        assert!(median_interval(&[2.0, f64::NAN], &options, &stream).is_err());
        assert!(bootstrap(3, |_| f64::NAN, &options, &stream).is_err());
        for bad in [Bootstrap { resamples: 0, ..options }, Bootstrap { confidence: 1.0, ..options }] {
            assert!(median_interval(&[1.0, 2.0], &bad, &stream).is_err());
        }
    }
}
