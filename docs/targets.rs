//! `targets.csv`, a row a target: the page of all targets is made from it. Figures of commands that leave results are [marked](crate::numbers).
//!
//! `cargo xtask book` writes the page anew.

use crate::numbers::{TARGETS as SOURCE, plain};
use crate::{at, read};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fmt::Write;

const PAGE: &str = "docs/src/targets.md";
/// What a command may begin with.
const PROGRAMS: [&str; 11] = [
    "dpn",
    "cargo",
    "ls",
    ".ci/run",
    "web/test/run",
    "python/test/run",
    "src/ros2/tests/run",
    "figures/check_page",
    "golden/house/make.sh",
    "bench/latency.py",
    ".github/artefacts",
];

/// One row of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    id: String,
    topic: String,
    target: String,
    figure: String,
    met: Met,
    command: String,
    commit: String,
    machine: String,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Met {
    Yes,
    Partly,
    No,
}

impl Met {
    fn word(self) -> &'static str {
        match self {
            Met::Yes => "yes",
            Met::Partly => "partly",
            Met::No => "**no**",
        }
    }
}

fn targets() -> Vec<Target> {
    let text = read(SOURCE);
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    rows.map(|row| row.unwrap_or_else(|error| panic!("{SOURCE}: {error}"))).collect()
}

/// The page of the book: a table a topic, in the file's order.
fn page(targets: &[Target]) -> String {
    let count = |met| targets.iter().filter(|t| t.met == met).count();
    let mut text = format!(
        "# Every target\n\n\
         <!-- made from docs/targets.csv by `cargo xtask book` -->\n\n\
         {} targets: {} met, {} in part, {} not. What a commit and a machine mean here is said [on the first page](index.md#how-to-read-the-figures).\n",
        targets.len(),
        count(Met::Yes),
        count(Met::Partly),
        count(Met::No),
    );
    let mut topic = "";
    for t in targets {
        if t.topic != topic {
            topic = &t.topic;
            let _ = write!(
                text,
                "\n## {topic}\n\n| target | figure | met | command | commit | machine |\n|---|---|---|---|---|---|\n"
            );
        }
        let Target { target, command, commit, machine, .. } = t;
        let figure = plain(&t.figure);
        let _ =
            writeln!(text, "| {target} | {figure} | {} | `{command}` | {commit} | {machine} |", t.met.word());
    }
    text
}

/// Names of the workspace's packages.
fn packages() -> BTreeSet<String> {
    let name = |manifest: &str| {
        let line = manifest.lines().find_map(|line| line.strip_prefix("name = "));
        line.expect("a package has a name").trim_matches('"').to_owned()
    };
    let root = read("Cargo.toml");
    let members =
        root.lines().find_map(|line| line.strip_prefix("members = ")).expect("the workspace has members");
    let members = members.trim_matches(['[', ']']).split(", ").map(|m| m.trim_matches('"'));
    members.map(|m| name(&read(&format!("{m}/Cargo.toml")))).chain([name(&root)]).collect()
}

#[test]
fn the_page_of_targets_is_as_the_file_has_it() {
    let made = page(&targets());
    if std::env::var_os("DPN_BLESS").is_some() {
        std::fs::write(at(PAGE), made).unwrap();
        return;
    }
    assert!(read(PAGE) == made, "{PAGE} is not what {SOURCE} says; `cargo xtask book` writes it anew");
}

#[test]
fn every_target_has_a_figure_that_a_command_measured_at_a_commit() {
    let (mut ids, mut topics, packages) = (BTreeSet::new(), Vec::<String>::new(), packages());
    for t in targets() {
        let cells = [&t.id, &t.topic, &t.target, &t.figure, &t.command, &t.commit, &t.machine];
        assert!(
            cells.iter().all(|cell| cell.trim() == **cell && !cell.is_empty() && !cell.contains(['|', '\n'])),
            "{}: an empty or broken cell",
            t.id
        );
        assert!(ids.insert(t.id.clone()), "{} stands twice", t.id);
        assert!(
            t.commit.len() == 7 && t.commit.chars().all(|c| matches!(c, '0'..='9' | 'a'..='f')),
            "{}: {} is no commit",
            t.id,
            t.commit
        );

        let words: Vec<&str> = t.command.split_whitespace().collect();
        assert!(PROGRAMS.contains(&words[0]), "{}: `{}` is none of {PROGRAMS:?}", t.id, words[0]);
        for pair in words.windows(2).filter(|pair| words[0] == "cargo" && pair[0] == "-p") {
            assert!(packages.contains(pair[1]), "{}: there is no package {}", t.id, pair[1]);
        }
        for path in words
            .iter()
            .filter(|word| ["configs/", "models/", "golden/"].iter().any(|folder| word.starts_with(folder)))
        {
            assert!(at(path).exists(), "{}: there is no {path}", t.id);
        }

        if topics.last() != Some(&t.topic) {
            assert!(!topics.contains(&t.topic), "{}: the topic {:?} begins twice", t.id, t.topic);
            topics.push(t.topic);
        }
    }
}
