//! No file imports itself through others: the imports of every crate, read as text and followed to the files that define what they name.
//!
//! Read are `use` lines and paths from `crate`, `super`, `self`, a child module or an imported name, outside `#[cfg(test)]`. A re-export (`pub use`) is no
//! import of the file that only hands the name on: who asks for the name imports the file that defines it. Not seen: methods, and macros by their bare names.

use crate::at;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

/// A module by its names below the crate, `[]` for the crate itself.
type Name = Vec<String>;

/// What a name of a module stands for.
enum Meaning {
    /// Something that the module's own file defines.
    Item,
    /// What lies at this path, as the module would write it.
    Path(Name),
}

struct Module {
    file: PathBuf,
    names: BTreeMap<String, Meaning>,
    /// Paths of `use ...::*`.
    globs: Vec<Name>,
    /// Paths of code and of private `use`, as written.
    asked: Vec<Name>,
}

/// Words, strings with their quotes, `::` and single signs of a source; comments, characters and lifetimes are gone.
fn tokens(text: &str) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let starts = |i: usize, what: &str| what.chars().enumerate().all(|(k, c)| at(i + k) == c);
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let find =
        |from: usize, what: &str| (from..chars.len()).find(|i| starts(*i, what)).unwrap_or(chars.len());
    let (mut found, mut i) = (Vec::new(), 0);
    while i < chars.len() {
        let begin = i;
        let raw = i + usize::from(starts(i, "br"));
        let hashes = (raw + 1..).take_while(|k| at(*k) == '#').count();
        if starts(i, "//") {
            i = find(i, "\n");
        } else if starts(i, "/*") {
            i = find(i, "*/") + 2;
        } else if at(raw) == 'r' && at(raw + 1 + hashes) == '"' {
            let end = format!("\"{}", "#".repeat(hashes));
            i = find(raw + 2 + hashes, &end) + end.len();
        } else if at(i) == '"' {
            i += 1;
            while i < chars.len() && at(i) != '"' {
                i += 1 + usize::from(at(i) == '\\');
            }
            i += 1;
            found.push(chars[begin..i.min(chars.len())].iter().collect());
        } else if at(i) == '\'' {
            // A character ends with a quote; a lifetime does not.
            let long = if at(i + 1) == '\\' { find(i + 3, "'") + 1 - i } else { 3 };
            i += if at(i + long - 1) == '\'' { long } else { 1 };
        } else if is_word(at(i)) {
            while is_word(at(i)) {
                i += 1;
            }
            found.push(chars[begin..i].iter().collect());
        } else {
            i += if starts(i, "::") { 2 } else { 1 };
            if !at(begin).is_whitespace() {
                found.push(chars[begin..i].iter().collect());
            }
        }
    }
    found
}

/// Index behind the bracket that closes the one at `open`.
fn behind(tokens: &[String], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}

/// Index behind the item that begins at `i`: its semicolon or its braces.
fn behind_item(tokens: &[String], mut i: usize) -> usize {
    let is_use = tokens[i..].iter().take(6).any(|token| token == "use");
    while i < tokens.len() {
        match tokens[i].as_str() {
            ";" => return i + 1,
            "{" if !is_use => return behind(tokens, i),
            "(" | "[" | "{" => i = behind(tokens, i),
            _ => i += 1,
        }
    }
    i
}

/// The path of words from `i`, and the index behind it.
fn path_at(tokens: &[String], mut i: usize) -> (Name, usize) {
    let mut path = vec![tokens[i].clone()];
    while tokens.get(i + 1).is_some_and(|t| t == "::") {
        let Some(next) = tokens.get(i + 2).filter(|t| t.starts_with(|c: char| c.is_alphabetic() || c == '_'))
        else {
            break;
        };
        path.push(next.clone());
        i += 2;
    }
    (path, i + 1)
}

/// Paths that a `use` names, each with the name that it gets (`*` for all in it), and the index behind.
fn use_tree(tokens: &[String], mut i: usize, begin: &Name, found: &mut Vec<(String, Name)>) -> usize {
    let mut path = begin.clone();
    loop {
        match tokens[i].as_str() {
            "::" => i += 1,
            "{" => {
                i += 1;
                while tokens[i] != "}" {
                    i = use_tree(tokens, i, &path, found);
                    i += usize::from(tokens[i] == ",");
                }
                return i + 1;
            }
            "as" => {
                found.push((tokens[i + 1].clone(), path));
                return i + 2;
            }
            "," | ";" | "}" => {
                found.push((path.last().cloned().unwrap_or_default(), path));
                return i;
            }
            "*" => {
                found.push(("*".to_owned(), path));
                return i + 1;
            }
            "self" if !path.is_empty() => i += 1,
            word => {
                path.push(word.to_owned());
                i += 1;
            }
        }
    }
}

