//! `dpn sweep`: a closed loop, a paper and trainings in shards, on seconds of simulated flights.

use crate::paper::flights;
use crate::recording;
use crate::run::{Done, dpn, end, files, run};
use crate::training::{TINY, config, tiny, weights};
use dpn_io::FolderLock;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Twelve runs over three seconds of two flights, enough for a start and for statistics; with files beside their rows.
const PLAN: &str = "kind = \"closed-loop\"\nsequences = \"room-medium,room-spiral\"\nnoises = [\"x4\", \"diff2\", \"shuffled(diff2)\"]\n\
    seeds = 2\nfrom = 70\nto = 73\ntrajectories = true\nestimator = { covariance = true }\n";
/// The same as flags.
const FLAGS: &str = "eval --closed-loop --sequences room-medium,room-spiral --noise x4;diff2;shuffled(diff2) --seeds 2 --from 70 --to 73 \
    --trajectories --set covariance=true";

/// `dpn` with the words of `line`, called in `dir`.
fn call(dir: &Path, line: &str) -> Done {
    end(&mut command(dir, line))
}

fn command(dir: &Path, line: &str) -> Command {
    let mut command = dpn();
    command.current_dir(dir).args(line.split_whitespace()).env_remove("SLURM_ARRAY_TASK_ID");
    command
}

/// Plans `text` in `dir` into the sweep `s`.
fn plan(dir: &Path, text: &str, size: &str) -> Done {
    std::fs::write(dir.join("plan.toml"), text).unwrap();
    call(dir, &format!("sweep plan plan.toml {size} --out s"))
}

/// A folder's files, rows without the times that they took; tables, which tell these times, are left out.
fn lasting(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = files(dir);
    all.retain(|name, _| !name.contains("closed_loop."));
    for (_, bytes) in all.iter_mut().filter(|(name, _)| name.ends_with("rows.jsonl")) {
        let untimed = |line: &str| {
            let mut row: Value = serde_json::from_str(line).unwrap();
            for timing in ["cpu_per_data_s", "p95_update_ms", "stage_s"] {
                assert!(row.as_object_mut().unwrap().remove(timing).is_some(), "no {timing}");
            }
            if let Some(front_end) = row["front_end"].as_object_mut() {
                front_end.retain(|name, _| !["cpu_per_data_s", "p95_ms"].contains(&name.as_str()));
            }
            row.to_string()
        };
        *bytes =
            std::str::from_utf8(bytes).unwrap().lines().map(untimed).collect::<Vec<_>>().join("\n").into();
    }
    all
}

