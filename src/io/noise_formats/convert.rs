//! One program's figures as another's, with the arithmetic.

use super::{Format, FormatError, Given, NoiseCalibration, Quantity, Remark, Step, Written, write};
use dpn_core::SampleRate;
use dpn_core::noise::{Figure, ImuFigures};

/// What was read and what was written.
#[derive(Debug, Clone)]
pub struct Conversion {
    /// Where the figures come from.
    pub from: Format,
    /// The figures, at the rate that they were written for.
    pub figures: ImuFigures,
    /// What is to be pasted.
    pub written: Written,
    /// The arithmetic of reading and writing.
    pub steps: Vec<Step>,
    /// What else should be known of both.
    pub remarks: Vec<Remark>,
}

impl Conversion {
    /// Writes `source` as `to`, for an IMU of `to_rate` where that is not the source's.
    ///
    /// # Errors
    /// Figures that `to` has no place for, a rate that it needs.
    pub fn of(
        source: NoiseCalibration,
        to: Format,
        to_rate: Option<SampleRate>,
    ) -> Result<Self, FormatError> {
        let NoiseCalibration { format, mut figures, mut steps, mut remarks, .. } = source;
        figures.rate = to_rate.or(figures.rate);
        let written = write(&figures, to, |_| None)?;
        steps.extend(written.steps.iter().cloned());
        remarks.extend(written.remarks.iter().cloned());
        Ok(Self { from: format, figures, written, steps, remarks })
    }

    /// All of it for programs.
    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "from": self.from, "to": self.written.format, "rate_hz": self.figures.rate, "figures": self.figures,
            "steps": self.steps, "remarks": self.remarks, "text": self.written.text,
        })
    }
}

impl Given {
    /// The same with figures as they were typed, a number and its unit, in the order of [`Figure::ALL`].
    ///
    /// # Errors
    /// A text that is no such figure; it is named by its flag of the command line.
    pub fn with_typed(mut self, typed: [Option<&str>; 4]) -> Result<Self, FormatError> {
        for (figure, text) in Figure::ALL.into_iter().zip(typed) {
            let Some(text) = text else { continue };
            self.quantities.push(Quantity::parse(text, figure).map_err(|problem| FormatError::Quantity {
                place: format!("--{}", figure.flag()),
                problem,
            })?);
        }
        Ok(self)
    }
}
