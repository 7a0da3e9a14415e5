//! Words that are spelt on the command line as in configurations.

use serde::de::DeserializeOwned;

/// The choice that `text` names.
pub(super) fn word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(text.into()).map_err(|error| error.to_string())
}
