//! `dpn train`: what it leaves, that it leaves the same twice, and that it survives being killed.

use crate::recording::{put, rows, sound, text};
use crate::run::{Done, dpn, end, files};
use crate::training::{TINY, config, tiny, weights, with};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// History of a run, line by line.
fn history(out: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(out.join("history.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn without_data_it_trains_on_the_simulated_flights() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    let mut command = dpn();
    command.args(["train", "--sensor", "gyro", "--epochs", "2", "--json", "--config"]);
    command.arg(config(tmp.path(), &format!("{TINY}sensor = \"gyro\"\n"))).arg("--out").arg(&out);
    let said = end(&mut command).well().json();
    assert_eq!((&said["sensor"], &said["data"]), (&"gyro".into(), &"simulated".into()), "{said}");
    assert_eq!(said["sequences"].as_array().unwrap().len(), 6, "{said}");

    let left: Vec<String> = files(&out).into_keys().collect();
    assert_eq!(
        left,
        [
            "checkpoint.safetensors",
            "config.toml",
            "gyro.safetensors",
            "history.jsonl",
            "summary.json",
            "training.csv",
            "training.pdf",
            "training.png",
            "training.svg"
        ]
    );
    let summary: serde_json::Value = serde_json::from_slice(&files(&out)["summary.json"]).unwrap();
    assert_eq!(summary, said);

    let history = history(&out);
    let epochs: Vec<u64> = history.iter().map(|line| line["epoch"].as_u64().unwrap()).collect();
    assert_eq!(epochs, [1, 2]);
    let best =
        history.iter().map(|line| line["validation_rmse"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(said["validation_rmse"].as_f64().unwrap().to_bits(), best.to_bits());
}

#[test]
fn the_configuration_it_leaves_makes_the_same_weights_again() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, first, again) = (sound(tmp.path()), tmp.path().join("a"), tmp.path().join("b"));
    end(&mut with(tiny(tmp.path(), &data, 2, &first), &["--seed", "4", "--base", "sg(7,2)"])).well();
    let mut command = dpn();
    command.args(["train", "--sensor", "accel", "--config"]).arg(first.join("config.toml"));
    end(command.arg("--data").arg(&data).arg("--out").arg(&again)).well();
    assert!(weights(&first) == weights(&again), "config.toml does not say all");
}

#[test]
fn the_same_seed_gives_the_same_file_with_one_thread_or_two_and_another_seed_another() {
    let tmp = tempfile::tempdir().unwrap();
    let data = sound(tmp.path());
    let of = |place: &str, seed: &str, threads: &str| {
        let out = tmp.path().join(place);
        let command = tiny(tmp.path(), &data, 3, &out);
        end(with(command, &["--seed", seed]).env("RAYON_NUM_THREADS", threads)).well();
        weights(&out)
    };
    let first = of("a", "1", "1");
    assert!(first == of("b", "1", "1"), "the same twice differs");
    assert!(first == of("c", "1", "2"), "two threads differ from one");
    assert!(first != of("d", "2", "1"), "the seed changes nothing");
}

/// Some epochs are done, most are not, when a run is stopped after its first checkpoint.
const EPOCHS: u64 = 100;

/// The tiny run with epochs long enough to be stopped in.
fn longer(dir: &Path, data: &Path, out: &Path) -> Command {
    let command = tiny(dir, data, EPOCHS, out);
    config(dir, &TINY.replace("[fit]\n", "[fit]\ndraws_per_window = 20\n"));
    command
}

/// Starts a run and waits for its first checkpoint.
fn started(dir: &Path, data: &Path, out: &Path) -> std::process::Child {
    let mut child = longer(dir, data, out).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let patience = Instant::now();
    while !out.join("checkpoint.safetensors").exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended before its first checkpoint");
        assert!(patience.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

/// Goes on with the run in `out` and compares with one that never stopped.
fn goes_on_to_the_same_bits(dir: &Path, data: &Path, out: &Path) {
    assert!(!out.join("accel.safetensors").exists(), "it was over before it was stopped");
    let resumed = end(&mut with(longer(dir, data, out), &["--resume"])).well();
    assert!(resumed.stderr.starts_with(&format!("resume {} after ", out.display())), "{resumed:?}");
    let whole = dir.join("whole");
    end(&mut longer(dir, data, &whole)).well();
    assert!(weights(out) == weights(&whole), "weights differ from a run that never stopped");
    for file in ["history.jsonl", "summary.json", "checkpoint.safetensors"] {
        assert!(
            std::fs::read(out.join(file)).unwrap() == std::fs::read(whole.join(file)).unwrap(),
            "{file} differs"
        );
    }
}

#[test]
fn killed_and_resumed_it_ends_in_the_same_bits() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, out) = (sound(tmp.path()), tmp.path().join("out"));
    let mut child = started(tmp.path(), &data, &out);
    child.kill().unwrap();
    child.wait().unwrap();
    goes_on_to_the_same_bits(tmp.path(), &data, &out);
}

#[cfg(unix)]
#[test]
fn stopped_by_ctrl_c_it_says_how_to_go_on_and_does() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, out) = (sound(tmp.path()), tmp.path().join("out"));
    let child = started(tmp.path(), &data, &out);
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    let last = stderr.lines().last().unwrap();
    assert!(last.starts_with("stopped in epoch ") && last.ends_with("add --resume to go on"), "{stderr}");
    goes_on_to_the_same_bits(tmp.path(), &data, &out);
}

