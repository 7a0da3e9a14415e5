//! Uniform B-spline of order 6: quintic pieces, four continuous derivatives.
//!
//! On segment `i`, with `u` in \[0, 1) across it, the cumulative form
//!
//! p(u) = c_i + sum_{k=1..5} lambda_k(u) (c_{i+k} - c_{i+k-1})
//!
//! is used because equal control points give a value and derivatives without any rounding: a spline that stands,
//! stands exactly. Blending matrix: Sommer et al., "Efficient derivative computation for cumulative B-splines on Lie
//! groups", CVPR 2020, eq. 4 and 6, with order k = 6.

use nalgebra::SVector;

/// Control points a segment depends on.
pub const ORDER: usize = 6;

/// Value and derivatives at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const D: usize> {
    /// The value.
    pub value: SVector<f64, D>,
    /// First derivative, per second.
    pub first: SVector<f64, D>,
    /// Second derivative, per second squared.
    pub second: SVector<f64, D>,
    /// Third derivative, per second cubed.
    pub third: SVector<f64, D>,
}

/// A curve in `D` dimensions over \[0, duration\] seconds; outside it stands at its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct UniformSpline<const D: usize> {
    spacing: f64,
    controls: Vec<SVector<f64, D>>,
    /// `blend[k][n]`: coefficient of u^n in lambda_k.
    blend: [[f64; ORDER]; ORDER],
}

impl<const D: usize> UniformSpline<D> {
    /// A spline with a segment of `spacing` seconds for every control point but the last five.
    ///
    /// # Panics
    /// Fewer than six control points, a spacing that is not positive, values that are not finite.
    pub fn new(spacing: f64, controls: Vec<SVector<f64, D>>) -> Self {
        assert!(
            spacing.is_finite() && spacing > 0.0,
            "a knot spacing of {spacing} s; it must be positive and finite"
        );
        assert!(
            controls.len() >= ORDER,
            "{} control points; a spline of order {ORDER} needs at least {ORDER}",
            controls.len()
        );
        assert!(
            controls.iter().flat_map(|c| c.iter()).all(|v| v.is_finite()),
            "a control point is not finite"
        );
        Self { spacing, controls, blend: cumulative_blend() }
    }

    /// Length of the curve in time \[s\].
    pub fn duration(&self) -> f64 {
        self.segments() as f64 * self.spacing
    }

    fn segments(&self) -> usize {
        self.controls.len() - (ORDER - 1)
    }

    /// Value and derivatives `t` seconds after the start.
    pub(crate) fn jet(&self, t: f64) -> Jet<D> {
        let inside = t.clamp(0.0, self.duration()) / self.spacing;
        let mut segment = (inside.floor() as usize).min(self.segments() - 1);
        let mut u = inside - segment as f64;
        // A knot's own time, divided by the spacing, may fall a rounding short of it: the knot belongs to the
        // segment it opens.
        if u > 1.0 - 1e-12 && segment + 1 < self.segments() {
            (segment, u) = (segment + 1, 0.0);
        }
        let rate = 1.0 / self.spacing;
        let mut jet = Jet {
            value: self.controls[segment],
            first: SVector::zeros(),
            second: SVector::zeros(),
            third: SVector::zeros(),
        };
        for k in 1..ORDER {
            let step = self.controls[segment + k] - self.controls[segment + k - 1];
            let [l0, l1, l2, l3] = polynomial_jet(&self.blend[k], u);
            jet.value += step * l0;
            jet.first += step * (l1 * rate);
            jet.second += step * (l2 * rate * rate);
            jet.third += step * (l3 * rate * rate * rate);
        }
        if t < 0.0 || t > self.duration() {
            // The curve stands outside its span.
            jet.first.fill(0.0);
            jet.second.fill(0.0);
            jet.third.fill(0.0);
        }
        jet
    }
}

/// A polynomial of degree 5 and its first three derivatives at `u`.
fn polynomial_jet(c: &[f64; ORDER], u: f64) -> [f64; 4] {
    let [mut p, mut d1, mut d2, mut d3] = [0.0; 4];
    for &coefficient in c.iter().rev() {
        d3 = d3 * u + 3.0 * d2;
        d2 = d2 * u + 2.0 * d1;
        d1 = d1 * u + p;
        p = p * u + coefficient;
    }
    [p, d1, d2, d3]
}