#[track_caller]
fn equal(one: &Path, other: &Path) {
    let (one, other) = (lasting(one), lasting(other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(other[name] == *bytes, "{name} differs");
    }
}

fn copy(from: &Path, to: &Path) {
    for (name, bytes) in files(from) {
        let path = to.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// Changes the text of a file.
fn change(path: &Path, of: impl Fn(&str) -> String) {
    let text = std::fs::read_to_string(path).unwrap();
    let changed = of(&text);
    assert_ne!(changed, text);
    std::fs::write(path, changed).unwrap();
}

#[track_caller]
fn refused(done: &Done, words: &[&str]) {
    assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{done:?}");
    for words in words {
        assert!(done.stderr.contains(words), "{words}: {}", done.stderr);
    }
}

/// A sweep of three shards that were all run.
fn swept(dir: &Path) {
    plan(dir, PLAN, "--shards 3").well();
    call(dir, "sweep run s --shard all").well();
}

#[test]
fn three_shards_on_two_machines_are_what_one_process_leaves() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let said = plan(dir, PLAN, "--shards 3").well();
    assert!(
        said.stdout.contains("12 cells in 3 shards: ") && said.stdout.contains(" % idle"),
        "{}",
        said.stdout
    );
    call(dir, "sweep run s --shard 1 --threads 2").well();
    // Another machine is given the plan alone, and its shard is brought back.
    let away = dir.join("away");
    std::fs::create_dir_all(away.join("s")).unwrap();
    std::fs::copy(dir.join("s/sweep.json"), away.join("s/sweep.json")).unwrap();
    end(command(&away, "sweep run s").env("SLURM_ARRAY_TASK_ID", "2")).well();
    copy(&away.join("s/shards/2"), &dir.join("s/shards/2"));

    let missing = call(dir, "sweep collect s --out whole");
    refused(&missing, &["1 shard is missing: shard 0 (0 of ", "hint: dpn sweep run s --shard 0"]);
    assert!(!dir.join("whole").exists());
    let status = call(dir, "sweep status s --json").well().json();
    assert_eq!((&status["cells"], &status["shards"][0]["state"]), (&12.into(), &"waiting".into()));
    assert_eq!(status["shards"][2]["state"], "done");

    call(dir, "sweep run s --shard 0").well();
    let again = call(dir, "sweep run s --shard 0-2").well();
    assert_eq!(again.stderr.matches("cells, was there").count(), 3, "{}", again.stderr);
    let told = call(dir, "sweep collect s --out whole").well();
    call(dir, &format!("{FLAGS} --threads 1 --out one")).well();
    equal(&dir.join("one"), &dir.join("whole"));
    // Whoever goes on from there with `dpn eval` has nothing to run, and the same tables.
    let before = files(&dir.join("whole"));
    let same = call(dir, &format!("{FLAGS} --out whole")).well();
    assert!(same.stderr.contains("12 kept from whole, 0 run"), "{}", same.stderr);
    assert_eq!(same.stdout, told.stdout);
    assert!(files(&dir.join("whole")) == before);

    let other = call(dir, "sweep plan plan.toml --shards 4 --out s");
    refused(&other, &["error: s holds another sweep", "hint: give another folder"]);
}

#[test]
fn shards_that_keep_tracks_for_each_other_render_once_and_give_the_same_bytes() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let rendered = format!("{PLAN}camera = \"rendered\"\n");
    let planned = plan(dir, &rendered, "--shards 3 --json").well().json();
    assert_eq!(planned["planned"]["shards"], 3);
    let cache = "--cache kept";
    let told = call(dir, &format!("sweep run s --shard all {cache}")).well();
    let sums = "taken from kept, 4 made";
    assert!(told.stderr.contains(sums), "two sequences, two seeds: {}", told.stderr);
    call(dir, "sweep collect s --out whole").well();
    std::fs::remove_dir_all(dir.join("s/shards")).unwrap();
    call(dir, "sweep run s --shard all").well();
    call(dir, "sweep collect s --out again").well();
    equal(&dir.join("whole"), &dir.join("again"));
}

#[test]
fn damage_is_named_by_file_and_line_and_made_good_by_the_command_that_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    swept(dir);
    call(dir, "sweep collect s --out whole").well();
    let shard = dir.join("s/shards/1");
    // A digit of a result, in a row that still reads.
    change(&shard.join("rows.jsonl"), |text| {
        let (first, rest) = text.split_once('\n').unwrap();
        format!("{first}\n{}", rest.replacen("\"frames\":", "\"frames\":1", 1))
    });
    let done = call(dir, "sweep collect s --out again");
    refused(
        &done,
        &["s/shards/1/rows.jsonl:2: not the row", "hint: `dpn sweep run s --shard 1` makes it again"],
    );
    assert!(!dir.join("again").exists());
    call(dir, "sweep run s --shard 1").well();
    // A file beside rows, a row that is gone.
    let nees = files(&shard).into_keys().find(|name| name.starts_with("nees/")).unwrap();
    change(&shard.join(&nees), |text| text.replacen('1', "2", 1));
    refused(
        &call(dir, "sweep collect s --out again"),
        &[&nees, "`dpn sweep run s --shard 1` makes it again"],
    );
    call(dir, "sweep run s --shard 1").well();
    change(&shard.join("rows.jsonl"), |text| text[..text.trim_end().rfind('\n').unwrap() + 1].to_owned());
    refused(&call(dir, "sweep collect s --out again"), &["the file ends before the shard's last row"]);
    call(dir, "sweep run s --shard 1").well();
    assert!(!dir.join("again").exists(), "what was refused wrote something");
    call(dir, "sweep collect s --out again").well();
    equal(&dir.join("whole"), &dir.join("again"));
}

