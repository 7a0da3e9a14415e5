//! What is known after a bundle adjustment: covariances from its own information, and how much each sensor's rows were overruled.
//!
//! The covariance of the frames' unknowns is the inverse of the Schur complement `S`; that of a point adds what the frames leave
//! open: `C^-1 + C^-1 W^T S^-1 W C^-1`.
//!
//! For a group of whitened rows `r_g = J_g x` the redundancy is `n_g - tr(J_g S^-1 J_g^T)`: the sum of squares it should have. The root
//! of what it has over that is the factor by which the group's noise was larger than said. Source: Forstner 1979 (variance
//! components), one factor for the gyro's rows and one for the accelerometer's.

use super::inertial::GYRO_ROWS;
use super::problem::Bundle;
use super::solve::Linear;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

/// A group of whitened rows after the adjustment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Excess {
    /// Sum of squares.
    pub squares: f64,
    /// Its expectation.
    pub redundancy: f64,
}

impl Excess {
    /// The factor on the group's deviation, starting from a `prior` factor that counts as much as `weight` redundant rows, where
    /// the rows were expected to be `now` times as large as their noise says.
    pub(crate) fn factor(&self, now: f64, prior: f64, weight: f64) -> f64 {
        let squares = self.squares * now * now + prior * prior * weight;
        (squares / (self.redundancy + weight)).sqrt()
    }
}

/// Covariance of a bundle at its minimum.
#[derive(Debug, Clone)]
pub(crate) struct Covariance {
    frames: DMatrix<f64>,
    linear: Linear,
}

impl Covariance {
    /// At the bundle's current state; `None` where something is not observable at all.
    pub(crate) fn of(bundle: &Bundle) -> Option<Self> {
        let linear = bundle.linearise();
        let (s, _) = linear.reduced(bundle, 0.0)?;
        let frames = s.cholesky()?.inverse();
        frames.iter().all(|x| x.is_finite()).then_some(Self { frames, linear })
    }

    /// Relative deviation of the frames' spread about their mean position: of the scale, when nothing else gives one.
    pub(crate) fn scale_std(&self, bundle: &Bundle) -> f64 {
        let positions: Vec<Vector3<f64>> = bundle.state.poses.iter().map(|p| p.translation.vector).collect();
        let mean = positions.iter().sum::<Vector3<f64>>() / positions.len().max(1) as f64;
        let spread: f64 = positions.iter().map(|p| (p - mean).norm_squared()).sum();
        if spread <= 0.0 {
            return f64::INFINITY;
        }
        // d ln(sqrt(spread)) / d p_k = (p_k - mean) / spread
        let mut slope = DVector::zeros(bundle.layout.len());
        for (frame, position) in positions.iter().enumerate() {
            let at = bundle.layout.position(frame);
            slope.fixed_rows_mut::<3>(at).copy_from(&((position - mean) / spread));
        }
        slope.dot(&(&self.frames * &slope)).max(0.0).sqrt()
    }

