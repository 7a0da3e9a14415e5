//! What people call a sequence.

use dpn_core::config::{nearest, suggestion};

/// What a sequence may be called: its name, and the name as people shorten it, `MH_01` of `MH_01_easy`, `room1` of TUM-VI's, `hover` of `f09-hover`.
fn called(full: &str) -> impl Iterator<Item = &str> {
    let ends = ["_easy", "_medium", "_difficult", "_512_16"];
    let short = ends.into_iter().filter_map(|end| full.strip_suffix(end));
    let room = full.strip_prefix("dataset-").and_then(|name| name.strip_suffix("_512_16"));
    let flight = full.starts_with('f').then(|| full.get(4..)).flatten();
    std::iter::once(full).chain(short).chain(room).chain(flight)
}

/// Whether `name` is one of those.
pub(super) fn is_called(full: &str, name: &str) -> bool {
    called(full).any(|word| word == name)
}

/// The sequence that was probably meant, in brackets; empty where none is near.
pub(super) fn meant(name: &str, known: &[String]) -> String {
    let words = known.iter().flat_map(|full| called(full));
    suggestion(nearest(name, words).and_then(|word| known.iter().find(|full| is_called(full, word))))
}