#[test]
fn shards_of_another_program_processor_or_sweep_are_refused_by_what_differs() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    swept(dir);
    let account = dir.join("s/shards/2/shard.json");
    let whole = std::fs::read_to_string(&account).unwrap();
    let collect = || call(dir, "sweep collect s --out whole");
    change(&account, |text| text.replacen("\"program\":\"dpn ", "\"program\":\"dpn 9.", 1));
    refused(
        &collect(),
        &["shard 2 (f", "was made with another program: dpn 9.", "--shard 2` makes it again"],
    );
    std::fs::write(&account, &whole).unwrap();
    change(&account, |text| text.replacen("\"processor\":\"", "\"processor\":\"vax-", 1));
    refused(&collect(), &["shard 2 (f", "another processor: vax-"]);
    std::fs::write(&account, &whole).unwrap();
    // The same shard twice is the same; another result for a cell is not.
    copy(&dir.join("s/shards/2"), &dir.join("s/shards/7"));
    collect().well();
    let (rows, account) = (dir.join("s/shards/7/rows.jsonl"), dir.join("s/shards/7/shard.json"));
    let first = std::fs::read_to_string(&rows).unwrap().lines().next().unwrap().to_owned();
    let other = first.replacen("\"frames\":", "\"frames\":1", 1);
    let sum = |line: &str| dpn_papers::id([line]);
    change(&rows, |text| text.replacen(&first, &other, 1));
    change(&account, |text| text.replacen(&sum(&first), &sum(&other), 1));
    refused(
        &collect(),
        &["s/shards/2/rows.jsonl and ", "s/shards/7/rows.jsonl have two different results of it"],
    );

    // Before anything is run, too.
    change(&dir.join("s/sweep.json"), |text| text.replacen("\"program\":\"dpn ", "\"program\":\"dpn 9.", 1));
    refused(
        &call(dir, "sweep run s --shard 0"),
        &["shard 0: the sweep was planned with another program: dpn 9."],
    );
    plan(dir, PLAN, "--shards 3 --processor vax --out t");
    let other = call(dir, "sweep plan plan.toml --shards 2 --processor vax --out t").well();
    assert!(other.stdout.contains("2 shards"));
    refused(&call(dir, "sweep run t --shard 0"), &["another processor: vax there, "]);
    refused(&call(dir, "sweep run t --shard 2"), &["there is no shard 2: they are 0 to 1"]);
    refused(&call(dir, "sweep run t"), &["no shard is named, and there is no SLURM_ARRAY_TASK_ID"]);
}

#[test]
fn another_shards_folder_in_a_shards_place_is_told_by_all_with_the_same_remedy() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    plan(dir, crate::links::PLAN, "--shards 2").well();
    call(dir, "sweep run s --shard all").well();
    std::fs::remove_dir_all(dir.join("s/shards/1")).unwrap();
    std::fs::rename(dir.join("s/shards/0"), dir.join("s/shards/1")).unwrap();
    let words = [
        "shard 1 (f",
        "another number: 0 there, 1 in the sweep",
        "`dpn sweep run s --shard 1` makes it again",
    ];
    refused(&call(dir, "sweep run s --shard 1"), &words);
    call(dir, "sweep run s --shard 0").well();
    refused(&call(dir, "sweep collect s --out whole"), &words);
    let status = call(dir, "sweep status s --json").well().json();
    assert_eq!(status["shards"][1]["state"], "misplaced");
    let told = call(dir, "sweep status s").well();
    assert!(told.stdout.contains("shard 1: s/shards/1 holds another shard's results; remove it"), "{told:?}");
    std::fs::remove_dir_all(dir.join("s/shards/1")).unwrap();
    call(dir, "sweep run s --shard 1").well();
    call(dir, "sweep collect s --out whole").well();
}

#[test]
fn input_that_changed_since_the_plan_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    for flight in ["room-medium", "hover"] {
        call(dir, &format!("simulate flight {flight} --out data")).well();
    }
    let text = "kind = \"closed-loop\"\ndata = \"data\"\nnoises = [\"x4\"]\nfrom = 50\nto = 54\n";
    plan(dir, text, "--shards 2").well();
    std::fs::rename(dir.join("data"), dir.join("there")).unwrap();
    assert_eq!(call(dir, "sweep run s --shard all").code, Some(2));
    call(dir, "sweep run s --shard 0 --data there").well();
    let imu = |name: &str| dir.join("there").join(name).join("mav0/imu0/data.csv");
    let names: Vec<String> = std::fs::read_dir(dir.join("there"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    for name in &names {
        change(&imu(name), |text| text[..text.trim_end().rfind('\n').unwrap() + 1].to_owned());
    }
    let done = call(dir, "sweep run s --shard 1 --data there");
    refused(
        &done,
        &["the sweep was planned with another input of ", "hint: run it with the program, data and"],
    );
}

#[test]
fn a_second_process_on_a_shard_is_told_who_has_it() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    plan(dir, PLAN, "--shards 3").well();
    let lock = FolderLock::take(dir.join("s/shards/1")).unwrap();
    let done = call(dir, "sweep run s --shard 1");
    refused(&done, &["shards/1: another dpn writes there (process ", "hint: wait until that one is over"]);
    drop(lock);
}

