//! The five coefficients of an Allan plot, how sure they are, and how long a log would show those that are not seen.
//!
//! The squares of the coefficients are fitted to the Allan variances by nonnegative least squares. A variance counts by what it scatters
//! under the model of the round before (`covariance`), and by `MODEL_ERROR` besides: no sensor follows five slopes to a tenth of a per
//! cent, a short time's many samples must not bend the rest, and nothing is called seen that is smaller. A log at rest often has a hump that is no noise at all, a machine or the
//! building swinging; times that stay far from every model lose their say (Cauchy weights, from wide to narrow) and are named.
//!
//! The fit is linear in the data, so the covariance of the Allan variances gives that of the squares; it is taken without the bounds at
//! zero, which errs on the side of caution, and widened where the model does not describe the data. A square's interval is found by
//! inversion: its scatter is that of the value it is held against, not of the estimate (`inversion`).

use super::chi;
use super::covariance::Scatter;
use super::deviation;
use super::inversion::Spread;
use super::model::{Coefficient, Squares, variance};
use super::nnls::{NnlsError, nnls};
use dpn_core::SampleRate;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Relative error of the model in an Allan variance: more samples make no time more certain than this.
const MODEL_ERROR: f64 = 0.02;
/// Scales of the Cauchy weights, a round of weighing and fitting each, in standard deviations of an Allan variance.
const SCALES: [f64; 12] = [100.0, 60.0, 40.0, 25.0, 16.0, 10.0, 6.0, 4.0, 3.0, 2.5, 2.5, 2.5];
/// An Allan variance this far above the model is part of a hump.
const HUMP: f64 = 1.3;

/// What is known of one coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Which.
    pub coefficient: Coefficient,
    /// The fitted value; 0 where the fit has no use for it.
    pub value: f64,
    /// Lower end of the 95 % interval; 0 where it is not seen.
    pub low: f64,
    /// Upper end of the 95 % interval; where it is not seen, what it stays below.
    pub high: f64,
    /// Whether the log shows it: its 95 % interval stays clear of 0.
    pub seen: bool,
    /// Length of a log that would show it \[s\]: one of the fitted size, or, where the fit has none, one of a third of `high`. Where it
    /// is seen already, and where a hundred times the length would not do, none.
    pub needs_s: Option<f64>,
}

/// One averaging time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// Averaging time \[s\].
    pub tau: f64,
    /// Overlapping Allan deviation, in the signal's unit.
    pub deviation: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// The fitted model's deviation.
    pub model: f64,
}

/// Times at which the plot lies above any model: something swings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hump {
    /// Averaging time of its peak \[s\].
    pub tau: f64,
    /// Deviation over the model's, there.
    pub times: f64,
    /// Frequency that peaks there: an Allan deviation of a sine does at .371 periods \[Hz\].
    pub hz: f64,
}

/// The Allan plot of one axis and what it says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    /// The plot, shortest time first.
    pub points: Vec<Point>,
    /// The coefficients, in the order of [`Coefficient::ALL`].
    pub estimates: [Estimate; 5],
    /// Root mean square of the distance between plot and model over what both scatter, humps weighed down; near 1 where the model
    /// describes the axis. Intervals are as much wider.
    pub misfit: f64,
    /// Where something swings.
    pub humps: Vec<Hump>,
}

impl Fit {
    /// One coefficient's estimate.
    pub fn of(&self, coefficient: Coefficient) -> Estimate {
        self.estimates[coefficient as usize]
    }
}

/// Covariances for logs of the given length and of longer ones; made once for all axes.
#[derive(Debug, Clone)]
pub struct Planner {
    rate: SampleRate,
    samples: usize,
    averages: Vec<usize>,
    now: Scatter,
    /// Longer logs: times as long, with fewer averages.
    later: Vec<(f64, Vec<usize>, Scatter)>,
}

impl Planner {
    /// For logs of `samples` at `rate`; at least 30 samples.
    pub fn new(samples: usize, rate: SampleRate) -> Self {
        let averages = deviation::averages(samples);
        let later = [3.0, 10.0, 30.0, 100.0].map(|times: f64| {
            let longer = (samples as f64 * times) as usize;
            // Three to a decade are enough to plan with.
            let averages: Vec<usize> = deviation::averages(longer).into_iter().rev().step_by(3).collect();
            let averages: Vec<usize> = averages.into_iter().rev().collect();
            let scatter = Scatter::new(&averages, longer, rate);
            (times, averages, scatter)
        });
        Self { rate, samples, now: Scatter::new(&averages, samples, rate), averages, later: later.to_vec() }
    }

