//! Lines of code a crate, without tests, comments and blank lines: `cargo run -p dpn-book --example lines`.
//!
//! Left out are items and modules under `#[cfg(test)]` or `#[cfg(all(test, ...))]` and everything in `tests`, `examples`, `bench`, `fuzz` and `docs`. Code is taken as rustfmt leaves it: an
//! item ends at the closing bracket that is indented as its first line is.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const LEFT_OUT: [&str; 8] = ["target", "tests", "examples", "bench", "fuzz", "docs", "golden", "data"];

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize()?;
    let mut files = BTreeMap::new();
    read_below(&root, &mut files)?;
    let test_modules: BTreeSet<PathBuf> = files.iter().flat_map(|(path, text)| code(path, text).1).collect();

    let mut by_crate = BTreeMap::<String, usize>::new();
    for (path, text) in &files {
        if path.ancestors().any(|part| test_modules.contains(&part.with_extension(""))) {
            continue;
        }
        let krate = path.ancestors().find(|part| part.join("Cargo.toml").exists()).unwrap_or(&root);
        let name = krate.strip_prefix(&root).unwrap_or(krate).display().to_string();
        let name = if name.is_empty() { "the command line".to_owned() } else { name };
        *by_crate.entry(name).or_default() += code(path, text).0;
    }
    for (name, lines) in &by_crate {
        println!("{lines:6}  {name}");
    }
    println!("{:6}  in all", by_crate.values().sum::<usize>());
    Ok(())
}

fn read_below(folder: &Path, files: &mut BTreeMap<PathBuf, String>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name()))?;
        let name = name.to_string_lossy();
        if path.is_dir() {
            if !name.starts_with('.') && !LEFT_OUT.contains(&name.as_ref()) {
                read_below(&path, files)?;
            }
        } else if name.ends_with(".rs") {
            let text = std::fs::read_to_string(&path)?;
            files.insert(path, text);
        }
    }
    Ok(())
}

/// Lines of code outside tests, and the modules that only tests have, as paths without an ending.
fn code(path: &Path, text: &str) -> (usize, Vec<PathBuf>) {
    let stem = path.file_stem().unwrap_or_default();
    let is_root = ["mod", "lib", "main"].iter().any(|name| stem == *name);
    let children = if is_root { path.with_file_name("") } else { path.with_extension("") };
    let (mut count, mut modules) = (0, Vec::new());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let trimmed = line.trim();
        if trimmed == "#[cfg(test)]" || trimmed.starts_with("#[cfg(all(test,") {
            let Some(first) = lines.by_ref().find(|line| !line.trim().starts_with("#[")) else { break };
            let item = first.trim();
            if let Some((_, name)) =
                item.trim_end_matches(';').rsplit_once("mod ").filter(|_| item.ends_with(';'))
            {
                modules.push(children.join(name));
            } else if !item.ends_with(';') && item.matches('{').count() != item.matches('}').count() {
                let indent = &first[..first.len() - first.trim_start().len()];
                lines
                    .by_ref()
                    .find(|line| line.strip_prefix(indent).is_some_and(|rest| rest.starts_with('}')));
            }
        } else if !trimmed.is_empty() && !trimmed.starts_with("//") {
            count += 1;
        }
    }
    (count, modules)
}
