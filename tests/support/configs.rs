//! What configuration files that write out a default are held to.

use serde::Serialize;
use std::path::Path;

/// Asserts that the file has every key of `default`, tables within tables too, and that no key in it stands without a comment.
pub fn written_out(path: &Path, default: &impl Serialize) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let written: toml::Table = toml::from_str(&text).expect("the file was loaded before");
    let default = toml::Table::try_from(default).expect("configurations are tables");
    all_written("", &default, &written);
    for line in text.lines().filter(|line| line.contains('=')) {
        assert!(line.contains('#'), "no comment: {line}");
    }
}

fn all_written(at: &str, default: &toml::Table, written: &toml::Table) {
    for (key, value) in default {
        let at = format!("{at}.{key}");
        let there = written.get(key).unwrap_or_else(|| panic!("{at} is not in the file"));
        if let (Some(default), Some(written)) = (value.as_table(), there.as_table()) {
            all_written(&at, default, written);
        }
    }
}