#[cfg(unix)]
#[test]
fn stopped_in_its_first_epoch_it_says_so_and_begins_anew_with_resume_or_without() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, out) = (sound(tmp.path()), tmp.path().join("out"));
    let long = config(tmp.path(), "[fit]\ndraws_per_window = 1000\nbatch = 64\n");
    let mut command = dpn();
    command.args(["train", "--sensor", "accel", "--epochs", "2", "--config"]).arg(long);
    let mut child =
        command.arg("--data").arg(&data).arg("--out").arg(&out).stderr(Stdio::piped()).spawn().unwrap();
    let patience = Instant::now();
    while !out.join("config.toml").exists() && patience.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(300));
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    let stderr = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert_eq!(status.code(), Some(130), "{status}: {stderr}");
    let last = stderr.lines().last().unwrap();
    assert_eq!(last, "stopped in epoch 1, before any was finished: the same command begins anew", "{stderr}");
    let again = end(&mut with(tiny(tmp.path(), &data, 2, &out), &["--resume"])).well();
    let words = format!("{}: no epoch was finished there; it is begun anew\n", out.display());
    assert!(again.stderr.starts_with(&words), "{}", again.stderr);
}

#[test]
fn a_history_that_is_a_line_short_of_its_checkpoint_is_whole_again_after_resume() {
    let tmp = tempfile::tempdir().unwrap();
    let (again, out) = finished(tmp.path());
    let before = files(&out);
    let text = String::from_utf8(before["history.jsonl"].clone()).unwrap();
    // As a kill between the two files leaves it: a checkpoint of two epochs, a line of one.
    std::fs::write(out.join("history.jsonl"), text.lines().next().unwrap().to_owned() + "\n").unwrap();
    std::fs::write(out.join(".dpn-Ab12cd.tmp"), "half").unwrap();
    again(&["--resume"]).well();
    assert!(before == files(&out));
}

/// A finished run of two epochs, and a way to call it again.
fn finished(dir: &Path) -> (impl Fn(&[&str]) -> Done, std::path::PathBuf) {
    let (data, out) = (sound(dir), dir.join("out"));
    end(&mut tiny(dir, &data, 2, &out)).well();
    let (place, dir) = (out.clone(), dir.to_owned());
    (move |words: &[&str]| end(&mut with(tiny(&dir, &data, 2, &place), words)), out)
}

