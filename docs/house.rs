//! ARCHITECTURE.md's arrows, held to the manifests: which crate of the workspace may use which, who alone sees the heavy third-party crates, and
//! that each dependency has its reason there.

use crate::{at, read};
use std::collections::BTreeSet;
use toml::Table;

/// Every crate that ships and what it may use of the workspace, from the ground up.
const ARROWS: [(&str, &[&str]); 23] = [
    ("src/fft", &[]),
    ("src/core", &["dpn-fft"]),
    ("src/io", &["dpn-core"]),
    ("src/logs", &["dpn-core", "dpn-io"]),
    ("src/pronet", &["dpn-core"]),
    ("src/gpu", &["dpn-core", "dpn-pronet"]),
    ("src/noise", &["dpn-core", "dpn-io", "dpn-pronet"]),
    ("src/probe", &["dpn-core", "dpn-io", "dpn-logs", "dpn-noise", "dpn-pronet"]),
    ("src/sim", &["dpn-core"]),
    ("src/vio", &["dpn-core"]),
    ("src/live", &["dpn-core", "dpn-io", "dpn-noise", "dpn-pronet", "dpn-vio"]),
    ("src/truth", &["dpn-core", "dpn-vio"]),
    ("src/inertial", &["dpn-core", "dpn-onnx", "dpn-pronet", "dpn-truth", "dpn-vio"]),
    ("src/onnx", &["dpn-core", "dpn-pronet"]),
    ("src/ros2", &["dpn-core", "dpn-io", "dpn-logs"]),
    ("train", &["dpn-core", "dpn-gpu", "dpn-io", "dpn-pronet", "dpn-sim"]),
    (
        "eval",
        &[
            "dpn-core",
            "dpn-io",
            "dpn-live",
            "dpn-logs",
            "dpn-noise",
            "dpn-pronet",
            "dpn-sim",
            "dpn-train",
            "dpn-vio",
        ],
    ),
    ("figures", &["dpn-core", "dpn-eval", "dpn-io", "dpn-probe", "dpn-train", "dpn-vio"]),
    (
        "papers",
        &["dpn-core", "dpn-eval", "dpn-figures", "dpn-io", "dpn-pronet", "dpn-sim", "dpn-train", "dpn-vio"],
    ),
    ("c", &["dpn-core", "dpn-inertial", "dpn-live", "dpn-pronet", "dpn-vio"]),
    ("web", &["dpn-core", "dpn-io", "dpn-logs", "dpn-probe", "dpn-pronet"]),
    (
        "python",
        &[
            "dpn-core",
            "dpn-eval",
            "dpn-inertial",
            "dpn-io",
            "dpn-live",
            "dpn-logs",
            "dpn-noise",
            "dpn-probe",
            "dpn-pronet",
            "dpn-sim",
            "dpn-train",
            "dpn-vio",
        ],
    ),
    ("tests/support", &[]),
];

/// Third-party crates that one room keeps to itself.
const SEEN_BY: [(&str, &[&str]); 8] = [
    ("burn", &["src/pronet"]),
    ("cubecl", &["src/gpu"]),
    ("linfa", &["train"]),
    ("clarabel", &["src/probe"]),
    ("plotters", &["figures"]),
    ("clap", &[]),
    ("indicatif", &[]),
    ("rustdds", &["src/ros2"]),
];

fn manifest(folder: &str) -> Table {
    toml::from_str(&read(&format!("{folder}/Cargo.toml"))).unwrap_or_else(|error| panic!("{folder}: {error}"))
}

fn dependencies(manifest: &Table) -> BTreeSet<String> {
    manifest
        .get("dependencies")
        .and_then(toml::Value::as_table)
        .map(|t| t.keys().cloned().collect())
        .unwrap_or_default()
}

#[test]
fn crates_use_what_lies_below_them_and_nothing_else() {
    for (folder, may) in ARROWS {
        let used = dependencies(&manifest(folder));
        let of_ours: Vec<&String> = used.iter().filter(|name| name.starts_with("dpn-")).collect();
        let beyond: Vec<_> = of_ours.iter().filter(|name| !may.contains(&name.as_str())).collect();
        assert!(beyond.is_empty(), "{folder} uses {beyond:?}; ARCHITECTURE.md has no such arrow");
        for (name, rooms) in SEEN_BY {
            assert!(!used.contains(name) || rooms.contains(&folder), "{folder} sees {name}");
        }
    }
}

#[test]
fn every_member_of_the_workspace_is_looked_at() {
    let members: BTreeSet<String> = manifest(".")["workspace"]["members"]
        .as_array()
        .unwrap()
        .iter()
        .map(|member| member.as_str().unwrap().to_owned())
        .collect();
    let known = ARROWS.iter().map(|(folder, _)| (*folder).to_owned()).chain(["bench".into(), "docs".into()]);
    assert_eq!(members, known.collect());
}

#[test]
fn every_dependency_has_its_reason_in_the_architecture() {
    let text = read("ARCHITECTURE.md");
    let (_, table) = text.split_once("## Dependencies, each with its reason").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let words: BTreeSet<&str> =
        table.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).collect();
    for name in manifest(".")["workspace"]["dependencies"].as_table().unwrap().keys() {
        assert!(name.starts_with("dpn-") || words.contains(name.as_str()), "{name} has no reason");
    }
}

#[test]
fn a_trained_network_is_asked_with_sixty_three_crates_at_most() {
    let line = "tree --locked --offline -p dpn-pronet --no-default-features -e normal,build --prefix none";
    let mut cargo = std::process::Command::new(env!("CARGO"));
    let done = cargo.args(line.split(' ')).current_dir(at("")).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = String::from_utf8(done.stdout).unwrap();
    // A crate's second mention is marked, and so are procedural macros.
    let crates: BTreeSet<String> =
        text.lines().map(|line| line.split(' ').take(2).collect::<Vec<_>>().join(" ")).collect();
    assert!(crates.len() <= 63, "{}: {crates:?}", crates.len());
}
