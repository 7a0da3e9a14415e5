//! `dpn paper`, on some seconds of two simulated flights.

use crate::recording;
use crate::run::{Done, dpn, end, files};
use dpn_testing::cut_asl;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// As little as gives every table and figure.
const PLAN: &str = include_str!("../data/least_plan.toml");

/// Parts of flights, each from so many seconds on and for so many, in the folder `data` of `dir`: the regressors of an open loop take long on whole ones.
pub(crate) fn flights(dir: &Path, of: &[(&str, f64, f64)]) {
    for (name, from, seconds) in of {
        end(dpn().current_dir(dir).args(["simulate", "flight", name, "--out", "data"])).well();
        cut_asl(&dir.join("data").join(name), *from, from + seconds);
    }
}

fn paper(dir: &Path, more: &[&str]) -> Done {
    on(dir, "10", more)
}

fn on(dir: &Path, from: &str, more: &[&str]) -> Done {
    std::fs::write(dir.join("plan.toml"), PLAN).unwrap();
    let mut command = dpn();
    command.current_dir(dir).args(["paper", "--plan", "plan.toml", "--data", "data", "--camera", "tracks"]);
    command.args(["--from", from]);
    command.args(["--out", "out", "--work", "work"]).args(more);
    end(&mut command)
}

/// The folder of a stage's results.
fn stage(dir: &Path, name: &str) -> PathBuf {
    let mut all = std::fs::read_dir(dir.join("work")).unwrap().map(|e| e.unwrap().path());
    all.find(|path| path.file_name().unwrap().to_str().unwrap().starts_with(name)).unwrap()
}

/// Tables and SVGs, but for the table of times.
fn lasting(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let all = files(&dir.join("out"));
    let lasting = |name: &String| {
        let table = name.starts_with("tables/") && !name.starts_with("tables/timing");
        table || name.ends_with(".svg") || name.ends_with(".png")
    };
    all.keys()
        .filter(|name| lasting(name))
        .map(|name| (name.clone(), std::fs::read(dir.join("out").join(name)).unwrap()))
        .collect()
}

#[test]
fn everything_is_made_once_goes_on_after_a_cut_and_comes_out_the_same() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    flights(dir, &[("f07-room-medium", 70.0, 15.0), ("f10-room-spiral", 70.0, 15.0)]);
    let first = paper(dir, &["--threads", "2"]).well();
    assert!(first.stdout.contains("page: out/index.html"), "{}", first.stdout);
    let made = lasting(dir);
    for name in ["split", "open_loop", "closed_loop", "study", "pairs", "injected", "response", "networks"] {
        for ending in ["md", "csv", "tex"] {
            let text = String::from_utf8(made[&format!("tables/{name}.{ending}")].clone()).unwrap();
            assert!(text.contains("Made by: dpn paper --plan plan.toml"), "{name}.{ending}");
            assert!(text.contains("runs: "), "{name}.{ending}");
        }
    }
    for name in [
        "architecture_odometry",
        "architecture_window",
        "open_loop_rmse_vs_sigma",
        "trajectories",
        "error_by_time",
        "flight_sigma",
        "step_response",
        "sweep",
        "injected_sweep",
    ] {
        let svg = String::from_utf8(made[&format!("{name}.svg")].clone()).unwrap();
        assert!(svg.contains("dpn paper --plan plan.toml") && svg.contains("runs:"), "{name}");
        // What is drawn from a template is SVG alone.
        assert_eq!(made.contains_key(&format!("{name}.png")), !name.starts_with("architecture"), "{name}");
    }
    let study = String::from_utf8(made["tables/study.csv"].clone()).unwrap();
    assert_eq!(study.lines().filter(|line| !line.starts_with('#')).count(), 4, "{study}");
    let page = std::fs::read_to_string(dir.join("out/index.html")).unwrap();
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
    assert!(page.matches("<img").count() >= 10 && page.matches("<table").count() >= 6);

    // Nothing has changed: nothing is made.
    let again = paper(dir, &["--threads", "2"]).well();
    assert!(!again.stderr.contains(" made "), "{}", again.stderr);
    assert_eq!(again.stdout, first.stdout);

    // The responses are kept by sequence and course: one that was lost is measured again, the others are read.
    let responses = stage(dir, "response-");
    let (whole, pieces) = (responses.join("responses.json"), responses.join("pieces"));
    let (before, measured) = (std::fs::read(&whole).unwrap(), files(&pieces));
    assert_eq!(measured.len(), 4, "{:?}", measured.keys());
    let lost = pieces.join("f07-room-medium-step.json");
    for gone in [&lost, &whole] {
        std::fs::remove_file(gone).unwrap();
    }
    let other = pieces.join("f07-room-medium-tone.json");
    let touched = || std::fs::metadata(&other).unwrap().modified().unwrap();
    let at = touched();
    paper(dir, &["--threads", "2"]).well();
    assert!(std::fs::read(&whole).unwrap() == before && files(&pieces) == measured && touched() == at);

    // A cell lost, a table spoilt, another number of threads: the same bytes. The command stands in all of them.
    let rows = stage(dir, "closed-loop-").join("rows.jsonl");
    let text = std::fs::read_to_string(&rows).unwrap();
    let kept: Vec<&str> = text.lines().skip(1).collect();
    std::fs::write(&rows, kept.join("\n") + "\n{\"sequ").unwrap();
    std::fs::write(dir.join("out/tables/split.md"), "spoilt").unwrap();
    let third = paper(dir, &["--threads", "2"]).well();
    assert!(third.stderr.contains("closed loop: 6 cells: 5 kept from work/closed-loop-"), "{}", third.stderr);
    assert_eq!(lasting(dir), made);

    // What does not read is named and stays.
    let path = stage(dir, "open-loop-").join("rows.json");
    std::fs::write(&path, "[{").unwrap();
    let stale = paper(dir, &["--threads", "2"]);
    assert_eq!((stale.code, stale.stdout.as_str()), (Some(2), ""), "{stale:?}");
    assert!(stale.stderr.contains("rows.json: it does not read"), "{}", stale.stderr);
    assert!(stale.stderr.contains("remove it, and it is made again"), "{}", stale.stderr);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "[{");
}

