//! Folders of results that others can write to: at every path that a command writes a link or a pipe was planted. Nothing is followed and nothing waits.
#![cfg(unix)]

use crate::recording::sound;
use crate::run::{Done, dpn, files, finished};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a link leads to.
const DECOY: &str = "somebody's own";

/// Two runs over two seconds of a flight, with a file beside each row.
pub(crate) const PLAN: &str = "kind = \"closed-loop\"\nsequences = \"room-medium\"\nnoises = [\"x4\", \"x1\"]\nfrom = 70\nto = 72\ntrajectories = true\n";

/// Runs `dpn` in `dir`, which must not wait.
fn call(dir: &Path, words: &[&str]) -> Done {
    let mut command = dpn();
    command.current_dir(dir).args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("{words:?} waits");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    finished(child.wait_with_output().unwrap())
}

/// What is planted.
#[derive(Clone, Copy)]
enum Plant {
    Link,
    Dangling,
    Pipe,
}

impl Plant {
    fn at(self, path: &Path, dir: &Path) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let _ = std::fs::remove_file(path);
        match self {
            Self::Link => symlink(dir.join("decoy"), path).unwrap(),
            Self::Dangling => symlink(dir.join("nothing"), path).unwrap(),
            Self::Pipe => assert!(Command::new("mkfifo").arg(path).status().unwrap().success()),
        }
    }
}

/// Runs `words` in a new folder that `prepare` made up for every file that they write to `out`, the file planted; folders on the way too.
fn planted(prepare: &dyn Fn(&Path), words: &[&str], out: &str, seldom: &[&str]) -> usize {
    let whole = tempfile::tempdir().unwrap();
    prepare(whole.path());
    let before = files(whole.path());
    call(whole.path(), words).well();
    let mut names: Vec<String> = files(&whole.path().join(out)).into_keys().collect();
    names.retain(|name| !before.contains_key(&format!("{out}/{name}")));
    let folders: Vec<String> = names
        .iter()
        .filter_map(|name| Some(Path::new(name).parent()?.to_str()?.to_owned()))
        .filter(|folder| !folder.is_empty())
        .collect();
    names.extend(seldom.iter().map(|name| (*name).to_owned()));
    let mut all: Vec<(String, bool)> = names.into_iter().map(|name| (name, false)).collect();
    all.extend(folders.into_iter().map(|name| (name, true)));
    all.sort();
    all.dedup();
    for (place, (name, is_folder)) in all.iter().enumerate() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path();
        prepare(dir);
        std::fs::create_dir(dir.join("elsewhere")).unwrap();
        std::fs::write(dir.join("decoy"), DECOY).unwrap();
        let path = dir.join(out).join(name);
        if *is_folder {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            symlink(dir.join("elsewhere"), &path).unwrap();
        } else {
            [Plant::Link, Plant::Pipe, Plant::Dangling][place % 3].at(&path, dir);
        }
        let done = call(dir, words);
        // Who cannot say that it is at work works all the same; a cell's own files are taken away before it is run, and of a link the link goes.
        if name.ends_with(".tum") {
            assert_eq!(done.code, Some(0), "{name}: {done:?}");
            assert!(std::fs::symlink_metadata(&path).unwrap().is_file(), "{name}");
        } else if !name.ends_with("running.json") {
            assert_eq!(done.code, Some(2), "{name}: {done:?}");
            assert!(done.stderr.contains(&format!("{out}/{name}: a ")), "{name}: {}", done.stderr);
            assert!(done.stderr.contains("hint: see who put it there; remove it"), "{name}: {}", done.stderr);
        }
        assert_eq!(std::fs::read_to_string(dir.join("decoy")).unwrap(), DECOY, "{name}");
        assert!(!dir.join("nothing").exists(), "{name}");
        assert_eq!(std::fs::read_dir(dir.join("elsewhere")).unwrap().count(), 0, "{name}");
    }
    all.len()
}

#[test]
fn a_sweep_follows_nothing_that_was_planted_in_its_folder() {
    let prepare = |dir: &Path| {
        std::fs::write(dir.join("plan.toml"), PLAN).unwrap();
        call(dir, &["sweep", "plan", "plan.toml", "--shards", "1", "--out", "s"]).well();
    };
    let accounts = ["shards/0/.dpn.lock", "shards/0/running.json", "shards/0/failed.jsonl", "shards"];
    let run = planted(&prepare, &["sweep", "run", "s", "--shard", "0"], "s", &accounts);
    assert!(run >= 9, "{run} paths");
}