struct Crate {
    modules: BTreeMap<Name, Module>,
}

impl Crate {
    fn read(root: &Path) -> Self {
        let mut all = Self { modules: BTreeMap::new() };
        all.read_file(root, root.parent().unwrap(), Vec::new());
        all
    }

    /// `children`: the folder of the module's own files.
    fn read_file(&mut self, file: &Path, children: &Path, name: Name) {
        let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.read_items(&tokens(&text), file, children, name);
    }

    fn read_items(&mut self, tokens: &[String], file: &Path, children: &Path, name: Name) {
        let mut own =
            Module { file: file.to_path_buf(), names: BTreeMap::new(), globs: Vec::new(), asked: Vec::new() };
        let (mut i, mut other_file) = (0, None);
        let (mut words, mut handed_on) = (BTreeSet::new(), Vec::new());
        while i < tokens.len() {
            match tokens[i].as_str() {
                "#" if matches!(tokens[i + 1].as_str(), "[" | "!") => {
                    let open = i + 1 + usize::from(tokens[i + 1] == "!");
                    let end = behind(tokens, open);
                    let said: Vec<&str> = tokens[open + 1..end - 1].iter().map(String::as_str).collect();
                    match said[..] {
                        ["path", "=", path] => other_file = Some(path.trim_matches('"').to_owned()),
                        ["cfg", "(", "test" | "doctest", ..] | ["cfg", "(", "all", "(", "test", ..] => {
                            let mut item = end;
                            while tokens[item] == "#" {
                                item = behind(tokens, item + 1);
                            }
                            i = behind_item(tokens, item);
                            continue;
                        }
                        _ => {}
                    }
                    i = end;
                }
                "mod" if tokens.get(i + 2).is_some_and(|t| t == ";" || t == "{") => {
                    let word = tokens[i + 1].clone();
                    let below: Name = name.iter().chain([&word]).cloned().collect();
                    if tokens[i + 2] == "{" {
                        let end = behind(tokens, i + 2);
                        self.read_items(&tokens[i + 3..end - 1], file, &children.join(&word), below);
                        i = end;
                    } else {
                        let beside = children.join(format!("{word}.rs"));
                        let inside = children.join(&word).join("mod.rs");
                        let lies = match other_file.take() {
                            Some(path) => file.with_file_name(path),
                            None if beside.exists() => beside,
                            None => inside,
                        };
                        self.read_file(&lies, &children.join(&word), below);
                        i += 3;
                    }
                }
                // `use<'a>` is a bound.
                "use" if tokens[i + 1] != "<" => {
                    let mut found = Vec::new();
                    let end = use_tree(tokens, i + 1, &Vec::new(), &mut found);
                    let is_public = i > 0 && matches!(tokens[i - 1].as_str(), "pub" | ")");
                    for (word, path) in found {
                        if is_public {
                            handed_on.push((word.clone(), path.clone()));
                        } else {
                            own.asked.push(path.clone());
                        }
                        if word == "*" {
                            own.globs.push(path);
                        } else if path.first() != Some(&word) {
                            own.names.insert(word, Meaning::Path(path));
                        }
                    }
                    i = end;
                }
                "struct" | "enum" | "union" | "trait" | "type" | "fn" | "const" | "static" | "!" => {
                    if let Some(word) = tokens.get(i + 1) {
                        own.names.entry(word.clone()).or_insert(Meaning::Item);
                    }
                    i += 1;
                }
                word if word.starts_with(|c: char| c.is_alphabetic() || c == '_') => {
                    let (path, end) = path_at(tokens, i);
                    if path.len() > 1 {
                        own.asked.push(path);
                    } else if i > 0 && tokens[i - 1] != "." {
                        words.insert(path[0].clone());
                    }
                    i = end;
                }
                _ => i += 1,
            }
        }
        // What a file hands on and uses itself it imports.
        own.asked
            .extend(handed_on.into_iter().filter(|(word, _)| words.contains(word)).map(|(_, path)| path));
        self.modules.insert(name, own);
    }

    /// The file that defines what `module` calls `path`; `None` of other crates, of modules and of what this does not see.
    fn defines(
        &self,
        module: &[String],
        path: &[String],
        seen: &mut BTreeSet<(Name, Name)>,
    ) -> Option<&Path> {
        let (first, rest) = path.split_first()?;
        // Another crate's name that is like one of ours leads round and round.
        if path.len() > 16 || !seen.insert((module.to_vec(), path.to_vec())) {
            return None;
        }
        match first.as_str() {
            "crate" => return self.defines(&[], rest, seen),
            "self" => return self.defines(module, rest, seen),
            "super" => return self.defines(module.split_last()?.1, rest, seen),
            _ => {}
        }
        let here = self.modules.get(module)?;
        let child = [module, std::slice::from_ref(first)].concat();
        if !rest.is_empty() && self.modules.contains_key(&child) {
            return self.defines(&child, rest, seen);
        }
        match here.names.get(first) {
            Some(Meaning::Item) => Some(&here.file),
            Some(Meaning::Path(to)) => self.defines(module, &[to, rest].concat(), seen),
            None => here.globs.iter().find_map(|to| self.defines(module, &[to, path].concat(), seen)),
        }
    }