#[test]
fn cells_that_fail_end_nothing_and_are_kept_with_their_reasons() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    std::fs::create_dir(dir.join("data")).unwrap();
    call(dir, "simulate flight room-medium --out data").well();
    call(dir, "simulate flight hover --out data").well();
    let states = files(&dir.join("data"))
        .into_keys()
        .find(|name| name.contains("hover") && name.contains("state_groundtruth"));
    // It cannot be judged from 50 s on.
    change(&dir.join("data").join(states.unwrap()), |text| {
        text.lines().take(500).map(|line| format!("{line}\n")).collect()
    });
    let text = "kind = \"closed-loop\"\ndata = \"data\"\nnoises = [\"x4\", \"x8\"]\nfrom = 50\nto = 54\n";
    plan(dir, text, "--shards 1").well();
    let done = call(dir, "sweep run s --shard 0");
    refused(
        &done,
        &[
            "2 cells failed: f09-hover x4 seed 0: ",
            "s/shards/0/failed.jsonl; `dpn sweep run s --shard 0` tries",
        ],
    );
    assert_eq!(std::fs::read_to_string(dir.join("s/shards/0/failed.jsonl")).unwrap().lines().count(), 2);
    let status = call(dir, "sweep status s --json").well().json();
    assert_eq!((&status["done"], &status["failed"]), (&2.into(), &2.into()));
    refused(&call(dir, "sweep collect s"), &["2 cells failed"]);
    let told = call(dir, "sweep collect s --without-failed").well();
    assert!(told.stderr.contains("warning: without 2 cells"), "{}", told.stderr);
    assert_eq!(std::fs::read_to_string(dir.join("s/collected/rows.jsonl")).unwrap().lines().count(), 2);
}

#[test]
fn a_paper_in_shards_has_nothing_left_to_run() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    std::fs::write(dir.join("least.toml"), include_str!("../data/least_plan.toml")).unwrap();
    flights(dir, &[("f07-room-medium", 70.0, 15.0)]);
    let text = "kind = \"paper\"\nplan = \"least.toml\"\ncamera = \"tracks\"\n[run]\nfrom = 10\n";
    plan(dir, text, "--shards 3 --data data").well();
    call(dir, "sweep run s --shard all").well();
    call(dir, "sweep collect s --out work").well();
    let line = "paper --plan least.toml --data data --camera tracks --from 10 --work work --out out";
    let before = lasting(&dir.join("work"));
    let made = call(dir, line).well();
    for stage in ["closed loop ", "injected noise: step "] {
        let said = made.stderr.lines().find(|line| line.starts_with(stage) && line.contains(" s  ")).unwrap();
        assert!(said.contains("as it was"), "{said}");
    }
    let after = lasting(&dir.join("work"));
    assert!(before.iter().all(|(name, bytes)| after.get(name) == Some(bytes)));
    assert!(before.keys().any(|name| name.contains("/states/")), "{:?}", before.keys());
}

#[test]
fn trainings_in_shards_are_those_of_dpn_train() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let data = recording::sound(dir);
    config(dir, TINY);
    let text = format!(
        "kind = \"train\"\ndata = \"{}\"\nsensors = [\"accel\"]\nconfigs = [\"config.toml\"]\nseeds = 2\nepochs = 2\n",
        data.display()
    );
    plan(dir, &text, "--shards 2").well();
    call(dir, "sweep run s --shard all").well();
    call(dir, "sweep collect s --out nets").well();
    assert_eq!(std::fs::read_to_string(dir.join("nets/rows.jsonl")).unwrap().lines().count(), 2);
    for seed in ["0", "1"] {
        let out = dir.join("one").join(seed);
        end(tiny(dir, &data, 2, &out).args(["--seed", seed])).well();
        let collected = dir.join("nets").join(format!("accel-config-seed{seed}"));
        assert!(weights(&collected) == weights(&out), "seed {seed}");
        assert!(files(&collected) == files(&out), "seed {seed}");
    }
}

