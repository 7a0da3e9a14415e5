//! What the book of results is held to: `targets` keeps its page of targets at what `targets.csv` says, `numbers` the marked numbers of README,
//! book and targets at what commands left, `prose` its tables and links in order, `house` the crates at what ARCHITECTURE.md draws, `circles` their
//! files at imports that lead nowhere back. Nothing here is built outside tests; `mdbook build docs` makes the book.

#![cfg_attr(test, allow(clippy::unwrap_used))]

#[cfg(test)]
mod circles;
#[cfg(test)]
mod house;
#[cfg(test)]
mod numbers;
#[cfg(test)]
mod prose;
#[cfg(test)]
mod targets;

/// Where `path`, given from the repository's root, lies.
#[cfg(test)]
fn at(path: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The text of a file of the repository.
#[cfg(test)]
fn read(path: &str) -> String {
    std::fs::read_to_string(at(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}
