//! The loss of a batch and its derivatives with respect to the network's answers.
//!
//! With an answer s, a label l and n windows:
//! * `mse`: mean of e^2, e = (s - l) / unit;
//! * `log-mse`: mean of e^2, e = ln max(s, floor) - ln l;
//! * `log-nll`: mean of e^2 / (2 d^2) + ln d, e = ln s - ln l, d the deviation of ln s that the network says of itself.
//!
//! Derivatives are in single precision, as the network is.

use crate::config::Loss;

/// The mean loss and its derivatives.
///
/// # Shapes
/// `answers` and what is returned: `[batch, outputs]`, two outputs for [`Loss::LogNll`] and else one; `labels`: `[batch]`.
///
/// # Units and frames
/// Labels and each window's first answer in the sensor's unit; `scale` is the network's output scale, in the same.
pub(crate) fn loss(loss: Loss, scale: f64, answers: &[f32], labels: &[f32]) -> (f64, Vec<f32>) {
    let share = (1.0 / labels.len() as f64) as f32;
    let outputs = if loss == Loss::LogNll { 2 } else { 1 };
    let mut derivatives = Vec::with_capacity(answers.len());
    let mut sum = 0.0;
    for (answer, label) in answers.chunks_exact(outputs).zip(labels) {
        let sigma = answer[0];
        let value = match loss {
            Loss::Mse => {
                let unit = scale as f32;
                let error = (sigma - label) / unit;
                derivatives.push(2.0 * (share * error) * (1.0 / unit));
                error * error
            }
            Loss::LogMse => {
                let floor = (1e-3 * scale) as f32;
                let error = if sigma < floor { floor } else { sigma }.ln() - label.ln();
                derivatives.push(if sigma < floor { 0.0 } else { 2.0 * (share * error) * (1.0 / sigma) });
                error * error
            }
            Loss::LogNll => {
                let (error, log_spread) = (sigma.ln() - label.ln(), answer[1].ln());
                let spread = log_spread.exp();
                let ratio = error / spread;
                let d_ratio = 2.0 * (0.5 * share * ratio);
                let d_spread = d_ratio * (-error / (spread * spread));
                derivatives.push(d_ratio * (1.0 / spread) * (1.0 / sigma));
                derivatives.push((share + d_spread * spread) * (1.0 / answer[1]));
                0.5 * (ratio * ratio) + log_spread
            }
        };
        sum += f64::from(value);
    }
    (sum / labels.len() as f64, derivatives)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_small_differences() {
        let (answers, labels) = ([0.02, 0.5, 0.3, 1.7, 0.11, 0.9, 0.05, 0.2], [0.03, 0.21, 0.1, 0.06]);
        for (kind, outputs) in [(Loss::Mse, 1), (Loss::LogMse, 1), (Loss::LogNll, 2)] {
            let answers = &answers[..outputs * labels.len()];
            let (_, derivatives) = loss(kind, 0.1, answers, &labels);
            assert_eq!(derivatives.len(), answers.len());
            for i in 0..answers.len() {
                let step = 0.01 * answers[i];
                let at = |by: f32| {
                    let mut moved = answers.to_vec();
                    moved[i] += by;
                    loss(kind, 0.1, &moved, &labels).0
                };
                let slope = (at(step) - at(-step)) / f64::from(2.0 * step);
                let ours = f64::from(derivatives[i]);
                assert!(
                    (slope - ours).abs() < 2e-3 * slope.abs().max(0.01),
                    "{kind:?} {i}: {ours}, not {slope}"
                );
            }
        }
    }

    #[test]
    fn below_its_floor_an_answer_is_as_wrong_as_at_it_and_has_no_slope() {
        let of = |sigma| loss(Loss::LogMse, 1.0, &[sigma], &[0.5]);
        assert_eq!(of(1e-6), of(1e-4));
        assert_eq!(of(1e-6).1, [0.0]);
        assert!(of(2e-3).1[0] < 0.0);
    }

    #[test]
    fn a_loss_that_is_no_number_stays_none() {
        for kind in [Loss::Mse, Loss::LogMse, Loss::LogNll] {
            let outputs = if kind == Loss::LogNll { 2 } else { 1 };
            assert!(!loss(kind, 1.0, &vec![f32::NAN; outputs], &[0.5]).0.is_finite(), "{kind:?}");
        }
    }
}