#[test]
fn a_sequence_that_cannot_be_seen_is_a_row_with_its_reason_and_the_others_go_on() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    // One flight is over before the runs begin, the other is not.
    flights(dir, &[("f06-room-slow", 40.0, 18.0), ("f07-room-medium", 40.0, 5.0)]);
    let done = on(dir, "6", &[]).well();
    let reason = "No row for f07-room-medium: ";
    assert!(done.stdout.contains(reason), "{}", done.stdout);
    let made = lasting(dir);
    let text = |name: &str| String::from_utf8(made[name].clone()).unwrap();
    for table in ["closed_loop", "study", "injected", "response"] {
        assert!(text(&format!("tables/{table}.md")).contains(reason), "{table}");
    }
    let closed = text("tables/closed_loop.csv");
    assert!(
        closed.contains("\nf06-room-slow,train,") && closed.contains("\nf07-room-medium,test,missing"),
        "{closed}"
    );
    assert!(closed.contains("mean, all (1)"), "{closed}");
    // Its windows are used all the same.
    assert!(text("tables/split.csv").contains("\nf07-room-medium,test,"));
    let page = std::fs::read_to_string(dir.join("out/index.html")).unwrap();
    assert!(page.contains(reason));
    // It is tried again, and nothing else is run.
    let again = on(dir, "6", &[]).well();
    assert!(!again.stderr.contains(" made "), "{}", again.stderr);
    assert_eq!(again.stdout, done.stdout);
}

#[test]
fn what_cannot_be_used_is_refused_with_its_reason() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    for (more, words) in [
        (&["--sequences", "cave"][..], "no sequence is called `cave`; there are f01-hall-slow"),
        (&["--camera", "film"], "expected one of `auto`, `images`, `rendered`, `tracks`"),
        (&["--camera", "images"], "--camera images: simulated flights have no images"),
        (&["--data", "nowhere"], "nowhere"),
        (&["--quick"], "cannot be used with"),
    ] {
        let mut command = dpn();
        std::fs::write(dir.join("plan.toml"), PLAN).unwrap();
        command.current_dir(dir).args(["paper", "--plan", "plan.toml", "--out", "out", "--work", "work"]);
        let done = end(command.args(more));
        assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{more:?}: {done:?}");
        assert!(done.stderr.contains(words), "{more:?}: {}", done.stderr);
    }
    std::fs::write(dir.join("bad.toml"), "seeds = 0\nnoises = [\"x1\"]\n").unwrap();
    let mut command = dpn();
    let done = end(command.current_dir(dir).args(["paper", "--plan", "bad.toml"]));
    assert!(
        done.stderr.contains("`seeds` is 0") && done.stderr.contains("with dualpronet"),
        "{}",
        done.stderr
    );

    // A sequence without ground truth cannot be judged, and ten are not there at all.
    let data =
        recording::put(&dir.join("data"), "MH_01_easy", &recording::text(&recording::rows(3000, 5_000_000)));
    let mut command = dpn();
    command
        .current_dir(dir)
        .args(["paper", "--quick", "--out", "out", "--work", "work", "--data"])
        .arg(&data);
    let done = end(&mut command);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("no sequence can be used: MH_01_easy: "), "{}", done.stderr);
    assert!(!dir.join("out").exists());
}
