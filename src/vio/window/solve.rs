//! Levenberg-Marquardt on the window: steps over the states, depths following each.

use super::landmark::MIN_INVERSE_DEPTH;
use super::layout::Layout;
use super::linearisation::Linearisation;
use super::normal::Factor;
use super::part::Part;
use super::window::Window;
use crate::state::{NavState, POSE_DIM, STATE_DIM, pose_plus};
use nalgebra::{DMatrix, Isometry3, Matrix6, SVector};

/// The first damping after a step that failed; steps begin as Gauss-Newton's, as each frame begins close to its solution.
const FIRST_DAMPING: f64 = 1e-2;
/// Damping beyond which there is no step worth taking.
const LAST_DAMPING: f64 = 1e6;

/// How far a state's unknowns go in a damped step [m, rad, m/s, m/s^2, rad/s]. A share of the diagonal, the usual choice, would hold
/// the biases: their walk ties neighbours so firmly that a millionth of it outweighs all that is known of their level.
const REACH: [f64; 5] = [1.0, 0.1, 1.0, 0.3, 0.03];

/// Why the solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The last step lowered the cost by less than the tolerance, or was expected to.
    Converged,
    /// The budget of iterations was used up.
    Budget,
    /// No step lowers the cost.
    Stuck,
}

/// What the solver did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Linear systems solved.
    pub iterations: usize,
    /// Cost before; a constant of the prior is left out.
    pub first_cost: f64,
    /// Cost after; where the last step was too small to be looked at, what its equations expect.
    pub last_cost: f64,
    /// Why it stopped.
    pub stop: Stop,
}

/// One over the square of each unknown's reach.
fn damping_places(layout: &Layout) -> Vec<f64> {
    // Camera and clock are near what they are from the start.
    let mut places = vec![1.0 / (0.01 * 0.01); layout.dim()];
    for frame in 0..layout.frames {
        for k in 0..STATE_DIM {
            let reach = REACH[k / 3];
            places[layout.state(frame, k)] = 1.0 / (reach * reach);
        }
    }
    places
}

/// All unknowns, to go back to.
struct Snapshot {
    states: Vec<NavState>,
    depths: Vec<Option<f64>>,
    camera: Isometry3<f64>,
    offset: f64,
}

impl Window {
    /// Moves states and depths to the least cost.
    pub fn optimise(&mut self) -> Solved {
        let layout = self.layout();
        let mut at = std::mem::take(&mut self.scratch);
        let mut factor = std::mem::take(&mut self.factor);
        let mut damping = 0.0;
        let extra = damping_places(&layout);
        at.compute(self, &layout, Part::All, damping);
        let first_cost = at.cost;
        let mut solved = Solved { iterations: 0, first_cost, last_cost: first_cost, stop: Stop::Budget };
        let mut step = Vec::new();
        while solved.iterations < self.config.max_iterations {
            solved.iterations += 1;
            let before = self.snapshot();
            let mut lowered = false;
            let factored = at.normal.factor(|k| damping * extra[k], &mut factor).is_ok();
            self.factor_is_posterior = factored && damping == 0.0;
            if factored {
                step.clear();
                step.extend_from_slice(at.normal.gradient());
                factor.solve_negated(&mut step);
                if step.iter().all(|v| v.is_finite()) {
                    self.apply(&at, &step);
                    // A step that is expected to lower the cost by less than the tolerance is the last; looking whether it did costs as much as a step.
                    let expected = at.expected_gain(&step);
                    if damping == 0.0 && expected <= self.config.cost_tolerance * at.cost.abs().max(1.0) {
                        solved.last_cost -= expected;
                        solved.stop = Stop::Converged;
                        break;
                    }
                    at.compute(self, &layout, Part::All, damping);
                    lowered = at.cost <= solved.last_cost;
                }
            }
            if lowered {
                let gain = solved.last_cost - at.cost;
                solved.last_cost = at.cost;
                damping = if damping > FIRST_DAMPING { damping * 0.1 } else { 0.0 };
                if gain <= self.config.cost_tolerance * at.cost.abs().max(1.0) {
                    solved.stop = Stop::Converged;
                    break;
                }
            } else {
                self.restore(before);
                damping = (damping * 100.0).max(FIRST_DAMPING);
                if damping > LAST_DAMPING {
                    solved.stop = Stop::Stuck;
                    break;
                }
                at.compute(self, &layout, Part::All, damping);
            }
        }
        self.scratch = at;
        self.factor = factor;
        solved
    }

