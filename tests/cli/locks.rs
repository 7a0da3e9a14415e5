//! One writer a folder: the second is told who holds it, and changes nothing.

use crate::recording::sound;
use crate::run::{dpn, end, files};
use crate::training::tiny;
use dpn_io::FolderLock;
use std::path::Path;
use std::process::Command;

/// Checks that `command` finds `held` taken, and leaves it as it is.
#[track_caller]
fn is_refused(command: &mut Command, held: &Path) {
    let lock = FolderLock::take(held).unwrap();
    let before = files(held);
    let done = end(command);
    assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{done:?}");
    let error = done.stderr.lines().find(|line| line.starts_with("error: ")).unwrap();
    let words = format!(
        "error: {}: another dpn writes there (process {}, since ",
        held.display(),
        std::process::id()
    );
    assert!(error.starts_with(&words) && error.ends_with(" UTC)"), "{error}");
    let hint = "hint: wait until that one is over, stop it, or name another folder for this one";
    assert_eq!(done.stderr.trim_end().lines().last(), Some(hint), "{}", done.stderr);
    assert!(files(held) == before, "it wrote there");
    drop(lock);
    assert!(!held.exists(), "the lock left something");
}

#[test]
fn a_second_writer_is_refused_by_name_and_writes_nothing() {
    let tmp = tempfile::tempdir().unwrap();
    let (dir, out) = (tmp.path(), tmp.path().join("out"));
    let data = sound(dir);
    is_refused(&mut tiny(dir, &data, 1, &out), &out);
    let mut sweep = dpn();
    sweep.args(["eval", "--closed-loop", "--sequences", "hover", "--noise", "x4", "--out"]).arg(&out);
    is_refused(&mut sweep, &out);
    let mut open = dpn();
    open.args(["eval", "--open-loop", "--bases", "sg(11,2)", "--data"]).arg(&data).arg("--out").arg(&out);
    is_refused(&mut open, &out);
    for held in ["--work", "--out"] {
        let mut paper = dpn();
        paper.args(["paper", "--quick", "--sequences", "hover"]).arg(held).arg(&out);
        let other = if held == "--out" { "--work" } else { "--out" };
        is_refused(paper.arg(other).arg(dir.join("other")), &out);
        assert!(!dir.join("other").exists(), "{held}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_a_killed_command_left_is_cleared_by_the_next_and_what_a_living_one_writes_is_not() {
    let tmp = tempfile::tempdir().unwrap();
    let data = sound(tmp.path());
    let log = data.join("still");
    for words in [&["check"][..], &["noise", "--noise", "diff2"], &["allan", "--all"]] {
        let out = tmp.path().join(words[0]);
        std::fs::create_dir(&out).unwrap();
        // Linux gives no process so high a number; the second is this test's own, the third's file is being written.
        let alive = format!(".dpn-{}-x.tmp", std::process::id());
        let (dead, held) = (".dpn-4194999-x.tmp", ".dpn-4194998-x.tmp");
        for name in [dead, &alive, held] {
            std::fs::write(out.join(name), "half").unwrap();
        }
        let held_by = std::fs::File::open(out.join(held)).unwrap();
        held_by.try_lock().unwrap();
        end(dpn().args(words).arg(&log).arg("--out").arg(&out)).well();
        let there = |name: &str| out.join(name).exists();
        assert!(!there(dead) && there(&alive) && there(held), "{words:?}");
    }
}
