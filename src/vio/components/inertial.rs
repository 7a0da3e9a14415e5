//! What the samples that leave the window say of its components; the formulas stand at the head of [`super`].

use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::preint::{COMPONENTS, NoiseLevels};
use crate::state::{ACCEL_BIAS, GYRO_BIAS, STATE_DIM};
use crate::window::Window;
use nalgebra::{SMatrix, SVector, Vector3};

/// The square of a change of the bias is so many times its variance where it is told from none.
const KNOWN: f64 = 9.0;

/// Derivative and expected curvature of the restricted likelihood by the logarithms of the variances.
#[derive(Debug, Clone)]
pub(super) struct InertialScore {
    pub(super) gradient: SVector<f64, COMPONENTS>,
    pub(super) information: SMatrix<f64, COMPONENTS, COMPONENTS>,
    /// The levels that the interval was weighed with.
    pub(super) at: NoiseLevels,
}

impl Window {
    /// Of the samples from the oldest frame to frame `last`, at the present states; `None` while nothing moves (a rest's pseudo-measurements know no
    /// noise). The window's factor is its information's.
    pub(super) fn inertial_score(&self, last: usize) -> Option<InertialScore> {
        let span = self.frames.get(..=last)?;
        if span.iter().any(|frame| frame.rest.is_some()) {
            return None;
        }
        let mut preint = span.get(1)?.preint.clone()?;
        for frame in &span[2..] {
            preint.append(frame.preint.as_ref()?);
        }
        let root = sqrt_information(&preint)?;
        let (residual, d_i, d_j) = inertial_jacobians(&preint, &span[0].state, &span[last].state);
        let (d_i, d_j) = (root * d_i, root * d_j);
        let explained = self.covariance_along([(0, &d_i), (last, &d_j)]);
        let parts = preint.components().map(|part| root * part * root.transpose());
        Some(score(&(root * residual), &explained, &parts, preint.levels()))
    }

    /// By how much each sensor's bias jumped in the interval that ends at frame `k`; `None` for one whose change is no larger than what is not known of
    /// it, and for all where no jump was found.
    pub(super) fn known_jump(&self, k: usize) -> Option<[Option<Vector3<f64>>; 2]> {
        let preint = self.frames.get(k)?.preint.as_ref()?;
        if preint.jump() == [0.0; 2] {
            return None;
        }
        let mut by_bias = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
        by_bias.fixed_view_mut::<6, 6>(ACCEL_BIAS, ACCEL_BIAS).fill_with_identity();
        let covariance = self.covariance_along([(k - 1, &-by_bias), (k, &by_bias)]);
        let change = self.bias_change(k);
        let known = |first: usize, change: Vector3<f64>| {
            let unknown = covariance.fixed_view::<3, 3>(first, first).trace();
            (change.norm_squared() > KNOWN * unknown).then_some(change)
        };
        Some([known(ACCEL_BIAS, change.accel), known(GYRO_BIAS, change.gyro)])
    }

    /// `J H^-1 J^T` of rows that two frames' states enter.
    fn covariance_along(
        &self,
        jacobians: [(usize, &SMatrix<f64, STATE_DIM, STATE_DIM>); 2],
    ) -> SMatrix<f64, STATE_DIM, STATE_DIM> {
        let layout = self.layout();
        let dim = layout.dim();
        let from = jacobians.iter().map(|(frame, _)| layout.motion(*frame)).min().unwrap_or(0);
        let mut columns = vec![0.0; STATE_DIM * dim];
        for (row, column) in columns.chunks_exact_mut(dim).enumerate() {
            for (frame, jacobian) in &jacobians {
                for k in 0..STATE_DIM {
                    column[layout.state(*frame, k)] = jacobian[(row, k)];
                }
            }
            self.factor.solve_lower(column, from);
        }
        let column = |r: usize| &columns[r * dim + from..(r + 1) * dim];
        let mut product = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
        for r in 0..STATE_DIM {
            for c in 0..=r {
                let sum = column(r).iter().zip(column(c)).map(|(a, b)| a * b).sum();
                product[(r, c)] = sum;
                product[(c, r)] = sum;
            }
        }
        product
    }
}