/// Rows: lambda_k; columns: powers of u.
fn cumulative_blend() -> [[f64; ORDER]; ORDER] {
    let degree = ORDER - 1;
    let mut blend = [[0.0; ORDER]; ORDER];
    for s in 0..ORDER {
        for n in 0..ORDER {
            let mut sum = 0.0;
            for l in s..ORDER {
                let sign = if (l - s).is_multiple_of(2) { 1.0 } else { -1.0 };
                sum += sign * binomial(ORDER, l - s) * ((degree - l) as f64).powi((degree - n) as i32);
            }
            let plain = binomial(degree, n) / factorial(degree) * sum;
            for row in blend.iter_mut().take(s + 1) {
                row[n] += plain;
            }
        }
    }
    blend
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

fn binomial(n: usize, k: usize) -> f64 {
    factorial(n) / (factorial(k) * factorial(n - k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::Vector2;
    use rand::Rng;

    fn random_spline(seed: u64) -> UniformSpline<2> {
        let mut rng = Stream::new(seed).named("spline").rng();
        let controls =
            (0..24).map(|_| Vector2::new(rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0))).collect();
        UniformSpline::new(0.4, controls)
    }

    #[test]
    fn the_first_blending_row_is_one_and_the_others_run_from_zero_to_one() {
        let blend = cumulative_blend();
        for u in [0.0, 0.3, 0.9] {
            assert!((polynomial_jet(&blend[0], u)[0] - 1.0).abs() < 1e-14);
        }
        // lambda_5 is the last basis function alone: u^5 / 120.
        assert!((polynomial_jet(&blend[5], 0.7)[0] - 0.7_f64.powi(5) / 120.0).abs() < 1e-15);
        assert!((polynomial_jet(&blend[1], 1.0)[0] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let h = 1e-4;
        for seed in 0..5 {
            let spline = random_spline(seed);
            for i in 1..140 {
                let t = 0.05 * f64::from(i) + 0.013;
                let (before, at, after) = (spline.jet(t - h), spline.jet(t), spline.jet(t + h));
                // Truncation is h^2/6 times two derivatives more, of order 1e3 here: below 1e-5.
                assert!(((after.value - before.value) / (2.0 * h) - at.first).norm() < 1e-5);
                assert!(((after.first - before.first) / (2.0 * h) - at.second).norm() < 1e-5);
                assert!(((after.second - before.second) / (2.0 * h) - at.third).norm() < 1e-4);
            }
        }
    }

    #[test]
    fn three_derivatives_are_continuous_at_every_knot() {
        let spline = random_spline(9);
        for knot in 1..18 {
            let t = 0.4 * f64::from(knot);
            let (a, b) = (spline.jet(t - 1e-10), spline.jet(t + 1e-10));
            assert!((a.value - b.value).norm() < 1e-8);
            assert!((a.first - b.first).norm() < 1e-7);
            assert!((a.second - b.second).norm() < 1e-6);
            // The fourth derivative, some 1e4, times 2e-10 s.
            assert!((a.third - b.third).norm() < 1e-5);
        }
    }

    #[test]
    fn equal_control_points_stand_without_rounding() {
        let home = Vector2::new(0.1, 1.0 / 3.0);
        let spline = UniformSpline::new(0.4, vec![home; 12]);
        for i in 0..50 {
            let jet = spline.jet(0.057 * f64::from(i));
            assert_eq!(jet.value, home);
            assert_eq!(jet.first, Vector2::zeros());
            assert_eq!(jet.second, Vector2::zeros());
            assert_eq!(jet.third, Vector2::zeros());
        }
    }

    #[test]
    fn a_polynomial_of_degree_one_is_reproduced() {
        let controls = (0..12).map(|k| Vector2::new(f64::from(k) - 2.0, 1.0)).collect();
        let spline = UniformSpline::new(0.5, controls);
        assert!((spline.jet(1.25).value[0] - 2.5).abs() < 1e-13);
        assert!((spline.jet(1.25).first[0] - 2.0).abs() < 1e-13);
    }

    #[test]
    #[should_panic(expected = "5 control points; a spline of order 6 needs at least 6")]
    fn five_points_are_no_spline() {
        UniformSpline::new(0.4, vec![Vector2::zeros(); 5]);
    }
}