    /// Deviation of the direction of gravity as the frame's body sees it \[rad\]: the larger of its two.
    pub(crate) fn gravity_std(&self, bundle: &Bundle, frame: usize) -> f64 {
        let at = bundle.layout.rotation(frame);
        let r_wb = bundle.state.poses[frame].rotation.to_rotation_matrix();
        let block: Matrix3<f64> = self.frames.fixed_view::<3, 3>(at, at).into_owned();
        let in_world = r_wb.matrix() * block * r_wb.matrix().transpose();
        let tilt = in_world.fixed_view::<2, 2>(0, 0).into_owned();
        tilt.symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    /// Deviations of the bias's axes: accelerometer, gyro.
    pub(crate) fn bias_std(&self, bundle: &Bundle) -> Option<[Vector3<f64>; 2]> {
        let at = bundle.layout.bias()?;
        let std = |from: usize| Vector3::from_fn(|k, _| self.frames[(from + k, from + k)].max(0.0).sqrt());
        Some([std(at), std(at + 3)])
    }

    /// Deviation of a point's inverse distance.
    pub(crate) fn inverse_distance_std(&self, bundle: &Bundle, point: usize) -> f64 {
        let block = &self.linear.points[point];
        let Some(inverse) = block.information.try_inverse() else { return f64::INFINITY };
        let mut variance = inverse[(2, 2)];
        let last = inverse.row(2);
        for (a, mixed_a) in &block.mixed {
            let gain_a = last * mixed_a.transpose();
            for (b, mixed_b) in &block.mixed {
                let gain_b = last * mixed_b.transpose();
                let (at, to) = (bundle.layout.position(*a), bundle.layout.position(*b));
                let cross: SMatrix<f64, 6, 6> = self.frames.fixed_view::<6, 6>(at, to).into_owned();
                variance += (gain_a * cross * gain_b.transpose())[(0, 0)];
            }
        }
        variance.max(0.0).sqrt()
    }

    /// What the gyro's and the accelerometer's whitened rows sum to and should.
    pub(crate) fn inertial_excess(&self, bundle: &Bundle) -> [Excess; 2] {
        let mut excess = [Excess::default(); 2];
        for factor in &bundle.inertial {
            let Some(columns) = factor.columns(&bundle.layout) else { continue };
            let (residual, rows) = factor.rows(&bundle.state);
            let block = SMatrix::<f64, 24, 24>::from_fn(|i, j| self.frames[(columns[i], columns[j])]);
            let explained = rows * block * rows.transpose();
            for row in 0..residual.len() {
                let group = &mut excess[usize::from(row >= GYRO_ROWS)];
                group.squares += residual[row] * residual[row];
                group.redundancy += (1.0 - explained[(row, row)]).max(0.0);
            }
        }
        excess
    }

    /// Views' residual rows less what the points and frames took from them.
    pub(crate) fn view_redundancy(&self, bundle: &Bundle) -> f64 {
        let rows: usize = bundle.views.iter().map(|v| 2 * v.len()).sum();
        rows as f64 - 3.0 * bundle.views.len() as f64 - 6.0 * bundle.layout.frames() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::Prior;
    use super::super::solve::tests::disturbed;
    use super::*;
    use dpn_core::geometry::sphere::tangent_basis;
    use dpn_core::random::Stream;
    use nalgebra::Vector2;
    use rand_distr::{Distribution, StandardNormal};

    /// Natural logarithm of the frames' root mean square distance from their mean.
    fn log_spread(bundle: &Bundle) -> f64 {
        let positions: Vec<_> = bundle.state.poses.iter().map(|p| p.translation.vector).collect();
        let mean = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
        0.5 * positions.iter().map(|p| (p - mean).norm_squared()).sum::<f64>().ln()
    }

    #[test]
    fn deviations_are_those_of_noisy_copies() {
        let (mut exact, truth) = disturbed(4);
        exact.state = truth;
        exact.track_std = 1e-3;
        let covariance = Covariance::of(&exact).unwrap();
        let (mut scales, mut inverse_distances) = (Vec::new(), Vec::new());
        let mut rng = Stream::new(7).named("covariance-test").rng();
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        for _ in 0..COPIES {
            let mut copy = exact.clone();
            for (_, measured) in copy.views.iter_mut().flatten() {
                let off = tangent_basis(measured) * Vector2::new(normal(), normal()) * exact.track_std;
                *measured = (*measured + off).normalize();
            }
            for prior in &mut copy.priors {
                if let Prior::Distance { value, std, .. } = prior {
                    *value += normal() * *std;
                }
            }
            copy.solve(10);
            scales.push(log_spread(&copy) - log_spread(&exact));
            let found = copy.state.landmarks[5].inverse_distance;
            inverse_distances.push(found - exact.state.landmarks[5].inverse_distance);
        }
        // The deviation of a deviation from n samples is 1/sqrt(2 n), here 4 %; Cauchy's weights cost some per cent more.
        let sampled = |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / COPIES as f64).sqrt();
        for (name, said, values) in [
            ("scale", covariance.scale_std(&exact), &scales),
            ("inverse distance", covariance.inverse_distance_std(&exact, 5), &inverse_distances),
        ] {
            let ratio = sampled(values) / said;
            assert!((0.88..1.2).contains(&ratio), "{name}: sampled over said {ratio:.3}");
        }
    }

    /// Noisy copies.
    const COPIES: usize = 300;

    #[test]
    fn a_factor_moves_from_the_prior_to_what_the_rows_say_as_they_outweigh_it() {
        let none = Excess { squares: 0.0, redundancy: 0.0 };
        assert!((none.factor(1.0, 3.0, 6.0) - 3.0).abs() < 1e-12);
        let many = Excess { squares: 4e4, redundancy: 1e4 };
        // Twice as large as expected, where 1.5 times the noise was expected: three times the noise.
        assert!((many.factor(1.5, 1.0, 6.0) - 3.0).abs() < 1e-2);
    }
}
