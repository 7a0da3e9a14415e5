//! Checksums that name results, weights and data: SHA-256 in hexadecimal digits.

use sha2::{Digest, Sha256};
use std::io;

/// A digest's hexadecimal digits, two a byte.
pub fn hex(digest: impl AsRef<[u8]>) -> String {
    digest.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 over parts, each with its length, in hexadecimal digits.
pub fn of_parts<T: AsRef<[u8]>>(parts: impl IntoIterator<Item = T>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        let part = part.as_ref();
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hex(hash.finalize())
}

/// SHA-256 of all that a source holds, as `sha256sum` prints it; none of it is kept.
///
/// # Errors
/// The source's own.
pub fn of_source(mut source: impl io::Read) -> io::Result<String> {
    let mut hash = Sha256::new();
    io::copy(&mut source, &mut hash)?;
    Ok(hex(hash.finalize()))
}

/// SHA-256 of bytes as they are, as `sha256sum` prints it.
pub fn of_bytes(bytes: &[u8]) -> String {
    hex(Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checksum_is_a_function_of_the_parts_and_of_where_they_end() {
        assert_eq!(of_parts(["a", "b"]), of_parts(["a", "b"]));
        assert_ne!(of_parts(["ab", "c"]), of_parts(["a", "bc"]));
        assert_ne!(of_parts(["a"]), of_parts(["a", ""]));
    }

    #[test]
    fn a_files_checksum_is_the_one_that_other_programs_print() {
        // FIPS 180-2, appendix B.1.
        let published = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(of_bytes(b"abc"), published);
        assert_eq!(of_source(b"abc".as_slice()).unwrap(), published);
    }
}
