//! A gyroscope's bias in motion: what must be taken off so that gravity, turned back by the gyroscope, stays where it is.
//!
//! Of the windows in which gravity turns in the sensor's axes (`turned`), the constant rate is sought with which directions spread least, by Gauss and Newton.
//! Along gravity a bias turns nothing, so what is found there is held near zero. It is named where it leaves less than half of the spread, little of the
//! spread in the sensor's axes, and where every other window says the same.

use super::turned::{EXPLAINED, FEWEST, Step, WINDOW_S, WORSE, directions, spread, still};
use crate::finding::Finding;
use nalgebra::{Matrix3, Vector3};

const REMEDY: &str = "take it off before an estimator is fed: calibrate the gyroscope at rest, and look at its temperature and at the driver's offsets";
/// A bias from which it is one \[rad/s\], as at rest.
const LARGE: f64 = 0.2;
/// How far every other window's may be from the rest's, relative.
const APART: f64 = 0.25;
/// Weight of a window's word against zero: what a bias across gravity changes in it counts for some thirty.
const PRIOR: f64 = 0.3;

/// What turns the force's direction from step to step that the gyroscope does not say, as a least-squares problem for a bias.
#[derive(Default)]
struct Unsaid {
    across: Matrix3<f64>,
    turns: Vector3<f64>,
    count: f64,
}

impl Unsaid {
    fn add(&mut self, a: &Step, b: &Step) {
        let middle = (a.force.normalize() + b.force.normalize()).normalize();
        let turned = (b.force.normalize() - a.force.normalize()) / (b.t_s - a.t_s);
        let rate = turned + (0.5 * (a.gyro + b.gyro)).cross(&middle);
        if rate.iter().all(|v| v.is_finite()) {
            // d/dt u = -(w - b) x u: what is left over is b x u.
            self.across += Matrix3::identity() - middle * middle.transpose();
            self.turns += middle.cross(&rate);
            self.count += 1.0;
        }
    }

    /// The bias, held near zero along gravity \[rad/s\].
    fn bias(&self) -> Vector3<f64> {
        /// Weight against zero of a step's word.
        const OF_STEP: f64 = 0.01;
        let normal = self.across + Matrix3::identity() * (OF_STEP * self.count + 1e-9);
        normal.cholesky().map_or(Vector3::zeros(), |normal| normal.solve(&self.turns))
    }
}

/// The constant rate with which directions spread least, sought from `bias` on \[rad/s\].
fn fit(windows: &[&Vec<Step>], mut bias: Vector3<f64>) -> Vector3<f64> {
    /// Rate by which derivatives are taken \[rad/s\].
    const SMALL: f64 = 1e-4;
    let count = windows.len() as f64;
    for _ in 0..10 {
        let (mut normal, mut side) = (Matrix3::identity() * PRIOR * count, -PRIOR * count * bias);
        for window in windows {
            let of = |bias: Vector3<f64>| {
                let all: Vec<Vector3<f64>> = directions(window, |rate| rate - bias).collect();
                let mean = all.iter().sum::<Vector3<f64>>() / all.len() as f64;
                all.into_iter().map(move |one| one - mean).collect::<Vec<_>>()
            };
            let now = of(bias);
            let moved: [Vec<Vector3<f64>>; 3] =
                std::array::from_fn(|axis| of(bias + SMALL * Vector3::ith(axis, 1.0)));
            for (i, now) in now.iter().enumerate() {
                let slope = Matrix3::from_columns(&[0, 1, 2].map(|axis| (moved[axis][i] - now) / SMALL));
                normal += slope.transpose() * slope;
                side -= slope.transpose() * now;
            }
        }
        let Some(step) = normal.cholesky().map(|normal| normal.solve(&side)) else { break };
        bias += step;
        if step.norm() < 1e-5 {
            break;
        }
    }
    bias
}

/// What is to be said, from windows in which gravity turns.
pub(super) fn finding(windows: &[Vec<Step>]) -> Option<Finding> {
    let mut unsaid = Unsaid::default();
    windows.iter().flat_map(|window| window.windows(2)).for_each(|pair| unsaid.add(&pair[0], &pair[1]));
    let guess = unsaid.bias();
    if windows.len() < FEWEST || guess.norm() < 0.5 * LARGE {
        return None;
    }
    let sum = |of: &dyn Fn(&[Step]) -> f64| windows.iter().map(|window| of(window)).sum::<f64>();
    let all: Vec<&Vec<Step>> = windows.iter().collect();
    let bias = fit(&all, guess);
    let left = |bias: Vector3<f64>| sum(&|window| spread(window, |rate| rate - bias));
    let (own, as_read, without) = (sum(&|window| still(window)), left(Vector3::zeros()), left(bias));
    let half = |first: usize| all.iter().copied().skip(first).step_by(2).collect::<Vec<_>>();
    let halves = || [0, 1].map(|first| fit(&half(first), bias));
    let is_so = bias.norm() > LARGE
        && without < EXPLAINED * own
        && as_read > WORSE * without
        && halves().iter().all(|half| (half - bias).norm() < APART * bias.norm());
    is_so.then(|| {
        let text = format!(
            "gravity does not turn as the gyroscope says, in {} stretches of {WINDOW_S:.0} s; it does with a bias of x {:.3}, y {:.3}, z {:.3} rad/s taken off",
            windows.len(),
            bias.x,
            bias.y,
            bias.z
        );
        Finding::bad("bias", text, REMEDY)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::turned::tests::waved;
    use crate::doctor::turned::windows;

    #[test]
    fn a_bias_in_motion_is_found_with_its_figures_and_a_small_one_or_a_swapped_axis_is_none() {
        let of = |bias: [f64; 3]| {
            let biased = waved(|s| (0..3).for_each(|axis| s.gyro[axis] += bias[axis]));
            let windows = windows(&biased).unwrap();
            (fit(&windows.iter().collect::<Vec<_>>(), Vector3::zeros()), finding(&windows))
        };
        for bias in [[0.5, 0.0, 0.0], [0.0, -0.3, 0.2], [0.1, 0.2, 1.0]] {
            let (found, said) = of(bias);
            assert!((found - Vector3::from(bias)).norm() < 0.05, "{found:?}");
            assert!(said.is_some(), "{bias:?}");
        }
        assert_eq!(of([0.0, 0.05, 0.0]).1, None);
        assert_eq!(finding(&windows(&waved(|s| s.gyro.swap(0, 2))).unwrap()), None);
    }
}