#[test]
fn what_cannot_be_planned_or_read_is_refused_in_words() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    for (text, words) in [
        ("kind = \"closed-lop\"", "unknown variant `closed-lop`"),
        ("seeds = 3", "missing field `kind`"),
        ("kind = \"closed-loop\"\nnoise = []", "did you mean `noises`?"),
        ("kind = \"closed-loop\"\nseeds = 0", "`seeds` is 0, but must be 1 to 10000"),
        ("kind = \"closed-loop\"\nsequences = \"cave\"", "no sequence is called `cave`"),
        ("kind = \"closed-loop\"\nnoises = [\"dualpronett\"]", "did you mean `dualpronet`?"),
        (
            "kind = \"paper\"\nsequences = \"f07\"",
            "`sequences` is gone since 0.2.0; write it in the table [run]",
        ),
        ("kind = \"paper\"\nquick = true\nplan = \"p.toml\"", "`quick` is true"),
        ("kind = \"train\"\nsensors = []", "`sensors` is []"),
    ] {
        refused(&plan(dir, text, "--shards 2"), &[words]);
        assert!(!dir.join("s").exists(), "{text}");
    }
    refused(&plan(dir, PLAN, "--minutes 0.0000001"), &["is shorter than a single cell"]);
    refused(
        &call(dir, "sweep status s"),
        &["s: no sweep, for there is no sweep.json", "hint: dpn sweep plan"],
    );
    std::fs::create_dir(dir.join("s")).unwrap();
    std::fs::write(dir.join("s/sweep.json"), "{\"format\":1}\n").unwrap();
    refused(
        &call(dir, "sweep run s --shard 0"),
        &["sweep.json:1: a sweep of format 1, and this program reads 2"],
    );
    for line in
        ["sweep plan p.toml --out s", "sweep run s --shard 3-1", "sweep plan p.toml --shards 0 --out s"]
    {
        assert_eq!(run(line).code, Some(2), "{line}");
    }
}

/// Runs all shards, each killed so many times on its way, and compares with what was never disturbed.
fn killed(times: u32) {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    plan(dir, PLAN, "--shards 2").well();
    let whole = dir.join("whole");
    std::fs::create_dir(&whole).unwrap();
    std::fs::copy(dir.join("s/sweep.json"), whole.join("sweep.json")).unwrap();
    let clock = std::time::Instant::now();
    call(dir, "sweep run whole --shard all").well();
    let undisturbed = clock.elapsed() / 2;
    let mut state = 20_261_122_u32;
    let mut kills = 0;
    while kills < times {
        let shard = dir.join("s/shards");
        if kills % 6 == 0 && shard.exists() {
            std::fs::remove_dir_all(shard).unwrap();
        }
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let at = undisturbed.mul_f64(f64::from(state >> 8) / f64::from(1_u32 << 24));
        let mut run = command(dir, &format!("sweep run s --shard {}", kills % 2));
        let mut child = run.stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(at.max(Duration::from_millis(5)));
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        if kills % 6 == 0 || kills == times {
            call(dir, "sweep run s --shard all").well();
            call(dir, "sweep collect s --out made").well();
            call(dir, "sweep collect whole --out undisturbed").well();
            equal(&dir.join("undisturbed"), &dir.join("made"));
            std::fs::remove_dir_all(dir.join("made")).unwrap();
        }
    }
}

#[test]
fn a_killed_shard_goes_on_with_nothing_lost_or_counted_twice() {
    killed(3);
}

#[test]
#[ignore = "a minute"]
fn a_shard_killed_fifty_times_goes_on() {
    killed(50);
}