    /// Takes `steps` Gauss-Newton steps from near the least cost, whatever the cost says of each, but goes back where it rose by more
    /// than a hundredth in all.
    ///
    /// Each linearisation weighs sightings and hosts' pixels anew: where that settles, the cost is least only to within what this
    /// changes, and [`Self::optimise`] stops there. Weakly observed directions, as the scale of a short flight, go on for long after.
    pub(crate) fn settle(&mut self, steps: usize) {
        let layout = self.layout();
        let (mut at, mut factor, before) = (Linearisation::default(), Factor::default(), self.snapshot());
        at.compute(self, &layout, Part::All, 0.0);
        let first_cost = at.cost;
        for _ in 0..steps {
            let mut step = at.normal.gradient().to_vec();
            if at.normal.factor(|_| 0.0, &mut factor).is_err() {
                break;
            }
            factor.solve_negated(&mut step);
            self.apply(&at, &step);
            at.compute(self, &layout, Part::All, 0.0);
        }
        if at.cost.is_nan() || at.cost > first_cost + 0.01 * first_cost.abs().max(1.0) {
            self.restore(before);
        }
    }

    /// Sees to it that the factor is that of the window's information: the last step may have been damped. Returns whether there is one.
    pub(crate) fn factor_information(&mut self) -> bool {
        self.factor_is_posterior || self.factor_anew()
    }

    /// Factors the information at the present states, undamped. Returns whether there is a factor.
    fn factor_anew(&mut self) -> bool {
        let layout = self.layout();
        let mut at = std::mem::take(&mut self.scratch);
        let mut factor = std::mem::take(&mut self.factor);
        at.compute(self, &layout, Part::All, 0.0);
        self.factor_is_posterior = at.normal.factor(|_| 0.0, &mut factor).is_ok();
        self.scratch = at;
        self.factor = factor;
        self.factor_is_posterior
    }

    /// Covariance of the newest frame's pose, position then rotation on the right, as the window believes it; `None` where it does
    /// not know.
    pub(crate) fn newest_pose_covariance(&mut self) -> Option<Matrix6<f64>> {
        if !self.factor_anew() {
            return None;
        }
        let inverse = self.factor.last_corner::<POSE_DIM>().solve_lower_triangular(&Matrix6::identity())?;
        Some(inverse.transpose() * inverse)
    }

    /// Covariance of all unknowns but the landmarks', in the places of [`Window::layout`]; `None` where something is not known at all.
    pub(crate) fn covariance(&self) -> Option<DMatrix<f64>> {
        let layout = self.layout();
        let (mut at, mut factor) = (Linearisation::default(), Factor::default());
        at.compute(self, &layout, Part::All, 0.0);
        at.normal.factor(|_| 0.0, &mut factor).ok()?;
        let mut covariance = -DMatrix::<f64>::identity(layout.dim(), layout.dim());
        covariance
            .as_mut_slice()
            .chunks_exact_mut(layout.dim())
            .for_each(|column| factor.solve_negated(column));
        covariance.iter().all(|x| x.is_finite()).then_some(covariance)
    }

    pub(crate) fn apply(&mut self, at: &Linearisation, step: &[f64]) {
        let layout = self.layout();
        for (frame, f) in self.frames.iter_mut().enumerate() {
            let d = SVector::<f64, STATE_DIM>::from_fn(|k, _| step[layout.state(frame, k)]);
            f.state = f.state.plus(&d);
        }
        if let Some(camera) = layout.camera() {
            let d = SVector::<f64, POSE_DIM>::from_fn(|k, _| step[camera + k]);
            self.body_from_cam = pose_plus(&self.body_from_cam, &d);
        }
        if let Some(offset) = layout.offset() {
            self.time_offset += step[offset];
        }
        for (landmark, d) in at.depth_steps(step) {
            if let Some(inverse_depth) = &mut self.landmarks[landmark].inverse_depth {
                *inverse_depth = (*inverse_depth + d).max(MIN_INVERSE_DEPTH);
            }
        }
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            states: self.frames.iter().map(|f| f.state).collect(),
            depths: self.landmarks.iter().map(|l| l.inverse_depth).collect(),
            camera: self.body_from_cam,
            offset: self.time_offset,
        }
    }

    fn restore(&mut self, to: Snapshot) {
        for (frame, state) in self.frames.iter_mut().zip(to.states) {
            frame.state = state;
        }
        for (landmark, depth) in self.landmarks.iter_mut().zip(to.depths) {
            landmark.inverse_depth = depth;
        }
        self.body_from_cam = to.camera;
        self.time_offset = to.offset;
    }
}
