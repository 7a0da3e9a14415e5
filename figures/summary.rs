//! Few numbers for many: quantiles by true level, envelopes by pixel column.

use dpn_core::signal::stats::{quantile, quantiles, upper_median};

/// The 5, 25, 50, 75 and 95 % quantiles of the values at one level.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    /// Mean true value.
    pub(super) truth: f64,
    /// How many values.
    pub(super) n: usize,
    /// Quantiles, ascending.
    pub(super) quantiles: [f64; 5],
}

/// Shares at which quantiles are taken.
const LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// Distinct true values up to this many are levels of their own; more are binned.
pub(super) const MOST_LEVELS: usize = 16;
/// Bins of equal width for continuous levels.
pub(super) const BINS: usize = 12;

/// Distinct values, ascending.
pub(super) fn levels(truth: &[f64]) -> Vec<f64> {
    let mut levels = truth.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    levels
}

/// Splits `values` by their truth, ascending, and summarises each part. `truth` and `values` have the same length.
pub(super) fn by_level(truth: &[f64], values: &[f64]) -> Vec<Level> {
    let levels = levels(truth);
    let (Some(&low), Some(&high)) = (levels.first(), levels.last()) else {
        return Vec::new();
    };
    let discrete = levels.len() <= MOST_LEVELS;
    let count = if discrete { levels.len() } else { BINS };
    let mut parts = vec![(0.0, Vec::new()); count];
    for (&t, &v) in truth.iter().zip(values) {
        let part = if discrete {
            levels.partition_point(|&level| level < t)
        } else {
            ((t - low) / (high - low) * BINS as f64) as usize
        };
        let part = &mut parts[part.min(count - 1)];
        part.0 += t;
        part.1.push(v);
    }
    parts
        .into_iter()
        .zip(0..)
        .filter(|((_, part), _)| !part.is_empty())
        .map(|((sum, part), i)| {
            Level {
                // A level stays what it was given as: a sum of equal numbers over their count may be an ulp off.
                truth: if discrete { levels[i] } else { sum / part.len() as f64 },
                n: part.len(),
                quantiles: quantiles(&part, &LEVELS).try_into().expect("a quantile a level"),
            }
        })
        .collect()
}

/// The smallest and the largest of some values; infinite where there is none.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Parts of a line without a gap: where values are missing for four usual steps of `time`, no line pretends to know them.
pub(super) fn unbroken<T>(line: &[T], time: impl Fn(&T) -> f64) -> impl Iterator<Item = &[T]> {
    let steps = line.windows(2).map(|pair| time(&pair[1]) - time(&pair[0]));
    // One value alone has no gap.
    let usual = upper_median(steps).unwrap_or(f64::INFINITY);
    line.chunk_by(move |a, b| time(b) - time(a) <= 4.0 * usual)
}

/// What one pixel column shows of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Column {
    /// Mean time of the samples in it \[s\].
    pub(super) t: f64,
    /// Smallest sample.
    pub(super) low: f64,
    /// Median sample.
    pub(super) middle: f64,
    /// Largest sample.
    pub(super) high: f64,
}

/// Thins a signal to at most `count` columns of equal width in time; columns without samples are left out. `t` ascends.
pub(super) fn columns(t: &[f64], values: &[f64], count: usize) -> Vec<Column> {
    let (Some(&start), Some(&end)) = (t.first(), t.last()) else {
        return Vec::new();
    };
    let mut thinned = Thinned::new([start, end], count, 1);
    t.iter().zip(values).for_each(|(t, value)| thinned.push(*t, &[*value]));
    thinned.done().pop().expect("one signal")
}

/// [`columns`] of several signals with the same times that come sample by sample: only one column's samples are held.
#[derive(Debug)]
pub(super) struct Thinned {
    span: [f64; 2],
    count: usize,
    /// The column that is being filled.
    at: usize,
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
    done: Vec<Vec<Column>>,
}

impl Thinned {
    /// For times from the first to the last of `span`.
    pub(super) fn new(span: [f64; 2], count: usize, signals: usize) -> Self {
        let (values, done) = (vec![Vec::new(); signals], vec![Vec::new(); signals]);
        Self { span, count, at: 0, times: Vec::new(), values, done }
    }

    /// Takes the values of all signals at `t`, not before the last.
    pub(super) fn push(&mut self, t: f64, values: &[f64]) {
        let [start, end] = self.span;
        let at =
            (((t - start) / (end - start) * self.count as f64) as usize).min(self.count.saturating_sub(1));
        if at > self.at {
            self.close();
            self.at = at;
        }
        self.times.push(t);
        self.values.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
    }

    fn close(&mut self) {
        if self.times.is_empty() {
            return;
        }
        let t = self.times.iter().sum::<f64>() / self.times.len() as f64;
        for (part, done) in self.values.iter_mut().zip(&mut self.done) {
            let ends =
                [part.iter().copied().min_by(f64::total_cmp), part.iter().copied().max_by(f64::total_cmp)];
            let [low, high] = ends.map(|end| end.expect("a column has a sample"));
            done.push(Column { t, low, middle: quantile(part, 0.5), high });
            part.clear();
        }
        self.times.clear();
    }

    /// The columns, a list a signal.
    pub(super) fn done(mut self) -> Vec<Vec<Column>> {
        self.close();
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_numpys() {
        // numpy.quantile([1, 2, 4, 8], [.05, .25, .5, .75, .95])
        let levels = by_level(&[3.0; 4], &[8.0, 1.0, 4.0, 2.0]);
        let expected = [1.15, 1.75, 3.0, 5.0, 7.4];
        assert_eq!((levels.len(), levels[0].truth, levels[0].n), (1, 3.0, 4));
        for (found, expected) in levels[0].quantiles.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn grid_levels_stay_apart_and_continuous_ones_are_binned() {
        let grid: Vec<f64> = (0..1100).map(|i| 0.01 + 0.02 * f64::from(i % 11)).collect();
        let levels = by_level(&grid, &grid);
        assert_eq!(levels.len(), 11);
        assert!(levels.iter().all(|l| l.n == 100 && l.quantiles == [l.truth; 5]));
        let fine: Vec<f64> = (0..1200).map(f64::from).collect();
        let levels = by_level(&fine, &fine);
        assert_eq!(levels.len(), BINS);
        assert_eq!(levels.iter().map(|l| l.n).sum::<usize>(), 1200);
        assert!(levels.windows(2).all(|w| w[0].quantiles[4] < w[1].quantiles[0]));
    }

    #[test]
    fn columns_keep_every_extreme() {
        let t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.005).collect();
        let mut values: Vec<f64> = (0..1000).map(|i| f64::from(i % 7)).collect();
        values[503] = 99.0;
        values[17] = -99.0;
        let thin = columns(&t, &values, 40);
        assert_eq!(thin.len(), 40);
        assert_eq!(thin.iter().map(|c| c.high).fold(0.0, f64::max), 99.0);
        assert_eq!(thin.iter().map(|c| c.low).fold(0.0, f64::min), -99.0);
        assert!(thin.iter().all(|c| c.low <= c.middle && c.middle <= c.high));
        // A gap in time leaves its columns out.
        let gap = columns(&[0.0, 0.1, 9.9, 10.0], &[1.0, 2.0, 3.0, 4.0], 10);
        assert_eq!(gap.len(), 2);
    }
}
