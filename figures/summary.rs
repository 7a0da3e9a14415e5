//! Few numbers for many: envelopes by pixel column.

use dpn_core::signal::stats::{quantile, upper_median};

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
