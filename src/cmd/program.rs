//! Which program this is.

use dpn_core::checksum::of_bytes;

/// Version and checksum of this very program: another build may give other numbers.
pub(crate) fn program() -> String {
    let version = concat!("dpn ", env!("CARGO_PKG_VERSION"));
    let bytes = std::env::current_exe().and_then(std::fs::read);
    bytes.map_or_else(|_| version.to_owned(), |bytes| format!("{version} ({})", &of_bytes(&bytes)[..16]))
}

/// Another build of this version.
pub(crate) fn program_of(sum: &str) -> String {
    format!("{} ({sum})", concat!("dpn ", env!("CARGO_PKG_VERSION")))
}
