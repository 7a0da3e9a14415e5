//! What was done, said line by line.

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
