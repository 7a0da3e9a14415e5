//! Folders of results that others can write to: at every path that a command writes a link or a pipe was planted. Nothing is followed and nothing waits.
#![cfg(unix)]

use crate::recording::{put, rows, sound, text};
use crate::run::{Done, dpn, files, finished};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// What a link leads to.
const DECOY: &str = "somebody's own";

/// Two platforms, two seconds of a flight each.
const FLEET: &str = "constants = [\"x1\"]\nnoises = [\"x4\"]\n\
    [[platform]]\nname = \"a\"\nfolder = \"a\"\nrun = { sequences = \"room-medium\", from = 70.0, to = 72.0 }\n\
    [[platform]]\nname = \"b\"\nfolder = \"b\"\nrun = { sequences = \"room-medium\", from = 80.0, to = 82.0 }\n";

/// Two runs over two seconds of a flight, with a file beside each row.
pub(crate) const PLAN: &str = "kind = \"closed-loop\"\nsequences = \"room-medium\"\nnoises = [\"x4\", \"x1\"]\nfrom = 70\nto = 72\ntrajectories = true\n";

/// Runs `dpn` in `dir`, which must not wait.
fn call(dir: &Path, words: &[&str]) -> Done {
    let mut command = dpn();
    command.current_dir(dir).args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(240) {
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

/// Runs `words` in a new folder that `prepare` made up for every file that they write to `out`, the file planted; folders on the way too. At most for so many
/// of them, from all over.
fn planted(prepare: &dyn Fn(&Path), words: &[&str], out: &str, seldom: &[&str], most: usize) -> usize {
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
    let every = all.len().div_ceil(most).max(1);
    all = all.into_iter().step_by(every).collect();
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
        if ["trajectories/", "states/"].iter().any(|cells| name.contains(cells)) {
            assert_eq!(done.code, Some(0), "{name}: {done:?}");
            assert!(std::fs::symlink_metadata(&path).unwrap().is_file(), "{name}");
        } else if !name.ends_with("running.json") {
            assert_eq!(done.code, Some(2), "{name}: {done:?}");
            // Or nothing may be in the folder at all.
            let named = done.stderr.contains(&format!("{out}/{name}: a "))
                && done.stderr.contains("hint: see who put it there; remove it");
            assert!(
                named || done.stderr.contains(&format!("{out} is there already")),
                "{name}: {}",
                done.stderr
            );
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
    let run = planted(&prepare, &["sweep", "run", "s", "--shard", "0"], "s", &accounts, usize::MAX);
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

/// Commands that write to a folder, each with it, and how many paths of it are tried where every commit is tested.
const WRITERS: [(&str, &str, usize); 20] = [
    ("noise log/still --noise diff2 --out out", "out", 3),
    ("allan log/still --out out", "out", 1),
    ("check log/still --out out", "out", 1),
    ("compare log/still log/again --out out", "out", 1),
    ("manual --out out", "out", 1),
    ("export onnx --network sg11-s0 --out out", "out", 1),
    ("simulate images room-medium --from 70 --to 70.2 --out out", "out", 3),
    ("run data/f07-room-medium --camera tracks --from 2 --to 6 --out out", "out", 2),
    ("simulate flight f07-room-medium --out out", "out", 0),
    ("truth data/f07-room-medium --out out", "out", 0),
    ("train --sensor accel --config network.toml --data log --epochs 2 --out out", "out", 0),
    (
        "eval --closed-loop --data data --camera tracks --from 2 --to 5 --noise x4 --trajectories --out out",
        "out",
        0,
    ),
    ("eval --open-loop --data log --sensor accel --bases sg(11,2) --out out", "out", 0),
    ("noise data/f07-room-medium --against truth.csv --out out", "out", 1),
    ("fit data/f07-room-medium --against truth.csv --out out", "out", 0),
    ("ape data/f07-room-medium truth.csv --save_plot out/errors.svg", "out", 4),
    ("rpe data/f07-room-medium truth.csv --save_plot out/errors.svg", "out", 0),
    ("run data/f07-room-medium --camera tracks --from 2 --to 6 --out runs --draw out", "out", 0),
    ("fleet fleet.toml --out out", "out", 0),
    ("paper --plan paper.toml --data data --camera tracks --from 10 --out out --work work", "work", 0),
];

/// What they read.
fn inputs(dir: &Path) {
    static FLOWN: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
        let tmp = tempfile::tempdir().unwrap();
        call(tmp.path(), &["simulate", "flight", "f07-room-medium", "--out", "data"]).well();
        dpn_testing::cut_asl(&tmp.path().join("data"), 70.0, 85.0);
        tmp
    });
    sound(dir);
    put(&dir.join("log"), "again", &text(&rows(3000, 5_000_000)));
    symlink(FLOWN.path().join("data"), dir.join("data")).unwrap();
    std::fs::write(dir.join("network.toml"), include_str!("../data/tiny_network.toml")).unwrap();
    std::fs::write(dir.join("paper.toml"), include_str!("../data/least_plan.toml")).unwrap();
    std::fs::write(dir.join("fleet.toml"), FLEET).unwrap();
    let truth = "data/f07-room-medium/mav0/state_groundtruth_estimate0/data.csv";
    std::fs::copy(dir.join(truth), dir.join("truth.csv")).unwrap();
}

#[test]
fn no_command_follows_anything_in_the_folder_that_it_writes_to() {
    for (line, out, most) in WRITERS.iter().filter(|(.., most)| *most > 0) {
        let words: Vec<&str> = line.split(' ').collect();
        assert!(planted(&inputs, &words, out, &[], *most) >= *most, "{line}");
    }
}

#[test]
#[ignore = "minutes; every path of every command"]
fn no_command_follows_anything_at_any_path() {
    let mut all = 0;
    for (line, out, _) in WRITERS {
        let words: Vec<&str> = line.split(' ').collect();
        let tried = planted(&inputs, &words, out, &[], usize::MAX);
        eprintln!("{tried} paths of dpn {line}");
        all += tried;
    }
    eprintln!("{all} paths, none followed");
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