/// Rows made up for every cell of a sweep in `dir`, as its shards would have left them.
fn make_up(dir: &Path, template: &Value) -> usize {
    let folder = dpn_eval::sweeps::SweepFolder::open(&dir.join("s").into()).unwrap();
    let manifest = &folder.manifest;
    for shard in 0..folder.shards() {
        let (mut text, mut sums) = (String::new(), Vec::new());
        for place in folder.cells_of_shard(shard) {
            let cell = &manifest.cells[place];
            let (sequence, rest) = cell.label.split_once(' ').unwrap();
            let (noise, seed) = rest.rsplit_once(" seed ").unwrap();
            let mut row = template.clone();
            row["sequence"] = sequence.into();
            row["noise"] = noise.into();
            row["seed"] = seed.parse::<u64>().unwrap().into();
            row["cell"] = cell.cell.clone().into();
            row["ate_se3"] = (0.1 + (place % 977) as f64 / 3333.0).into();
            let line = row.to_string();
            sums.push(dpn_papers::id([&line]));
            text += &(line + "\n");
        }
        let account = serde_json::json!({
            "sweep": manifest.id(), "shard": shard, "program": manifest.program, "processor": manifest.processor, "node": "made up",
            "done": true, "failed": 0, "rows": { "": sums }, "files": {},
        });
        let shard = folder.shard_dir(shard);
        let shard = shard.path();
        std::fs::create_dir_all(shard).unwrap();
        std::fs::write(shard.join("rows.jsonl"), text).unwrap();
        std::fs::write(shard.join("shard.json"), account.to_string()).unwrap();
    }
    manifest.cells.len()
}

/// The most memory that a process had \[MB\], asked again and again until it ends.
fn peak_mb(child: &mut std::process::Child) -> f64 {
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0_f64;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kb = line.and_then(|line| line.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok());
        peak = peak.max(kb.unwrap_or(0.0) / 1024.0);
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

#[test]
#[ignore = "a minute; the figures are those of an optimised build on a machine that does nothing else"]
fn fifty_thousand_cells_are_put_together_in_seconds_and_in_little_memory() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    call(dir, "eval --closed-loop --sequences hover --noise x4 --from 10 --to 16 --out one").well();
    let template = std::fs::read_to_string(dir.join("one/rows.jsonl")).unwrap();
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/sweep/closed_loop.toml"));
    plan(dir, &text.unwrap().replace("seeds = 10", "seeds = 147"), "--shards 12").well();
    let cells = make_up(dir, &serde_json::from_str(&template).unwrap());
    assert!(cells > 50_000);
    let clock = std::time::Instant::now();
    let mut run = command(dir, "sweep collect s --out whole");
    let mut child = run.stdout(Stdio::null()).spawn().unwrap();
    let peak = peak_mb(&mut child);
    assert!(child.wait().unwrap().success());
    let seconds = clock.elapsed().as_secs_f64();
    eprintln!("{cells} cells in {seconds:.1} s and {peak:.0} MB");
    assert!(seconds < 10.0 && peak < 200.0, "{cells} cells in {seconds:.1} s and {peak:.0} MB");
}

/// CPU seconds, user's and system's, of `dpn` called with each of `lines` in turn.
fn cpu_seconds(dir: &Path, lines: &[String]) -> f64 {
    let script: String =
        lines.iter().map(|line| format!("\"$0\" {line} >/dev/null 2>&1 || exit 1\n")).collect();
    let mut shell = Command::new("sh");
    let done =
        end(shell.current_dir(dir).args(["-c", &(script + "times"), env!("CARGO_BIN_EXE_dpn")])).well();
    // The second line is of children: `0m1.230s 0m0.010s`.
    let seconds = |word: &str| {
        let (minutes, seconds) = word.trim_end_matches('s').split_once('m').unwrap();
        60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
    };
    done.stdout.lines().nth(1).unwrap().split_whitespace().map(seconds).sum()
}

#[test]
#[ignore = "minutes; the figures are those of an optimised build"]
fn twelve_shards_take_little_more_than_one_process() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let noises = "x0.5 x1 x2 x4 x8 x16 diff2 dualpronet mean(dualpronet) shuffled(dualpronet)";
    let listed = noises.split(' ').map(|noise| format!("{noise:?}")).collect::<Vec<_>>().join(", ");
    let text = format!("kind = \"closed-loop\"\nnoises = [{listed}]\nfrom = 0\n");
    plan(dir, &text, "--shards 12").well();
    let one =
        cpu_seconds(dir, &[format!("eval --closed-loop --noise '{noises}' --from 0 --threads 1 --out one")]);
    let mut lines: Vec<String> = (0..12).map(|shard| format!("sweep run s --shard {shard}")).collect();
    lines.push("sweep collect s --out whole".into());
    let twelve = cpu_seconds(dir, &lines);
    eprintln!("one process {one:.1} s, 12 shards and their collection {twelve:.1} s of CPU");
    equal(&dir.join("one"), &dir.join("whole"));
    assert!(twelve <= 1.05 * one, "{one} s and {twelve} s");
}
