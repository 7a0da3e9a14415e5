//! One cell: as people read it, and in full.

use std::fmt::{Display, Write as _};

/// One cell: as people read it, and in full.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    shown: String,
    full: String,
}

impl Cell {
    /// A word, or whatever is shown as it is.
    pub fn text(text: impl Display) -> Self {
        let shown = text.to_string();
        Self { full: shown.clone(), shown }
    }

    /// A word for people, and what it stands for in CSV.
    pub fn named(shown: impl Into<String>, full: impl Display) -> Self {
        Self { shown: shown.into(), full: full.to_string() }
    }

    /// What a word stands for, where that is not what is shown.
    pub fn spelt(&self) -> Option<&str> {
        Some(self.full()).filter(|full| !full.is_empty() && *full != self.shown())
    }

    /// Nothing: a dash for people, an empty field in CSV.
    pub fn none() -> Self {
        Self { shown: "-".into(), full: String::new() }
    }

    /// A number, shown with so many decimals; a dash where there is none.
    pub fn number(value: impl Into<Option<f64>>, decimals: usize) -> Self {
        match value.into() {
            Some(value) if value.is_finite() => {
                Self { shown: format!("{value:.decimals$}"), full: value.to_string() }
            }
            _ => Self::none(),
        }
    }

    /// A number shown with so many significant digits, below 1e-4 with an exponent.
    pub fn significant(value: impl Into<Option<f64>>, digits: usize) -> Self {
        let value = value.into();
        if let Some(tiny) = value.filter(|v| *v != 0.0 && v.abs() < 1e-4) {
            let after = digits.saturating_sub(1);
            return Self { shown: format!("{tiny:.after$e}"), full: tiny.to_string() };
        }
        Self::number(value, decimals(value, digits))
    }

    /// A length in metres: three significant digits.
    pub fn metres(value: impl Into<Option<f64>>) -> Self {
        Self::significant(value, 3)
    }

    /// A length in metres with the ends of its interval: three significant digits of the length, the ends beside it as fine.
    pub fn metres_within(value: Option<f64>, ends: Option<[f64; 2]>) -> Self {
        Self::interval(value, ends, decimals(value, 3))
    }

    /// A share, shown in per cent.
    pub fn percent(share: impl Into<Option<f64>>, decimals: usize) -> Self {
        match share.into() {
            Some(share) if share.is_finite() => {
                Self { shown: format!("{:.decimals$} %", 100.0 * share), full: share.to_string() }
            }
            _ => Self::none(),
        }
    }

    /// A number with the ends of its interval.
    pub fn interval(value: Option<f64>, ends: Option<[f64; 2]>, decimals: usize) -> Self {
        let mut cell = Self::number(value, decimals);
        if let (Some(_), Some([low, high])) = (value, ends) {
            let _ = write!(cell.shown, " ({low:.decimals$} to {high:.decimals$})");
            let _ = write!(cell.full, " ({low} to {high})");
        }
        cell
    }

    /// A probability: three decimals, or the bound below which it lies.
    pub fn p(value: impl Into<Option<f64>>) -> Self {
        match value.into() {
            Some(p) if p < 0.001 => Self { shown: "<.001".into(), full: p.to_string() },
            other => Self::number(other, 3),
        }
    }

    /// The same with a mark behind what is shown.
    #[must_use]
    pub fn marked(mut self, mark: &str) -> Self {
        self.shown.push_str(mark);
        self
    }

    /// As people read it.
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// In full, as CSV has it.
    pub fn full(&self) -> &str {
        &self.full
    }
}

/// Decimals that show so many significant digits.
fn decimals(value: Option<f64>, digits: usize) -> usize {
    let value = value.filter(|v| *v != 0.0 && v.is_finite());
    let before = value.map_or(0, |v| v.abs().log10().floor() as i32 + 1);
    (digits as i32 - before).max(0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_read_rounded_numbers_and_a_dash_where_there_is_none() {
        assert_eq!(Cell::interval(Some(0.5), Some([0.4, 0.61]), 2).shown(), "0.50 (0.40 to 0.61)");
        assert_eq!(Cell::interval(None, Some([0.4, 0.61]), 2), Cell::none());
        assert_eq!(Cell::metres(12.34).marked("*").shown(), "12.3*");
        let within = Cell::metres_within(Some(0.004_937), Some([0.0041, 0.012_34]));
        assert_eq!(
            (within.shown(), within.full()),
            ("0.00494 (0.00410 to 0.01234)", "0.004937 (0.0041 to 0.01234)")
        );
        assert_eq!(
            [0.004_937, 0.1, 1.234, 512.3].map(|v| Cell::metres(v).shown().to_owned()),
            ["0.00494", "0.100", "1.23", "512"]
        );
        assert_eq!(
            [5.93e-16, -1.2e-5, 1e-4, 0.0].map(|v| Cell::significant(v, 3).shown().to_owned()),
            ["5.93e-16", "-1.20e-5", "0.000100", "0.000"]
        );
        assert_eq!(Cell::percent(0.801, 1).shown(), "80.1 %");
        assert_eq!((Cell::p(0.0004).shown(), Cell::p(0.0004).full()), ("<.001", "0.0004"));
        assert_eq!(Cell::number(f64::NAN, 2), Cell::none());
    }
}
