//! Names of results: checksums of what they are made from.

use serde::Serialize;
use sha2::{Digest, Sha256};

/// Sixteen hexadecimal digits of SHA-256 over `parts`, each with its length.
pub fn id<T: AsRef<[u8]>>(parts: impl IntoIterator<Item = T>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        let part = part.as_ref();
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// What goes into a checksum or a file of a value of this program's own.
///
/// # Panics
/// For a value that is no JSON (a map whose keys are no strings): none of the plans, settings and rows here is one.
pub(super) fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).expect("plans, settings and rows are JSON")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_a_function_of_the_parts_and_of_where_they_end() {
        assert_eq!(id(["a", "b"]), id(["a", "b"]));
        assert_ne!(id(["ab", "c"]), id(["a", "bc"]));
        assert_ne!(id(["a"]), id(["a", ""]));
        assert_eq!(id(["a"]).len(), 16);
    }
}
