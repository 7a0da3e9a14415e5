//! What is drawn of one flight, and what of it cannot be drawn.

use super::error::{FigureError, check_column, check_count, check_each};
use dpn_core::Sensor;

/// Name of the figure in errors.
const FIGURE: &str = "flight";
/// Most models on one sheet.
const MOST: usize = 4;

/// A part of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// What happens in it, for example `motors on`.
    pub label: String,
    /// Start \[s\], on the flight's time.
    pub from: f64,
    /// End \[s\].
    pub to: f64,
}

/// What is drawn of one flight.
#[derive(Debug, Clone)]
pub struct Flight<'a> {
    /// Name of the flight.
    pub name: &'a str,
    /// Sensor of the signal.
    pub sensor: Sensor,
    /// Axis of the signal, for example `x`.
    pub axis: &'a str,
    /// Time of each sample \[s\], ascending.
    pub t: &'a [f64],
    /// Raw signal \[unit of the sensor\].
    pub signal: &'a [f64],
    /// Name of each model and its estimate at each sample \[unit of the sensor\]; one to four.
    pub models: Vec<(&'a str, &'a [f64])>,
    /// True deviation at each sample, where it is known.
    pub truth: Option<&'a [f64]>,
    /// Phases, in order.
    pub phases: Vec<Phase>,
    /// Largest deviation the models were trained on.
    pub trained_up_to: Option<f64>,
    /// What else a reader must know, at the end of the small print.
    pub words: &'a str,
}

impl Flight<'_> {
    /// Refuses what cannot be drawn.
    pub(super) fn check(&self) -> Result<(), FigureError> {
        let n = self.t.len();
        if n < 2 || self.models.is_empty() {
            return Err(FigureError::Empty {
                figure: FIGURE,
                what: if n < 2 { "pair of samples" } else { "model" }.into(),
            });
        }
        check_count(FIGURE, "models", self.models.len(), MOST)?;
        check_column(FIGURE, "time", self.t, n)?;
        if let Some(i) = self.t.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(FigureError::Value {
                figure: FIGURE,
                what: "time".into(),
                index: i + 1,
                value: self.t[i + 1],
                need: "it must ascend",
            });
        }
        check_column(FIGURE, "signal", self.signal, n)?;
        for (name, sigma) in &self.models {
            check_column(FIGURE, name, sigma, n)?;
        }
        if let Some(truth) = self.truth {
            check_column(FIGURE, "true sigma", truth, n)?;
        }
        for phase in &self.phases {
            check_column(FIGURE, &format!("phase {}", phase.label), &[phase.from, phase.to], 2)?;
        }
        let need = "it must be finite and positive";
        check_each(FIGURE, "the training range's end", self.trained_up_to.as_slice(), need, |v| {
            v.is_finite() && v > 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_of_the_input_are_named() {
        let error = |t: &[f64], sigma: &[f64]| {
            let flight = Flight {
                name: "MH_04",
                sensor: Sensor::Accel,
                axis: "z",
                t,
                signal: &[1.0, 2.0, 3.0],
                models: vec![("network", sigma)],
                truth: None,
                phases: Vec::new(),
                trained_up_to: Some(0.21),
                words: "",
            };
            flight.check().unwrap_err().to_string()
        };
        assert!(error(&[0.0, 1.0, 1.0], &[1.0; 3]).contains("time is 1 at index 2; it must ascend"));
        assert!(error(&[0.0, 1.0, 2.0], &[1.0; 2]).contains("network has 2 values where 3"));
        assert!(error(&[0.0, 1.0, 2.0], &[1.0, f64::NAN, 1.0]).contains("network is NaN at index 1"));
        assert!(error(&[0.0], &[1.0]).contains("no pair of samples"));
    }
}
