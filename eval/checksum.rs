//! Checksums that name results.

use sha2::{Digest, Sha256};

/// SHA-256 over parts, each with its length, in hexadecimal digits.
pub(crate) fn sha256<T: AsRef<[u8]>>(parts: impl IntoIterator<Item = T>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        let part = part.as_ref();
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checksum_is_a_function_of_the_parts_and_of_where_they_end() {
        assert_eq!(sha256(["a", "b"]), sha256(["a", "b"]));
        assert_ne!(sha256(["ab", "c"]), sha256(["a", "bc"]));
        assert_ne!(sha256(["a"]), sha256(["a", ""]));
    }
}
