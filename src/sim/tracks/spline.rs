//! Cubic splines through vectors at uneven times, twice differentiable, with the not-a-knot end condition.
//!
//! With steps `h_i = t_{i+1} - t_i`, slopes `s_i` between the points and derivatives `d_i` at them, inside
//!
//! ```text
//! h_i d_{i-1} + 2 (h_{i-1} + h_i) d_i + h_{i-1} d_{i+1} = 3 (h_i s_{i-1} + h_{i-1} s_i)
//! ```
//!
//! and at the ends the third derivative passes through the second and the last but one point unbroken.
//! Source: de Boor, *A Practical Guide to Splines*, ch. IV; the same as scipy's `CubicSpline`.

use nalgebra::SVector;

/// A spline of vectors of `D` numbers.
#[derive(Debug, Clone)]
pub(super) struct CubicSpline<const D: usize> {
    times: Vec<f64>,
    values: Vec<SVector<f64, D>>,
    derivatives: Vec<SVector<f64, D>>,
}

/// The fewest points a not-a-knot spline needs here.
pub(super) const FEWEST: usize = 4;

impl<const D: usize> CubicSpline<D> {
    /// Through `values` at `times` \[s, increasing\], as many of the one as of the other; `None` for fewer than [`FEWEST`].
    pub(super) fn new(times: Vec<f64>, values: Vec<SVector<f64, D>>) -> Option<Self> {
        let n = values.len();
        if n < FEWEST || times.len() != n {
            return None;
        }
        let step: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
        let slope: Vec<SVector<f64, D>> = (0..n - 1).map(|i| (values[i + 1] - values[i]) / step[i]).collect();
        // Row i of the tridiagonal system: below, on and above the diagonal, and the right-hand side.
        let row = |i: usize| {
            if i == 0 {
                let span = step[0] + step[1];
                let rhs =
                    (slope[0] * ((step[0] + 2.0 * span) * step[1]) + slope[1] * (step[0] * step[0])) / span;
                (0.0, step[1], span, rhs)
            } else if i == n - 1 {
                let (last, before) = (step[n - 2], step[n - 3]);
                let span = last + before;
                let rhs =
                    (slope[n - 3] * (last * last) + slope[n - 2] * ((2.0 * span + last) * before)) / span;
                (span, before, 0.0, rhs)
            } else {
                let (before, after) = (step[i - 1], step[i]);
                let rhs = (slope[i - 1] * after + slope[i] * before) * 3.0;
                (after, 2.0 * (before + after), before, rhs)
            }
        };
        // Elimination downwards, then substitution upwards.
        let mut above = vec![0.0; n];
        let mut derivatives = vec![SVector::<f64, D>::zeros(); n];
        for i in 0..n {
            let (low, on, high, rhs) = row(i);
            let (before_above, before) =
                if i == 0 { (0.0, SVector::zeros()) } else { (above[i - 1], derivatives[i - 1]) };
            let pivot = on - low * before_above;
            above[i] = high / pivot;
            derivatives[i] = (rhs - before * low) / pivot;
        }
        for i in (0..n - 1).rev() {
            let later = derivatives[i + 1];
            derivatives[i] -= later * above[i];
        }
        Some(Self { times, values, derivatives })
    }

    /// The value at `t`; beyond the ends the first and the last cubic go on.
    pub(super) fn at(&self, t: f64) -> SVector<f64, D> {
        let after = self.times.partition_point(|time| *time <= t);
        let i = after.saturating_sub(1).min(self.times.len() - 2);
        let h = self.times[i + 1] - self.times[i];
        let x = (t - self.times[i]) / h;
        // Hermite's form.
        let (a, b) = (self.values[i], self.values[i + 1]);
        let (da, db) = (self.derivatives[i] * h, self.derivatives[i + 1] * h);
        let rise = b - a;
        a + (da + (rise * 3.0 - da * 2.0 - db + (da + db - rise * 2.0) * x) * x) * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    #[test]
    fn it_agrees_with_a_cubic_everywhere() {
        // The not-a-knot spline of a cubic is the cubic, whatever the knots.
        let cubic = |t: f64| Vector1::new(2.0 - t * (1.0 - t * (0.5 - 0.25 * t)));
        for n in [4, 5, 9] {
            let times: Vec<f64> = (0..n).map(|i| 0.3 * f64::from(i) + 0.1 * f64::from(i % 3)).collect();
            let values = times.iter().map(|t| cubic(*t)).collect();
            let spline = CubicSpline::new(times.clone(), values).unwrap();
            for i in -2..=(40 * n) {
                let t = 0.01 * f64::from(i);
                assert!((spline.at(t) - cubic(t)).norm() < 1e-11, "{n} {t}");
            }
        }
    }

    #[test]
    fn it_passes_through_its_points_with_two_steady_derivatives() {
        let times = [0.0, 0.4, 0.5, 1.3, 1.4, 2.0];
        let values = [1.0, -2.0, 0.5, 3.0, 2.9, -1.0];
        let spline = CubicSpline::new(times.to_vec(), values.map(Vector1::new).to_vec()).unwrap();
        let at = |t: f64| spline.at(t)[0];
        for (t, value) in times.into_iter().zip(values) {
            assert!((at(t) - value).abs() < 1e-13);
        }
        for t in &times[1..5] {
            // One-sided second differences carry h times the third derivative, which is below 1e4 here.
            let h = 1e-5;
            let before = (at(*t) - 2.0 * at(t - h) + at(t - 2.0 * h)) / (h * h);
            let after = (at(t + 2.0 * h) - 2.0 * at(t + h) + at(*t)) / (h * h);
            assert!((before - after).abs() < 0.5, "{t}: {before} {after}");
        }
    }

    #[test]
    fn fewer_than_four_points_make_none() {
        assert!(CubicSpline::new(vec![0.0, 1.0, 2.0], vec![Vector1::new(0.0); 3]).is_none());
    }
}