    /// Which files each file imports.
    fn imports(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let mut imports = BTreeMap::<&Path, BTreeSet<&Path>>::new();
        for (name, module) in &self.modules {
            let of = module.asked.iter().filter_map(|path| self.defines(name, path, &mut BTreeSet::new()));
            let own = imports.entry(&module.file).or_default();
            own.extend(of.filter(|file| *file != module.file));
        }
        imports
    }
}

/// The shortest circle, its first file again at its end.
fn shortest<'a>(imports: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> Option<Vec<&'a Path>> {
    let back_to = |start: &'a Path| {
        let mut reached = BTreeMap::new();
        let mut next = VecDeque::from([start]);
        while let Some(file) = next.pop_front() {
            for to in imports.get(file).into_iter().flatten() {
                if *to == start {
                    let mut way = vec![start, file];
                    while way[way.len() - 1] != start {
                        way.push(reached[way[way.len() - 1]]);
                    }
                    way.reverse();
                    return Some(way);
                }
                reached.entry(*to).or_insert_with(|| {
                    next.push_back(*to);
                    file
                });
            }
        }
        None
    };
    imports.keys().filter_map(|file| back_to(file)).min_by_key(Vec::len)
}

/// The crates of the workspace by their root files.
fn roots() -> Vec<PathBuf> {
    let manifest = |folder: &str| -> toml::Table {
        toml::from_str(&crate::read(&format!("{folder}/Cargo.toml"))).unwrap()
    };
    let workspace = manifest(".");
    let members = workspace["workspace"]["members"].as_array().unwrap().iter();
    let folders = members.map(|member| member.as_str().unwrap().to_owned()).chain([".".to_owned()]);
    folders.map(|folder| at(&folder).join(manifest(&folder)["lib"]["path"].as_str().unwrap())).collect()
}

#[test]
fn no_file_imports_itself_through_others() {
    let mut found = Vec::new();
    let base = at("");
    for root in roots() {
        let all = Crate::read(&root);
        if let Some(circle) = shortest(&all.imports()) {
            let names =
                circle.iter().map(|file| file.strip_prefix(&base).unwrap_or(file).display().to_string());
            found.push(names.collect::<Vec<_>>().join(" -> "));
        }
    }
    assert!(found.is_empty(), "files that import each other in a circle:\n{}", found.join("\n"));
}

#[test]
fn a_circle_is_found_through_re_exports_globs_and_plain_paths_and_none_in_tests_and_words() {
    let root = std::env::temp_dir().join(format!("dpn-circles-{}", std::process::id()));
    let circle = |files: &[(&str, &str)]| {
        std::fs::create_dir_all(root.join("a")).unwrap();
        for (name, text) in files {
            std::fs::write(root.join(name), text).unwrap();
        }
        let all = Crate::read(&root.join("lib.rs"));
        let found = shortest(&all.imports());
        let within = |files: Vec<&Path>| {
            files.iter().map(|f| f.strip_prefix(&root).unwrap().to_owned()).collect::<Vec<_>>()
        };
        let found = found.map(within);
        std::fs::remove_dir_all(&root).unwrap();
        found.unwrap_or_default()
    };
    let lib = ("lib.rs", "mod a;\nmod b;\npub use a::One;\n");
    let a = ("a/mod.rs", "mod one;\npub use one::One;\n");
    let of = |one: &'static str, b: &'static str| circle(&[lib, a, ("a/one.rs", one), ("b.rs", b)]);
    let back = ["a/one.rs", "b.rs", "a/one.rs"].map(PathBuf::from);
    let two = "use crate::One;\npub struct Two(One);\n";
    assert_eq!(of("use crate::b::Two;\npub struct One;\n", two), back);
    assert_eq!(of("pub struct One;\nfn f() -> usize { size_of::<super::super::b::Two>() }\n", two), back);
    assert_eq!(of("use crate::b::*;\npub struct One(Two);\n", "pub struct Two;\n"), [] as [PathBuf; 0]);
    for no_import in [
        "pub struct One;\n#[cfg(test)]\nmod tests {\n    use crate::b::Two;\n}\n",
        "/// As [`crate::b::Two`].\npub struct One;\nconst A: &str = \"crate::b::Two\"; // crate::b::Two\n",
        "use std::b::Two;\npub struct One;\n",
    ] {
        assert_eq!(of(no_import, two), [] as [PathBuf; 0], "{no_import}");
    }
}
