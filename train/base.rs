//! The signal noise is injected into (decisions 2 and 3).

use crate::clean::Cleaner;
use dpn_core::signal::{FilterError, SavitzkyGolay};
use std::fmt;
use std::str::FromStr;

/// The signal's treatment before noise is injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Base {
    /// The recorded signal as it is.
    Raw,
    /// Savitzky-Golay of `(window, order)`.
    SavitzkyGolay {
        /// Samples, odd.
        window: usize,
        /// Degree of the polynomial, below `window`.
        order: usize,
    },
    /// Gaussian smoothing, its width changing from window to window ([`GAUSSIAN_WIDTHS`](crate::clean::GAUSSIAN_WIDTHS)):
    /// motion without the side lobes of a Savitzky-Golay filter, through which strong motion leaks into high frequencies.
    Gaussian,
}

impl Base {
    /// The bases of the study, from the mildest filter to the strongest.
    pub const STUDY: [Self; 5] = [
        Self::SavitzkyGolay { window: 5, order: 2 },
        Self::SavitzkyGolay { window: 7, order: 2 },
        Self::SavitzkyGolay { window: 11, order: 2 },
        Self::SavitzkyGolay { window: 21, order: 3 },
        Self::SavitzkyGolay { window: 51, order: 3 },
    ];

    /// What cleans windows of `len` samples, built once.
    ///
    /// # Errors
    /// An even window, an order not below it, a filter longer than `len`.
    pub(crate) fn cleaner(self, len: usize) -> Result<Cleaner, FilterError> {
        match self {
            Self::Raw => Ok(Cleaner::Nothing),
            Self::SavitzkyGolay { window, .. } if window > len => {
                Err(FilterError::SignalTooShort { len, window })
            }
            Self::SavitzkyGolay { window, order } => {
                SavitzkyGolay::new(window, order).map(Cleaner::SavitzkyGolay)
            }
            Self::Gaussian => Ok(Cleaner::gaussian()),
        }
    }

    /// The Savitzky-Golay filter, where the base is one.
    ///
    /// # Errors
    /// An even window, or an order not below it.
    pub fn filter(self) -> Result<Option<SavitzkyGolay>, FilterError> {
        match self {
            Self::Raw | Self::Gaussian => Ok(None),
            Self::SavitzkyGolay { window, order } => SavitzkyGolay::new(window, order).map(Some),
        }
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Raw => f.write_str("raw"),
            Self::Gaussian => f.write_str("gaussian"),
            Self::SavitzkyGolay { window, order } => write!(f, "sg({window},{order})"),
        }
    }
}

/// A base that cannot be read.
#[derive(Debug, thiserror::Error, PartialEq)]
#[error("`{0}` is no base; write `raw`, `gaussian` or `sg(WINDOW,ORDER)`, for example `sg(11,2)`")]
pub struct UnknownBase(pub String);

impl FromStr for Base {
    type Err = UnknownBase;

    fn from_str(text: &str) -> Result<Self, UnknownBase> {
        let unknown = || UnknownBase(text.to_owned());
        let trimmed = text.trim();
        match trimmed {
            "raw" => return Ok(Self::Raw),
            "gaussian" => return Ok(Self::Gaussian),
            _ => {}
        }
        let inside =
            trimmed.strip_prefix("sg(").and_then(|rest| rest.strip_suffix(')')).ok_or_else(unknown)?;
        let (window, order) = inside.split_once(',').ok_or_else(unknown)?;
        Ok(Self::SavitzkyGolay {
            window: window.trim().parse().map_err(|_| unknown())?,
            order: order.trim().parse().map_err(|_| unknown())?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_written_and_read_back() {
        for base in Base::STUDY.into_iter().chain([Base::Raw, Base::Gaussian]) {
            assert_eq!(base.to_string().parse::<Base>().unwrap(), base);
        }
        assert!("sg(11)".parse::<Base>().is_err());
        assert!("savgol".parse::<Base>().is_err());
    }
}
