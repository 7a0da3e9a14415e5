//! The unpacked data sets, for tests on real recordings.

use std::path::{Path, PathBuf};

/// A part of them: in `$DPN_DATA`, else `data/`; `None`, loudly, where it is not.
pub(crate) fn pack(name: &str) -> Option<PathBuf> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let data = std::env::var_os("DPN_DATA").map_or_else(|| root.join("data"), PathBuf::from);
    let path = data.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no data ({} is not there)", path.display());
    None
}
