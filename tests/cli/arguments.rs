//! Help, versions and words that are no arguments.

use crate::recording::sound;
use crate::run::{end, run};
use crate::training::{tiny, with};

/// The commands that a help text lists.
fn commands(help: &str) -> Vec<String> {
    let listed =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let first = |line: &str| line.strip_prefix("  ")?.split(' ').next().map(str::to_owned);
    listed.filter_map(first).filter(|name| !name.is_empty() && name != "help").collect()
}

#[test]
fn every_command_has_a_help_that_ends_well() {
    let mut open = vec![String::new()];
    let mut seen = Vec::new();
    while let Some(path) = open.pop() {
        let done = run(&format!("{path} --help")).well();
        assert!(done.stdout.contains("Usage: dpn") && done.stderr.is_empty(), "{done:?}");
        open.extend(commands(&done.stdout).iter().map(|name| format!("{path} {name}")));
        seen.push(path.trim().to_owned());
    }
    for name in ["train", "run", "simulate", "simulate flight", "simulate tracks"] {
        assert!(seen.contains(&name.to_owned()), "{seen:?}");
    }
}

#[test]
fn the_version_is_the_packages() {
    assert_eq!(run("--version").well().stdout.trim(), concat!("dpn ", env!("CARGO_PKG_VERSION")));
}

#[test]
fn words_that_are_no_arguments_exit_with_2() {
    for line in [
        "",
        "fly",
        "train",
        "train --sensor sonar",
        "train --sensor accel --base sg(11)",
        "run",
        "simulate flight",
        "simulate tracks",
    ] {
        let done = run(line);
        assert_eq!(done.code, Some(2), "{line}: {done:?}");
        assert_eq!(done.stdout, "", "{line}: {done:?}");
        assert!(done.stderr.contains("Usage: dpn") || done.stderr.contains("--help"), "{line}: {done:?}");
    }
}

#[test]
fn an_unknown_device_names_the_known_ones() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let done = end(&mut with(tiny(dir.path(), &sound(dir.path()), 1, &out), &["--device", "abacus"]));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(
        done.stderr.starts_with("error: there is no device `abacus`\n\nhint: known here: cpu"),
        "{done:?}"
    );
    assert!(!out.exists());
}

#[cfg(not(feature = "wgpu"))]
#[test]
fn a_device_that_was_not_built_names_its_feature() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let done = end(&mut with(tiny(dir.path(), &sound(dir.path()), 1, &out), &["--device", "wgpu"]));
    done.refused(
        dir.path(),
        "error: this dpn was built without the device `wgpu`\n\nhint: a release's archive that ends in -wgpu has it, or build with `--features wgpu`",
    );
    assert!(!out.exists());
}
