//! What the samples that leave the window say of its components; the formulas stand at the head of [`super`].

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
    /// Of the samples from the oldest frame to frame `last`, at the present states; `None` while nothing moves (a rest's pseudo-measurements know no
    /// noise), or where the last step was damped: the factor is then no covariance.
    pub(super) fn inertial_score(&self, last: usize) -> Option<InertialScore> {
        let span = self.frames.get(..=last)?;
        if span.iter().any(|frame| frame.rest.is_some()) || !self.factor_is_posterior {
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