    /// Fits one axis.
    ///
    /// # Errors
    /// A signal that never changes or has values that are not finite.
    ///
    /// # Panics
    /// When the signal is not as long as the planner was made for.
    pub fn fit(&self, signal: &[f64]) -> Result<Fit, NnlsError> {
        assert_eq!(signal.len(), self.samples, "a planner is for one length of log");
        let taus: Vec<f64> = self.averages.iter().map(|m| *m as f64 * self.rate.period()).collect();
        let variances = deviation::variances(signal, self.rate, &self.averages);
        let mut squares = rough(&taus, &variances)?;
        let mut weights = Vec::new();
        for scale in SCALES {
            weights = robust(&self.now.matrix(&squares), &squares, &taus, &variances, scale);
            squares = solve(&taus, &variances, &weights)?;
        }
        let matrix = self.now.matrix(&squares);
        let misfit = misfit(&matrix, &squares, &taus, &variances, &weights);
        let gains = gains(&taus, &weights);
        let widened = misfit.max(1.0);
        let estimates = Coefficient::ALL.map(|c| self.estimate(c, &squares, &gains[c as usize], widened));
        let points: Vec<Point> = (0..taus.len())
            .map(|i| {
                // Degrees of freedom are the model's: a variance that came out small has not fewer of them.
                let model = variance(&squares, taus[i]).max(f64::MIN_POSITIVE);
                let (low, high) = chi::interval(variances[i], variances[i] * matrix[i][i].sqrt() / model);
                Point {
                    tau: taus[i],
                    deviation: variances[i].sqrt(),
                    low: low.sqrt(),
                    high: high.sqrt(),
                    model: variance(&squares, taus[i]).sqrt(),
                }
            })
            .collect();
        Ok(Fit { humps: humps(&points), points, estimates, misfit })
    }

    fn estimate(&self, coefficient: Coefficient, squares: &Squares, gain: &[f64], widened: f64) -> Estimate {
        let square = squares[coefficient as usize];
        if gain.iter().all(|g| *g == 0.0) {
            let (value, low, high) = (square.sqrt(), 0.0, f64::INFINITY);
            return Estimate { coefficient, value, low, high, seen: false, needs_s: None };
        }
        let taus: Vec<f64> = self.averages.iter().map(|m| *m as f64 * self.rate.period()).collect();
        let spread = spread(&self.now, &taus, squares, coefficient, gain).times(widened * widened);
        let (low, high) = spread.interval(square);
        let seen = low > 0.0;
        let needs_s = if seen { None } else { self.needs(coefficient, squares, square, high, widened) };
        Estimate { coefficient, value: square.sqrt(), low: low.sqrt(), high: high.sqrt(), seen, needs_s }
    }

    /// The length at which a coefficient as large as the fitted one, or as a third of what it stays below, would be seen.
    fn needs(
        &self,
        coefficient: Coefficient,
        squares: &Squares,
        square: f64,
        high: f64,
        widened: f64,
    ) -> Option<f64> {
        // What an estimate of the wanted size is held against: the largest that an absent noise leaves.
        let least = |averages: &[usize], scatter: &Scatter| {
            let taus: Vec<f64> = averages.iter().map(|m| *m as f64 * self.rate.period()).collect();
            let weights = weights(&scatter.matrix(squares), squares, &taus);
            let gain = &gains(&taus, &weights)[coefficient as usize];
            spread(scatter, &taus, squares, coefficient, gain).times(widened * widened).least_seen()
        };
        let length = self.samples as f64 * self.rate.period();
        let mut before = (1.0, least(&self.averages, &self.now));
        // The bound of a few degrees of freedom is wide: a third of it may be more than this log would have shown.
        let wanted = square.max((high / 9.0).min(0.5 * before.1));
        for (times, averages, scatter) in &self.later {
            let now = (*times, least(averages, scatter));
            if now.1 <= wanted {
                // Between two lengths errors fall as a power.
                let share = ((before.1 / wanted).ln() / (before.1 / now.1).ln()).clamp(0.0, 1.0);
                return Some(length * (before.0 * (now.0 / before.0).powf(share)).max(1.0));
            }
            before = now;
        }
        None
    }
}

/// A first guess, every variance to the same relative error.
fn rough(taus: &[f64], variances: &[f64]) -> Result<Squares, NnlsError> {
    let weights: Vec<f64> = variances.iter().map(|v| 1.0 / (v * v).max(f64::MIN_POSITIVE)).collect();
    solve(taus, variances, &weights)
}

fn weights(matrix: &[Vec<f64>], squares: &Squares, taus: &[f64]) -> Vec<f64> {
    let scatter = (0..taus.len()).map(|i| matrix[i][i] + (MODEL_ERROR * variance(squares, taus[i])).powi(2));
    scatter.map(|v| 1.0 / v.max(f64::MIN_POSITIVE)).collect()
}

