//! What every quantity of noise has in common: finite, not negative, a plain number in files.

/// A noise value that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a noise figure must be finite and not negative, not {0}")]
pub struct BadNoise(pub f64);

/// `value` where it is one of a noise.
///
/// # Errors
/// Negative, NaN or infinite values.
pub(crate) fn checked(value: f64) -> Result<f64, BadNoise> {
    if value.is_finite() && value >= 0.0 { Ok(value) } else { Err(BadNoise(value)) }
}

macro_rules! quantity {
    ($($(#[$doc:meta])* $name:ident;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, serde::Serialize, serde::Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            /// Takes `value` in the unit named above.
            ///
            /// # Errors
            /// Negative, NaN or infinite values.
            pub fn new(value: f64) -> Result<Self, super::BadNoise> {
                super::quantity::checked(value).map(Self)
            }

            /// The number in the unit named above.
            pub fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = super::BadNoise;
            fn try_from(value: f64) -> Result<Self, super::BadNoise> {
                Self::new(value)
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> f64 {
                value.0
            }
        }
    )+};
}

pub(super) use quantity;
