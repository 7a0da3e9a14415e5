//! The loop: Gauss-Newton steps, and between them the levels by their variance components.

use crate::chain::ChainCovariance;
use crate::components::{Found, Levels, Pace};
use crate::error::TruthError;
use crate::layout::{CONSTANTS, KEY_DIM};
use crate::problem::{Estimate, Problem};
use dpn_vio::state::{POSITION, ROTATION};

/// Steps before the levels are looked at: the first ones bring poses and frames together.
const FIRST_STEPS: usize = 3;
/// The levels stand when none changes by more than this share,
const LEVELS_STAND: f64 = 0.03;
/// or, where they are what is asked for, by more than this,
const AXES_STAND: f64 = 0.005;
/// and the estimate when no key moves by more than this \[m, rad\].
const POSE_STANDS: f64 = 1e-4;

/// An adjustment that came to rest, or ran out of iterations.
#[derive(Debug)]
pub(crate) struct Adjusted {
    /// The estimate.
    pub(crate) estimate: Estimate,
    /// The levels.
    pub(crate) levels: Levels,
    /// The last adjustment's word on them.
    pub(crate) found: Found,
    /// Of the estimate.
    pub(crate) covariance: ChainCovariance<KEY_DIM, CONSTANTS>,
    /// Adjustments made.
    pub(crate) iterations: usize,
    /// Whether it came to rest.
    pub(crate) settled: bool,
}

/// Adjusts `estimate` until it and the levels stand.
///
/// # Errors
/// A matrix that is singular.
pub(crate) fn adjust(
    problem: &Problem<'_>,
    mut estimate: Estimate,
    mut levels: Levels,
    most_iterations: usize,
) -> Result<Adjusted, TruthError> {
    let singular = |k: Option<usize>, estimate: &Estimate| {
        let seconds = |k: usize| {
            let sample = &problem.samples[estimate.keys[k].sample];
            sample.t.seconds_since(problem.samples[0].t)
        };
        TruthError::Singular { seconds: k.map(seconds) }
    };
    let mut iterations = 0;
    let mut pace = Pace::default();
    loop {
        let chain = problem.linearise(&estimate, &levels);
        let factor = chain.factor().map_err(|at| singular(at.key, &estimate))?;
        let (steps, constants) = factor.solve(&chain);
        let mut moved = 0.0_f64;
        for (key, step) in estimate.keys.iter_mut().zip(&steps) {
            *key = key.plus(step);
            moved =
                moved.max(step.fixed_rows::<3>(POSITION).norm()).max(step.fixed_rows::<3>(ROTATION).norm());
        }
        estimate.frames = estimate.frames.plus(&constants);
        iterations += 1;
        if !moved.is_finite() {
            return Err(singular(None, &estimate));
        }
        if iterations < FIRST_STEPS {
            continue;
        }
        // The factor is of the point before the step, which by now is the same but for rounding.
        let covariance = factor.covariance();
        let found = problem.found(&estimate, &levels, &covariance);
        let (next, change) = levels.updated(&found, problem.ceilings, problem.by_axis, &mut pace);
        let stand = if problem.by_axis.is_some() { AXES_STAND } else { LEVELS_STAND };
        let settled = change < stand && moved < POSE_STANDS;
        if settled || iterations >= most_iterations {
            return Ok(Adjusted { estimate, levels, found, covariance, iterations, settled });
        }
        levels = next;
    }
}
