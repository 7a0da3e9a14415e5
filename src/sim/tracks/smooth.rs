//! Smoothing of poses by a local cubic: each row becomes the least-squares cubic through its neighbours, taken at its own time.
//!
//! On even stamps this is the Savitzky-Golay filter of order 3 (`dpn_core::signal`), edges by the cubic through the first and the last
//! window; on uneven ones, as where a motion capture has lost a frame, the fit uses the times as they are. With times `t_j`, scaled to
//! \[-1, 1\], and `q_0 .. q_3` the polynomials orthonormal on them,
//!
//! ```text
//! y(t_i) = sum_j w_j x_j,   w_j = sum_k q_k(t_i) q_k(t_j)
//! ```

use nalgebra::SVector;

/// Order of the polynomial.
const ORDER: usize = 3;

/// Smooths `rows` at `times` \[s, increasing\] over `window` rows; fewer rows than the window use as many as there are. A window below
/// five changes nothing, for a cubic passes through four.
pub(super) fn smooth<const D: usize>(
    times: &[f64],
    rows: &[SVector<f64, D>],
    window: usize,
) -> Vec<SVector<f64, D>> {
    let n = rows.len();
    let fits = window.min(n);
    let window = if fits.is_multiple_of(2) { fits.saturating_sub(1) } else { fits };
    if window < ORDER + 2 {
        return rows.to_vec();
    }
    let half = window / 2;
    let mut weights = Weights::new(window);
    (0..n)
        .map(|i| {
            let first = i.saturating_sub(half).min(n - window);
            weights.set(&times[first..first + window], i - first);
            let terms = weights.values.iter().zip(&rows[first..first + window]);
            terms.fold(SVector::zeros(), |sum, (w, row)| sum + *row * *w)
        })
        .collect()
}

/// The weights of one window, and room to make them in.
struct Weights {
    values: Vec<f64>,
    basis: [Vec<f64>; ORDER + 1],
}

impl Weights {
    fn new(window: usize) -> Self {
        Self { values: vec![0.0; window], basis: std::array::from_fn(|_| vec![0.0; window]) }
    }

    /// For the fit through all of `times`, taken at the one with index `at`.
    fn set(&mut self, times: &[f64], at: usize) {
        let (first, last) = (times[0], times[times.len() - 1]);
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let abscissa = |j: usize| (times[j] - middle) / half;
        self.values.fill(0.0);
        for k in 0..=ORDER {
            let (known, rest) = self.basis.split_at_mut(k);
            let next = &mut rest[0];
            for (j, v) in next.iter_mut().enumerate() {
                *v = if k == 0 { 1.0 } else { abscissa(j) * known[k - 1][j] };
            }
            // Twice is enough (Kahan, Parlett).
            for q in known.iter().chain(known.iter()) {
                let along: f64 = q.iter().zip(next.iter()).map(|(a, b)| a * b).sum();
                next.iter_mut().zip(q).for_each(|(v, q)| *v -= along * q);
            }
            let norm = next.iter().map(|v| v * v).sum::<f64>().sqrt();
            next.iter_mut().for_each(|v| *v /= norm);
            let here = next[at];
            self.values.iter_mut().zip(next.iter()).for_each(|(w, q)| *w += here * q);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::signal::SavitzkyGolay;
    use nalgebra::Vector2;
    use rand::Rng;

    #[test]
    fn on_even_stamps_it_is_the_savitzky_golay_filter_to_the_edges() {
        let mut rng = Stream::new(1).named("test").rng();
        let rows: Vec<_> = (0..60).map(|_| Vector2::new(rng.random(), rng.random::<f64>() - 9.0)).collect();
        let times: Vec<f64> = (0..60).map(|i| 0.005 * f64::from(i)).collect();
        for window in [5, 21] {
            let found = smooth(&times, &rows, window);
            for axis in 0..2 {
                let signal: Vec<f64> = rows.iter().map(|row| row[axis]).collect();
                let expected = SavitzkyGolay::new(window, 3).unwrap().smooth(&signal).unwrap();
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found[axis] - expected).abs() < 1e-12, "{window}: {} {expected}", found[axis]);
                }
            }
        }
    }

    #[test]
    fn a_cubic_passes_unchanged_through_uneven_stamps_and_short_stretches() {
        let cubic = |t: f64| Vector2::new(1.0 + t * (2.0 - t * (0.5 + 3.0 * t)), t);
        for n in [5, 6, 40] {
            let times: Vec<f64> = (0..n).map(|i| 0.01 * f64::from(i + i / 4)).collect();
            let rows: Vec<_> = times.iter().map(|t| cubic(*t)).collect();
            for (found, row) in smooth(&times, &rows, 11).iter().zip(&rows) {
                assert!((found - row).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn a_window_below_five_changes_nothing() {
        let rows = [1.0, -1.0, 1.0, -1.0, 1.0].map(|v| Vector2::new(v, v));
        assert_eq!(smooth(&[0.0, 1.0, 2.0, 3.0, 4.0], &rows, 3), rows);
        assert_eq!(smooth(&[0.0, 1.0, 2.0, 3.0], &rows[..4], 21), rows[..4]);
        assert!(smooth::<2>(&[], &[], 21).is_empty());
    }
}