/// From the whitened residual, the share of its covariance that the states take up, and the whitened components.
fn score(
    residual: &SVector<f64, STATE_DIM>,
    explained: &SMatrix<f64, STATE_DIM, STATE_DIM>,
    parts: &[SMatrix<f64, STATE_DIM, STATE_DIM>; COMPONENTS],
    at: &NoiseLevels,
) -> InertialScore {
    let left = SMatrix::<f64, STATE_DIM, STATE_DIM>::identity() - explained;
    let shares = parts.map(|part| left * part);
    let gradient = SVector::from_fn(|k, _| 0.5 * (residual.dot(&(parts[k] * residual)) - shares[k].trace()));
    let information = SMatrix::from_fn(|k, l| {
        // tr(A B): rows of one with columns of the other.
        0.5 * shares[k].component_mul(&shares[l].transpose()).sum()
    });
    InertialScore { gradient, information, at: *at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preint::PreintegrationConfig;
    use crate::preint::testing::{integrate, lively, random_bias, rng};
    use crate::window::normal::{Factor, Normal};
    use nalgebra::DMatrix;

    /// The restricted log likelihood of whitened rows with Jacobian `j` and prior information `prior` on the states, where each component's
    /// variance is `e^x` times itself; by dense algebra, nothing of the module under test.
    fn log_likelihood(
        parts: &[SMatrix<f64, STATE_DIM, STATE_DIM>],
        x: &[f64],
        j: &DMatrix<f64>,
        prior: &DMatrix<f64>,
        observed: &SVector<f64, STATE_DIM>,
    ) -> f64 {
        let mut q = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
        for (part, x) in parts.iter().zip(x) {
            q += part * x.exp();
        }
        // States integrated out: the rows' covariance is Q + J prior^-1 J^T.
        let cov = DMatrix::from_fn(STATE_DIM, STATE_DIM, |r, c| q[(r, c)])
            + j * prior.clone().try_inverse().unwrap() * j.transpose();
        let factor = cov.cholesky().unwrap();
        let y = nalgebra::DVector::from_column_slice(observed.as_slice());
        let log_det: f64 = factor.l().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
        -0.5 * (log_det + y.dot(&factor.solve(&y)))
    }

    #[test]
    fn the_score_is_the_derivative_of_the_restricted_likelihood() {
        let mut rng = rng("score", 1);
        let samples = lively(&mut rng, 200.0, 40, true);
        let preint = integrate(PreintegrationConfig::default(), random_bias(&mut rng), &samples);
        let root = sqrt_information(&preint).unwrap();
        let parts = preint.components().map(|part| root * part * root.transpose());
        let mut random = || rand::Rng::random_range(&mut rng, -1.0..1.0);
        let j = DMatrix::from_fn(STATE_DIM, STATE_DIM, |_, _| random());
        let prior = DMatrix::<f64>::identity(STATE_DIM, STATE_DIM) * 2.0;
        let observed = SVector::<f64, STATE_DIM>::from_fn(|_, _| 3.0 * random());
        // Posterior of the states with whitened rows (covariance 1) and the prior; residual y - J x.
        let information = &prior + j.transpose() * &j;
        let covariance = information.try_inverse().unwrap();
        let y = nalgebra::DVector::from_column_slice(observed.as_slice());
        let left = &y - &j * &covariance * j.transpose() * &y;
        let explained = &j * &covariance * j.transpose();
        let found = score(
            &SVector::from_column_slice(left.as_slice()),
            &SMatrix::from_fn(|r, c| explained[(r, c)]),
            &parts,
            preint.levels(),
        );
        for k in 0..COMPONENTS {
            let at = |d: f64| {
                let mut x = [0.0; COMPONENTS];
                x[k] = d;
                log_likelihood(&parts, &x, &j, &prior, &observed)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((found.gradient[k] - slope).abs() < 1e-6, "{k}: {} for {slope}", found.gradient[k]);
        }
        // All components at once are a scale of the whole: their shares are the redundancy, twice the curvature of its logarithm.
        let left = SMatrix::<f64, STATE_DIM, STATE_DIM>::identity()
            - SMatrix::<f64, STATE_DIM, STATE_DIM>::from_fn(|r, c| explained[(r, c)]);
        assert!((found.information.sum() - 0.5 * (left * left).trace()).abs() < 1e-9);
    }

    #[test]
    fn solving_by_the_lower_factor_skips_what_is_zero() {
        let mut normal = Normal::zeros(6);
        for r in 0..6 {
            normal.add(r, r, 5.0 + r as f64);
            for c in (if r == 5 { 3 } else { 0 })..r {
                normal.add(r, c, 0.3 * (r + c) as f64 - 1.0);
            }
        }
        let mut factor = Factor::default();
        normal.factor(|_| 0.0, &mut factor).unwrap();
        let mut x = [0.0, 0.0, 1.0, -2.0, 0.5, 3.0];
        let b = x;
        factor.solve_lower(&mut x, 2);
        for (r, b) in b.iter().enumerate() {
            let product: f64 = (0..=r).map(|c| factor.at(r, c) * x[c]).sum();
            assert!((product - b).abs() < 1e-12, "{r}");
        }
    }
}
