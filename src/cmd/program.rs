//! Which program this is.

use dpn_core::checksum::of_bytes;
use std::path::PathBuf;
use std::sync::OnceLock;

/// The file that this code stands in, where that is not the process's own.
static CODE: OnceLock<PathBuf> = OnceLock::new();

/// Says where this code stands: a module of Python's, whose process is the interpreter. The first to say so is believed.
pub(crate) fn code_is_in(file: PathBuf) {
    let _ = CODE.set(file);
}

/// What this is, without its checksum.
pub(super) const VERSION: &str = concat!("dpn ", env!("CARGO_PKG_VERSION"));

/// Version and checksum of this very program: another build may give other numbers.
pub(crate) fn program() -> String {
    let file = CODE.get().cloned().map_or_else(std::env::current_exe, Ok);
    let bytes = file.and_then(std::fs::read);
    bytes.map_or_else(|_| VERSION.to_owned(), |bytes| format!("{VERSION} ({})", &of_bytes(&bytes)[..16]))
}

/// Another build of this version.
pub(crate) fn program_of(sum: &str) -> String {
    format!("{VERSION} ({sum})")
}
