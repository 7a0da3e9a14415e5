//! YAML, and JSON, which is YAML; what is wrong with it has its line.

use crate::row_fault::RowFault;
use crate::{IoError, printable};
use serde::de::{DeserializeOwned, DeserializeSeed};
use std::path::Path;

/// The text of `bytes`; `path` is for messages.
pub(crate) fn text<'a>(bytes: &'a [u8], path: &Path) -> Result<&'a str, IoError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + memchr::memchr_iter(b'\n', &bytes[..error.valid_up_to()]).count();
        IoError::row(path, line, RowFault::NotUtf8)
    })
}

/// What a text says to a seed, as a walk through values that are rows.
///
/// # Errors
/// What is wrong with it, in words.
pub fn walk_yaml<'a, S: DeserializeSeed<'a>>(text: &'a str, seed: S) -> Result<S::Value, String> {
    serde_saphyr::with_deserializer_from_str(text, |input| seed.deserialize(input))
        .map_err(|error| printable(&error.without_snippet().to_string()))
}

/// What a text says.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, IoError> {
    serde_saphyr::from_str(text).map_err(|error| {
        let whole = error.without_snippet().to_string();
        let first = whole.lines().next().unwrap_or_default();
        let first = first.split(" at line ").next().unwrap_or(first).trim_start_matches("error: ");
        let line = error.location().and_then(|at| usize::try_from(at.line()).ok());
        let (path, line) = (path.to_path_buf(), line.filter(|line| *line > 0));
        IoError::BadYaml { path, line, message: printable(first) }
    })
}

/// `%YAML:1.0` at the head is no YAML unless `---` follows, which VINS' and Kimera's files do without: directives become comments.
pub(crate) fn without_directives(text: &str) -> String {
    let lines = text.split_inclusive('\n');
    lines
        .map(|line| line.strip_prefix('%').map_or_else(|| line.to_owned(), |rest| format!("#{rest}")))
        .collect()
}
