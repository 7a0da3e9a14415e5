//! Golden values: what other people's programs say of inputs that their script wrote down with them.

use serde::de::DeserializeOwned;

/// What `golden/NAME/golden.json` holds.
///
/// # Panics
/// A file that is not there or does not fit `T`: the script beside it writes it.
pub fn golden<T: DeserializeOwned>(name: &str) -> T {
    let path = crate::repository().join("golden").join(name).join("golden.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
