//! What was done, said line by line.

use super::number::{AxesText, short};
use dpn_core::SampleRate;
use dpn_core::noise::{Axes, Figure, ImuFigures, Meaning};
use serde::Serialize;
use std::fmt;

/// One line of arithmetic: what came out, and how.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Step {
    /// Whose number it is: a key of a file, or the name of a figure.
    pub name: String,
    /// The calculation with its units, for example `0.08 m/s^2 / sqrt(200 Hz)`.
    pub from: String,
    /// The result with its unit.
    pub result: String,
    /// What the result is.
    pub meaning: &'static str,
}

impl Step {
    /// From the number of key `name` to the density that it made of `figures`.
    pub(super) fn to_density(
        name: &str,
        figure: Figure,
        meaning: Meaning,
        values: Axes<f64>,
        figures: &ImuFigures,
        rate: SampleRate,
    ) -> Self {
        let number = format!("{} {}", values.text(), meaning.unit(figure));
        let density = figures.density(figure).map_or_else(String::new, AxesText::text);
        Self {
            name: name.to_owned(),
            from: meaning.to_density_words(&number, &format!("{} Hz", short(rate.hz()))),
            result: format!("{density} {}", figure.unit()),
            meaning: "density",
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.from == self.result {
            write!(f, "{} = {} ({})", self.name, self.result, self.meaning)
        } else {
            write!(f, "{} = {} = {} ({})", self.name, self.from, self.result, self.meaning)
        }
    }
}

/// Something a reader should know about what was read or written; nothing that stops the work.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Remark(pub String);

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