#[test]
fn a_run_is_never_written_over() {
    let tmp = tempfile::tempdir().unwrap();
    let (again, out) = finished(tmp.path());
    let before = files(&out);
    again(&[]).refused(
        tmp.path(),
        "error: [DIR]/out: a run stands there already (2 of its epochs done)\n\n\
         hint: go on with it by --resume, or choose another folder with --out",
    );
    again(&["--resume", "--seed", "7"]).refused(
        tmp.path(),
        "error: [DIR]/out: cannot resume, because the run there has another configuration\n\n\
         hint: give the configuration and data it was started with, or start anew in another folder",
    );
    assert!(before == files(&out), "a refusal changed the run");
    again(&["--resume"]).well();
    assert!(before == files(&out), "going on with a finished run changed it");
}

#[test]
fn other_recordings_or_a_damaged_checkpoint_cannot_be_resumed() {
    let tmp = tempfile::tempdir().unwrap();
    let (again, out) = finished(tmp.path());
    let mut other = rows(3000, 5_000_000);
    other[17].1[2] += 1e-9;
    put(&tmp.path().join("log"), "still", &text(&other));
    again(&["--resume"]).refused(
        tmp.path(),
        "error: [DIR]/out: cannot resume, because the run there saw other recordings\n\n\
         hint: give the configuration and data it was started with, or start anew in another folder",
    );
    sound(tmp.path());
    let checkpoint = out.join("checkpoint.safetensors");
    let bytes = std::fs::read(&checkpoint).unwrap();
    for damaged in [&bytes[..bytes.len() / 2], &bytes[..7], &[]] {
        std::fs::write(&checkpoint, damaged).unwrap();
        let done = again(&["--resume"]);
        assert_eq!(done.code, Some(2), "{done:?}");
        assert!(done.stderr.starts_with(&format!("error: {}: ", checkpoint.display())), "{done:?}");
    }
}

#[test]
fn there_must_be_a_run_to_resume() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, out) = (sound(tmp.path()), tmp.path().join("out"));
    end(&mut with(tiny(tmp.path(), &data, 2, &out), &["--resume"])).refused(
        tmp.path(),
        "error: [DIR]/out: no run to resume\n\nhint: leave --resume out to start a run there",
    );
    assert!(!out.exists());
}

#[test]
fn many_networks_of_a_plan_are_those_that_are_trained_one_by_one() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let data = sound(dir);
    config(dir, TINY);
    let plan = "kind = \"train\"\nsensors = [\"accel\"]\nconfigs = [\"config.toml\"]\nseed = 1\nseeds = 3\nepochs = 2\n";
    std::fs::write(dir.join("plan.toml"), plan).unwrap();
    let many = || {
        let mut command = dpn();
        command.current_dir(dir).args([
            "train",
            "--many",
            "plan.toml",
            "--jobs",
            "2",
            "--json",
            "--out",
            "many",
        ]);
        end(command.arg("--data").arg(&data)).well()
    };
    let said = many().json();
    assert_eq!((&said["networks"], &said["trained"]), (&3.into(), &3.into()), "{said}");
    let alone = dir.join("alone");
    end(&mut with(tiny(dir, &data, 2, &alone), &["--seed", "2"])).well();
    assert_eq!(weights(&dir.join("many/accel-config-seed2")), weights(&alone));
    // What is there is not trained again.
    assert_eq!(many().json()["trained"], 0);

    std::fs::write(dir.join("plan.toml"), plan.replace("\"train\"", "\"closed-loop\"")).unwrap();
    let mut other = dpn();
    other.current_dir(dir).args(["train", "--many", "plan.toml", "--out", "other"]);
    end(&mut other).refused(
        dir,
        "error: plan.toml: this plan trains nothing\n\nhint: its kind must be \"train\", as in configs/sweep/train.toml",
    );
}
