//! Which program this is.

use sha2::{Digest, Sha256};

/// Version and checksum of this very program: another build may give other numbers.
pub(crate) fn program() -> String {
    let version = concat!("dpn ", env!("CARGO_PKG_VERSION"));
    let bytes = std::env::current_exe().and_then(std::fs::read);
    let sum = bytes
        .map(|bytes| Sha256::digest(bytes).iter().take(8).map(|b| format!("{b:02x}")).collect::<String>());
    sum.map_or_else(|_| version.to_owned(), |sum| format!("{version} ({sum})"))
}

/// Another build of this version.
pub(crate) fn program_of(sum: &str) -> String {
    format!("{} ({sum})", concat!("dpn ", env!("CARGO_PKG_VERSION")))
}
