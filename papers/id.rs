//! Names of results: checksums of what they are made from.

use dpn_core::checksum;
use serde::Serialize;

/// Sixteen hexadecimal digits of SHA-256 over `parts`, each with its length.
pub fn id<T: AsRef<[u8]>>(parts: impl IntoIterator<Item = T>) -> String {
    let mut whole = checksum::of_parts(parts);
    whole.truncate(16);
    whole
}

/// What goes into a checksum or a file of a value of this program's own.
///
/// # Panics
/// For a value that is no JSON (a map whose keys are no strings): none of the plans, settings and rows here is one.
pub(super) fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).expect("plans, settings and rows are JSON")
}
