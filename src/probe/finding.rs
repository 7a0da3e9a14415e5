//! One thing that was found, of a log or of a configuration held against it.

use dpn_core::{Sensor, named};
use serde::Serialize;

named!(
    /// How much a finding matters.
    #[derive(PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Weight {
        /// An estimator fed with this log goes wrong.
        Bad = "bad",
        /// Worth a look.
        Warning = "warning",
        /// Good to know.
        Note = "note",
    }
);

/// One finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// How much it matters.
    pub weight: Weight,
    /// What it is about, one word: `rate`, `gaps`, `gravity`.
    pub about: &'static str,
    /// What was found, with numbers.
    pub text: String,
    /// What to do about it.
    pub remedy: Option<&'static str>,
}

impl Finding {
    pub(crate) fn bad(about: &'static str, text: String, remedy: &'static str) -> Self {
        Self { weight: Weight::Bad, about, text, remedy: Some(remedy) }
    }

    pub(crate) fn warning(about: &'static str, text: String, remedy: &'static str) -> Self {
        Self { weight: Weight::Warning, about, text, remedy: Some(remedy) }
    }

    /// Bad where `is_bad`, else a warning.
    pub(crate) fn bad_where(is_bad: bool, about: &'static str, text: String, remedy: &'static str) -> Self {
        if is_bad { Self::bad(about, text, remedy) } else { Self::warning(about, text, remedy) }
    }

    pub(crate) fn note(about: &'static str, text: String) -> Self {
        Self { weight: Weight::Note, about, text, remedy: None }
    }

    /// Of a figure of a configuration; `warns` whether a person should look at it.
    #[cfg(feature = "formats")]
    pub(crate) fn figure(warns: bool, text: String) -> Self {
        let weight = if warns { Weight::Warning } else { Weight::Note };
        Self { weight, about: "noise parameters", text, remedy: None }
    }

    /// Whether it is of the zeros that stand for a sensor which the log, with the other one `alone`, does not have.
    pub(crate) fn is_of_zeros(&self, alone: Option<Sensor>) -> bool {
        match alone {
            None => false,
            Some(Sensor::Gyro) => {
                self.text.starts_with("accel ") || ["gravity", "columns"].contains(&self.about)
            }
            Some(Sensor::Accel) => self.text.starts_with("gyro ") || self.about == "drift",
        }
    }

    /// Whether a person should look at it.
    pub fn warns(&self) -> bool {
        self.weight != Weight::Note
    }
}
