//! What can be wrong with a key of a noise figure.

use dpn_core::config::did_you_mean;
use thiserror::Error;

/// What is wrong with a key; texts are as the file has them, shortened.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // The fields' names say it.
pub enum KeyFault {
    /// A value that is no number, or not as many as there are axes.
    #[error("is {found}; {expected} is needed")]
    NotNumbers { found: String, expected: &'static str },
    /// A number that no noise has: zero, negative, not finite.
    #[error("is {value}; a noise figure is above zero")]
    NotPositive { value: f64 },
    /// A rate that is none.
    #[error("is {found}; a rate is a number of Hz above zero")]
    BadRate { found: String },
    /// A key that a data sheet does not have, and the nearest that it has.
    #[error("is no key of a datasheet; known are {known}")]
    Unknown { known: String, nearest: Option<String> },
    /// Covariances of a message that say "not known".
    #[error("{says}")]
    NotInMessage { says: &'static str },
}

impl KeyFault {
    /// What to do about it, where it is `key`'s.
    pub fn hint(&self, key: &str) -> String {
        let text = match self {
            Self::NotNumbers { .. } => "write a plain number in the unit of the format, without the unit",
            Self::NotPositive { value } if *value == 0.0 => {
                "an estimator told of no noise trusts the IMU without bound; put the sensor's figure there"
            }
            Self::NotPositive { .. } => {
                "deviations, variances and densities are above zero; look at the file it was made from"
            }
            Self::BadRate { .. } => "write the IMU's rate there, or give --rate HZ",
            Self::Unknown { nearest: Some(nearest), .. } => return did_you_mean(nearest),
            Self::Unknown { .. } if key.contains("instability") || key.contains("stability") => {
                "a bias instability is no walk and none follows from it; leave it out"
            }
            Self::Unknown { .. } => "leave the key out",
            Self::NotInMessage { .. } => {
                "the driver does not fill it in; take the data sheet, or a log at rest and `dpn allan`"
            }
        };
        text.to_owned()
    }
}
