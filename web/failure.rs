//! What went wrong, as the page shows it: a sentence, and what to do about it.

use dpn_core::noise::units::BadNoise;
use dpn_io::noise_formats::FormatError;
use dpn_logs::LogError;
use dpn_probe::allan::AllanError;
use dpn_probe::log_noise::LogNoiseError;
use dpn_pronet::network::NetworkError;
use wasm_bindgen::JsError;

/// A sentence, and on a second line what to do, where that is known.
#[derive(Debug)]
pub(crate) struct Failure {
    what: String,
    hint: Option<String>,
}

impl Failure {
    pub(crate) fn new(what: impl Into<String>, hint: impl Into<Option<String>>) -> Self {
        Self { what: what.into(), hint: hint.into() }
    }
}

impl From<Failure> for JsError {
    fn from(failure: Failure) -> Self {
        match failure.hint {
            Some(hint) => Self::new(&format!("{}\n{hint}", failure.what)),
            None => Self::new(&failure.what),
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        let hint = match &error {
            LogError::NoSqlite { .. } => Some(
                "No reader of databases without C code is good enough for damaged ones. Open it by `dpn page LOG`, or convert it to MCAP by `ros2 bag convert`."
                    .to_owned(),
            ),
            error => error.hint(),
        };
        Self::new(error.to_string(), hint)
    }
}

macro_rules! from_errors {
    ($($error:ty: $hint:expr),+ $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                let hint: fn(&$error) -> Option<String> = $hint;
                Self::new(error.to_string(), hint(&error))
            }
        })+
    };
}

from_errors!(
    LogNoiseError: LogNoiseError::hint,
    AllanError: AllanError::hint,
    FormatError: FormatError::hint,
    NetworkError: |_| None,
    BadNoise: |_| None,
    std::io::Error: |_| None,
    serde_json::Error: |_| None,
);
