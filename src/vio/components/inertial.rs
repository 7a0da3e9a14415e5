//! What the interval that leaves the window says of its components; the formulas stand at the head of [`super`].

use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::preint::{COMPONENTS, NoiseLevels};
use crate::state::STATE_DIM;
use crate::window::Window;
use nalgebra::{SMatrix, SVector};

/// Derivative and expected curvature of the restricted likelihood by the logarithms of the variances.
#[derive(Debug, Clone)]
pub(super) struct InertialScore {
    pub(super) gradient: SVector<f64, COMPONENTS>,
    pub(super) information: SMatrix<f64, COMPONENTS, COMPONENTS>,
    /// The levels that the interval was weighed with.
    pub(super) at: NoiseLevels,
}

impl Window {
    /// Of the oldest interval, at the present states; `None` while nothing moves (a rest's pseudo-measurements know no noise), or where the last
    /// step was damped: the factor is then no covariance.
    pub(super) fn oldest_inertial_score(&self) -> Option<InertialScore> {
        let [first, second, ..] = self.frames.as_slice() else { return None };
        if first.rest.is_some() || second.rest.is_some() || !self.factor_is_posterior {
            return None;
        }
        let preint = second.preint.as_ref()?;
        let root = sqrt_information(preint)?;
        let (residual, d_0, d_1) = inertial_jacobians(preint, &first.state, &second.state);
        let (d_0, d_1) = (root * d_0, root * d_1);
        let explained = self.covariance_along([(0, &d_0), (1, &d_1)]);
        Some(score(&(root * residual), &explained, &preint.components().map(|q| root * q * root.transpose()), preint.levels()))
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
    let gradient =
        SVector::from_fn(|k, _| 0.5 * (residual.dot(&(parts[k] * residual)) - shares[k].trace()));
    let information = SMatrix::from_fn(|k, l| {
        // tr(A B): rows of one with columns of the other.
        0.5 * shares[k].component_mul(&shares[l].transpose()).sum()
    });
    InertialScore { gradient, information, at: *at }
}
