//! The unpacked data packs, for tests on real recordings.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The repository's root.
pub fn repository() -> &'static Path {
    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    Path::new(ROOT)
}

/// The folder that holds the pack `name`, in `$DPN_DATA`, else in `data/`; `None` where it is not there, said and counted on stderr past
/// the test runner's capture.
///
/// # Panics
/// Where `DPN_DATA` names a folder without the pack: who names a folder expects nothing to be skipped.
pub fn pack(name: &str) -> Option<PathBuf> {
    static SKIPPED: AtomicUsize = AtomicUsize::new(0);
    let named = std::env::var_os("DPN_DATA").map(PathBuf::from);
    let path = named.clone().unwrap_or_else(|| repository().join("data")).join(name);
    if path.exists() {
        return Some(path);
    }
    assert!(named.is_none(), "DPN_DATA is set, but {} is not there", path.display());
    let count = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    // Not `eprintln!`: the test runner would swallow it, since the test passes.
    let told =
        writeln!(std::io::stderr(), "skipped: no data ({name}): {test}; {count} so far in this executable");
    told.expect("stderr can be written");
    None
}

/// Several packs at once; `None` where one of them is not there.
///
/// # Panics
/// As [`pack`].
pub fn packs<const N: usize>(names: [&str; N]) -> Option<[PathBuf; N]> {
    let found = names.map(pack);
    found.iter().all(Option::is_some).then(|| found.map(|path| path.expect("all are there")))
}