#[test]
fn collecting_follows_nothing_and_reads_nothing_outside_a_shards_folder() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    std::fs::write(dir.join("plan.toml"), PLAN).unwrap();
    call(dir, &["sweep", "plan", "plan.toml", "--shards", "1", "--out", "s"]).well();
    call(dir, &["sweep", "run", "s", "--shard", "0"]).well();
    std::fs::write(dir.join("decoy"), DECOY).unwrap();
    let account = dir.join("s/shards/0/shard.json");
    let whole = std::fs::read_to_string(&account).unwrap();
    let sum = dpn_papers::id([DECOY]);
    // The account names a file elsewhere.
    for name in ["../../../decoy".to_owned(), dir.join("decoy").display().to_string()] {
        let told = whole.replacen("\"files\":{", &format!("\"files\":{{\"{name}\":\"{sum}\","), 1);
        assert_ne!(told, whole);
        std::fs::write(&account, told).unwrap();
        for words in [&["sweep", "collect", "s", "--out", "all"][..], &["sweep", "run", "s", "--shard", "0"]]
        {
            let done = call(dir, words);
            assert_eq!(done.code, Some(2), "{name}: {done:?}");
            assert!(done.stderr.contains(" is not below s, where results lie"), "{name}: {}", done.stderr);
        }
        assert_eq!(std::fs::read_to_string(dir.join("decoy")).unwrap(), DECOY, "{name}");
    }
    std::fs::write(&account, &whole).unwrap();
    // What a shard reads beside its cells.
    std::fs::create_dir_all(dir.join("s/truth")).unwrap();
    std::fs::remove_dir_all(dir.join("s/shards")).unwrap();
    Plant::Pipe.at(&dir.join("s/truth/f07-room-medium.csv"), dir);
    let done = call(dir, &["sweep", "run", "s", "--shard", "0"]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("s/truth/f07-room-medium.csv: a pipe"), "{}", done.stderr);
    std::fs::remove_dir_all(dir.join("s/truth")).unwrap();
    call(dir, &["sweep", "run", "s", "--shard", "0"]).well();
    // What is collected into.
    for (name, plant) in
        [("rows.jsonl", Plant::Link), ("run.json", Plant::Pipe), ("closed_loop.txt", Plant::Dangling)]
    {
        plant.at(&dir.join("all").join(name), dir);
        let done = call(dir, &["sweep", "collect", "s", "--out", "all"]);
        assert_eq!(done.code, Some(2), "{name}: {done:?}");
        assert!(done.stderr.contains(&format!("all/{name}: a ")), "{name}: {}", done.stderr);
        std::fs::remove_file(dir.join("all").join(name)).unwrap();
    }
    assert_eq!(std::fs::read_to_string(dir.join("decoy")).unwrap(), DECOY);
    assert!(!dir.join("nothing").exists());
    // The folder that was named may be a link itself.
    std::fs::remove_dir_all(dir.join("all")).unwrap();
    std::fs::create_dir(dir.join("real")).unwrap();
    symlink("real", dir.join("all")).unwrap();
    call(dir, &["sweep", "collect", "s", "--out", "all"]).well();
    assert!(dir.join("real/rows.jsonl").is_file());
}

#[test]
fn a_command_without_a_lock_follows_nothing_in_the_folder_that_it_writes_to() {
    let prepare = |dir: &Path| {
        sound(dir);
    };
    let log = sound(tempfile::tempdir().unwrap().path());
    let log = log.file_name().unwrap().to_str().unwrap();
    let log = format!("{log}/still");
    let words = ["noise", &log, "--noise", "diff2", "--out", "out"];
    assert!(planted(&prepare, &words, "out", &[]) >= 3);
}

#[test]
fn a_folder_whose_name_is_no_text_is_an_error_and_no_panic() {
    use std::os::unix::ffi::OsStrExt;
    let tmp = tempfile::tempdir().unwrap();
    let odd = tmp.path().join(std::ffi::OsStr::from_bytes(b"da\xfftum"));
    let data = sound(tmp.path());
    std::fs::rename(data, &odd).unwrap();
    let plan = "kind = \"train\"\nsensors = [\"accel\"]\nseeds = 1\n";
    std::fs::write(tmp.path().join("plan.toml"), plan).unwrap();
    let mut command = dpn();
    command
        .current_dir(tmp.path())
        .args(["sweep", "plan", "plan.toml", "--shards", "1", "--out", "s", "--data"])
        .arg(&odd);
    let done = crate::run::end(&mut command);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("not called by text (UTF-8)"), "{}", done.stderr);
    assert!(!done.stderr.contains("panicked"), "{}", done.stderr);
}
