//! Why there is no figure.

use dpn_io::IoError;
use thiserror::Error;

/// Why a figure could not be made or saved.
#[derive(Debug, Error)]
pub enum FigureError {
    /// Nothing to draw.
    #[error("{figure}: there is no {what} to draw; give at least one")]
    Empty {
        /// The figure asked for.
        figure: &'static str,
        /// What is missing.
        what: String,
    },
    /// More lines than a reader can tell apart.
    #[error("{figure}: {found} {what} are more than can be told apart; choose {most} at most")]
    TooMany {
        /// The figure asked for.
        figure: &'static str,
        /// What there are too many of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// Columns that do not belong together.
    #[error("{figure}: {what} has {found} values where {expected} are needed, one for each of the others")]
    Lengths {
        /// The figure asked for.
        figure: &'static str,
        /// The column at fault.
        what: String,
        /// Values needed.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// NaN, infinity, a time that goes back, a true deviation that is not positive.
    #[error("{figure}: {what} is {value} at index {index}; {need}")]
    Value {
        /// The figure asked for.
        figure: &'static str,
        /// The column at fault.
        what: String,
        /// Index of the first bad value.
        index: usize,
        /// The value.
        value: f64,
        /// What it should be.
        need: &'static str,
    },
    /// It could not be written.
    #[error("{0}")]
    Write(#[from] IoError),
    /// What should be drawn lies in a temporary file that cannot be read again.
    #[error("{0}")]
    Read(#[from] std::io::Error),
    /// The drawing library refused.
    #[error("cannot draw: {reason}; please report it with its input, from which a figure should come")]
    Draw {
        /// What the library says.
        reason: String,
    },
}

/// Checks that `values` has `expected` entries, all finite.
pub(super) fn check_column(
    figure: &'static str,
    what: &str,
    values: &[f64],
    expected: usize,
) -> Result<(), FigureError> {
    if values.len() != expected {
        return Err(FigureError::Lengths { figure, what: what.to_owned(), expected, found: values.len() });
    }
    check_each(figure, what, values, "it must be finite", f64::is_finite)
}

/// Refuses more of `what` than a reader can tell apart.
pub(super) fn check_count(
    figure: &'static str,
    what: &'static str,
    found: usize,
    most: usize,
) -> Result<(), FigureError> {
    if found > most { Err(FigureError::TooMany { figure, what, found, most }) } else { Ok(()) }
}

/// Checks every value with `good`.
pub(super) fn check_each(
    figure: &'static str,
    what: &str,
    values: &[f64],
    need: &'static str,
    good: impl Fn(f64) -> bool,
) -> Result<(), FigureError> {
    match values.iter().position(|&value| !good(value)) {
        None => Ok(()),
        Some(index) => {
            Err(FigureError::Value { figure, what: what.to_owned(), index, value: values[index], need })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bad_value_is_named() {
        let error = check_column("flight", "signal", &[0.0, f64::NAN, f64::INFINITY], 3).unwrap_err();
        assert_eq!(error.to_string(), "flight: signal is NaN at index 1; it must be finite");
        let error = check_column("flight", "signal", &[0.0], 3).unwrap_err();
        assert!(error.to_string().contains("1 values where 3 are needed"), "{error}");
    }
}