/// The covariance of Allan variances, the model's own error on its diagonal.
fn with_model_error(matrix: &[Vec<f64>], squares: &Squares, taus: &[f64]) -> Vec<Vec<f64>> {
    let mut total = matrix.to_vec();
    for (i, tau) in taus.iter().enumerate() {
        total[i][i] += (MODEL_ERROR * variance(squares, *tau)).powi(2);
    }
    total
}

/// The same, times that are far from the model weighed down. How far is counted on the scale on which a chi-squared variable is nearly
/// normal, by Wilson and Hilferty: at a long time, with a few degrees of freedom, a large variance is no outlier.
fn robust(matrix: &[Vec<f64>], squares: &Squares, taus: &[f64], variances: &[f64], scale: f64) -> Vec<f64> {
    let weights = weights(matrix, squares, taus);
    let far = |i: usize| {
        let model = variance(squares, taus[i]).max(f64::MIN_POSITIVE);
        let freedom = (2.0 * weights[i] * model * model).max(0.5);
        let part = 2.0 / (9.0 * freedom);
        ((variances[i] / model).cbrt() - (1.0 - part)) / part.sqrt()
    };
    (0..taus.len()).map(|i| weights[i] / (1.0 + (far(i) / scale).powi(2))).collect()
}

/// Root mean square of residuals over their scatter, each time counting as much as it did in the fit.
fn misfit(matrix: &[Vec<f64>], squares: &Squares, taus: &[f64], variances: &[f64], used: &[f64]) -> f64 {
    let (mut sum, mut say) = (0.0, 0.0);
    for (i, full) in weights(matrix, squares, taus).into_iter().enumerate() {
        sum += used[i] * (variances[i] - variance(squares, taus[i])).powi(2);
        say += used[i] / full;
    }
    (sum / say.max(f64::MIN_POSITIVE)).sqrt()
}

/// Peaks of the stretches that lie above the model by more than they scatter.
fn humps(points: &[Point]) -> Vec<Hump> {
    let above = |p: &Point| p.low > p.model && p.deviation > HUMP.sqrt() * p.model;
    let ratio = |p: &Point| p.deviation / p.model;
    let mut humps = Vec::new();
    for stretch in points.chunk_by(|a, b| above(a) == above(b)) {
        let peak = stretch.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        if let Some(peak) = peak.filter(|p| above(p)) {
            humps.push(Hump { tau: peak.tau, times: ratio(peak), hz: 0.371 / peak.tau });
        }
    }
    humps
}

fn solve(taus: &[f64], variances: &[f64], weights: &[f64]) -> Result<Squares, NnlsError> {
    let a = DMatrix::from_fn(taus.len(), 5, |i, k| weights[i].sqrt() * Coefficient::ALL[k].variance(taus[i]));
    let b = DVector::from_fn(taus.len(), |i, _| weights[i].sqrt() * variances[i]);
    let x = nnls(&a, &b)?;
    Ok([x[0], x[1], x[2], x[3], x[4]])
}

/// The squares as linear functions of the Allan variances: a row a coefficient; all zero where the times cannot tell them apart.
fn gains(taus: &[f64], weights: &[f64]) -> Vec<Vec<f64>> {
    let n = taus.len();
    let root = DMatrix::from_fn(n, 5, |i, k| weights[i].sqrt() * Coefficient::ALL[k].variance(taus[i]));
    let lengths: Vec<f64> = (0..5).map(|k| root.column(k).norm()).collect();
    let scaled = DMatrix::from_fn(n, 5, |i, k| root[(i, k)] / lengths[k]);
    let Ok(inverse) = scaled.pseudo_inverse(1e-12) else {
        return vec![vec![0.0; n]; 5];
    };
    (0..5).map(|k| (0..n).map(|i| inverse[(k, i)] * weights[i].sqrt() / lengths[k]).collect()).collect()
}

/// How the square of `coefficient` scatters, by its true size, beside the others as fitted.
fn spread(
    scatter: &Scatter,
    taus: &[f64],
    squares: &Squares,
    coefficient: Coefficient,
    gain: &[f64],
) -> Spread {
    let variance_at = |truth: f64| {
        let mut squares = *squares;
        squares[coefficient as usize] = truth;
        let matrix = with_model_error(&scatter.matrix(&squares), &squares, taus);
        let rows = matrix.iter().zip(gain);
        rows.map(|(row, a)| a * row.iter().zip(gain).map(|(v, b)| v * b).sum::<f64>()).sum::<f64>()
    };
    // Any scale will do for a parabola; one at which all three terms count is kindest to rounding.
    let zero = variance_at(0.0);
    let at = squares[coefficient as usize].max(zero.max(0.0).sqrt()).max(f64::MIN_POSITIVE);
    Spread::through(at, [zero, variance_at(at), variance_at(2.0 * at)])
}
