//! Sick logs of a kind each through `dpn check`: the cause is named, and its remedy, followed, makes the finding go.

use crate::recording::{Rows, put, rows, text};
use crate::run::{Done, dpn, end};
use std::path::Path;

fn run(command: &[&str], log: &Path, more: &[&str]) -> Done {
    let out = log.with_file_name("out");
    end(dpn().args(command).arg(log).arg("--out").arg(out).args(more))
}

fn check(log: &Path, more: &[&str]) -> Done {
    run(&["check"], log, more)
}

/// The findings that warn, by what they are about.
fn warned(done: &Done) -> Vec<String> {
    let lines = done.stdout.lines().filter(|line| line.starts_with("bad:") || line.starts_with("warning:"));
    lines.map(|line| line.split(": ").nth(1).unwrap().trim().to_owned()).collect()
}

/// Checks a log with a fault, which is to be found under `about` with these words, and the same with its remedy followed.
fn found_and_mended(sick: (&Path, &[&str]), about: &str, words: &str, mended: (&Path, &[&str])) {
    let done = check(sick.0, sick.1).well();
    let line = done.stdout.lines().find(|line| line.contains(&format!(" {about}: ")));
    assert!(line.is_some_and(|line| line.contains(words)), "{done:?}");
    let after = check(mended.0, mended.1).well();
    assert!(!warned(&after).contains(&about.to_owned()), "{after:?}");
}

fn write(dir: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// A level log at rest, stamps from zero, and its text.
fn level(count: usize) -> Rows {
    let mut rows = rows(count, 5_000_000);
    rows.iter_mut().for_each(|(t, _)| *t -= 1_400_000_000_000_000_000);
    rows
}

#[test]
fn units_hold_in_every_container_and_columns_are_refused_where_there_are_none() {
    let dir = tempfile::tempdir().unwrap();
    let mut in_g = rows(3000, 5_000_000);
    in_g.iter_mut().for_each(|(_, v)| v[3..].iter_mut().for_each(|v| *v /= 9.80665));
    let log = write(dir.path(), "g.csv", &text(&in_g));
    let bag = dir.path().join("g.mcap");
    run(&["noise"], &log, &["--accel-unit", "m/s^2", "--noise", "diff2", "--into", bag.to_str().unwrap()])
        .well();
    for log in [&bag, &log] {
        found_and_mended(
            (log, &["--accel-unit", "m/s^2"]),
            "units",
            "it counts in g",
            (log, &["--accel-unit", "g"]),
        );
    }
    let done = check(&bag, &["--columns", "1,2,3,4,5,6,7"]);
    assert!(
        done.code == Some(2) && done.stderr.contains("--columns is for tables, and this is none: MCAP file"),
        "{done:?}"
    );
    let told = check(&log, &["--gyro-unit", "deg/s"]).well();
    assert!(told.stdout.contains("gyroscope in deg/s as told, though the header says rad/s"), "{told:?}");
}

#[test]
fn stamps_that_cycle_and_two_publishers_are_parts_that_are_each_looked_at() {
    let dir = tempfile::tempdir().unwrap();
    let sound = rows(3000, 5_000_000);
    let mut cycle = sound.clone();
    // In the second cycle gravity is lost.
    cycle.extend(sound.iter().map(|(t, v)| (*t, [v[0], v[1], v[2], v[3], v[4], v[5] - 9.81])));
    let log = write(dir.path(), "cycle.csv", &text(&cycle));
    let half = write(dir.path(), "half.csv", &text(&sound));
    let words = "the stamps begin anew: 2 spans; used are 3000 samples at 200.0 Hz (lines 2 to 3001), not 3000 samples at 200.0 Hz (lines 3002 to 6001)";
    found_and_mended((&log, &[]), "parts", words, (&half, &[]));
    let done = check(&log, &[]).well();
    assert!(done.stdout.contains("gravity: part 2, lines 3002 to 6001: "), "{done:?}");
    let mut both = sound[..1500].to_vec();
    for (t, v) in &sound[1500..] {
        both.push((*t, *v));
        both.push((t + 355_123_000, [0.1; 6]));
    }
    let log = write(dir.path(), "both.csv", &text(&both));
    let words = "2 publishers write at once: used are 3000 samples at 200.0 Hz (lines 2 to ";
    found_and_mended((&log, &[]), "parts", words, (&half, &[]));
    let noise = run(&["noise"], &log, &["--noise", "diff2"]).well();
    assert!(noise.stderr.contains("2 publishers write at once"), "{noise:?}");
}

#[test]
fn stamps_of_arrival_lose_nothing_and_are_mended_by_counting() {
    let dir = tempfile::tempdir().unwrap();
    let mut late = level(6000);
    let mut last = 0;
    for (i, (t, _)) in late.iter_mut().enumerate() {
        let wait = if i % 37 == 0 { 17_000_000 } else { 700_000 * (i as i64 * 7 % 5) };
        last = (*t + wait).max(last + 90_000);
        *t = last;
    }
    let log = write(dir.path(), "late.csv", &text(&late));
    found_and_mended((&log, &[]), "jitter", "stamps are times of arrival, 200.", (&log, &["--rate", "200"]));
    assert!(!warned(&check(&log, &[]).well()).contains(&"gaps".to_owned()));
    // No stamps at all.
    let body: String = text(&level(3000))
        .lines()
        .skip(1)
        .fold(String::new(), |all, line| all + line.split_once(',').unwrap().1 + "\n");
    let log = write(dir.path(), "none.csv", &format!("gx [rad/s],gy,gz,ax [m/s^2],ay,az\n{body}"));
    let done = check(&log, &[]);
    assert!(
        done.code == Some(2) && done.stderr.contains("of a log without stamps say its rate: --rate HZ"),
        "{done:?}"
    );
    let done = check(&log, &["--rate", "200"]).well();
    assert!(
        done.stdout.starts_with("3000 samples, 15.0 s, 200.00 Hz\n") && warned(&done).is_empty(),
        "{done:?}"
    );
}

#[test]
fn rows_that_repeat_are_one_finding_and_go_with_the_copies() {
    let dir = tempfile::tempdir().unwrap();
    let sound = level(6000);
    let held: Rows = (0..6000).map(|i| (sound[i].0, sound[i / 7].1)).collect();
    let log = write(dir.path(), "held.csv", &text(&held));
    let fresh: Rows = held.iter().step_by(7).copied().collect();
    let mended = write(dir.path(), "fresh.csv", &text(&fresh));
    assert_eq!(warned(&check(&log, &[]).well()), ["repeats"]);
    found_and_mended(
        (&log, &[]),
        "repeats",
        "each stands there 7.0 times, so the sensor has 28.6 Hz, not 200.0",
        (&mended, &[]),
    );
}

#[test]
fn a_part_is_cut_by_seconds_or_stamps_for_every_command() {
    let dir = tempfile::tempdir().unwrap();
    let mut rows = rows(6000, 5_000_000);
    // Knocked about in the middle.
    rows[2800..3200].iter_mut().for_each(|(t, v)| v[0] += (*t as f64 * 1e-8).sin());
    let log = write(dir.path(), "knocked.csv", &text(&rows));
    let [seconds, stamps] =
        [["--from", "17", "--to", "29"], ["--from", "1400000017000000000", "--to", "1400000029"]];
    for part in [seconds, stamps] {
        let done = check(&log, &part).well();
        assert!(done.stdout.starts_with("2401 samples, 12.0 s, 200.00 Hz\n"), "{done:?}");
        assert!(done.stdout.contains("at rest throughout, 12 s"), "{done:?}");
        let allan = run(&["allan"], &log, &part).well();
        assert!(allan.stdout.starts_with("2401 samples at 200.0 Hz"), "{allan:?}");
        let noise = run(&["noise"], &log, &[&part[..], &["--noise", "diff2", "--json"]].concat()).well();
        assert_eq!(noise.json()["samples"], 2401, "{noise:?}");
    }
    let done = check(&log, &["--from", "40"]);
    assert!(
        done.code == Some(2) && done.stderr.contains("fewer than two samples between --from and --to"),
        "{done:?}"
    );
}

#[test]
fn single_lost_samples_are_bridged_in_allan_and_cost_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let whole = level(6000);
    let mut lost = whole.clone();
    for at in [5500, 4000, 2500, 1000, 400] {
        lost.remove(at);
    }
    let figures = |rows: &Rows| {
        let log = write(dir.path(), "log.csv", &text(rows));
        let page = run(&["allan"], &log, &[]).well();
        (page.stdout, run(&["allan"], &log, &["--json"]).well().json())
    };
    let ((_, whole), (page, lost)) = (figures(&whole), figures(&lost));
    assert!(page.contains("5 single lost sample(s) of the log bridged"), "{page}");
    assert_eq!(lost["log"]["samples"], whole["log"]["samples"]);
    for sensor in ["accel_white", "gyro_white"] {
        for axis in 0..3 {
            let [a, b] = [&lost, &whole].map(|all| all["figures"][sensor][axis].as_f64().unwrap());
            assert!((a / b - 1.0).abs() < 5e-3, "{sensor} {axis}: {a} for {b}");
        }
    }
}

#[test]
fn what_is_no_log_is_named_with_what_makes_one_of_it() {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes, words, remedy) in [
        (
            "flight.bbl",
            &b"H Product:Blackbox flight data recorder by Nicholas Sherlock\n"[..],
            "flight.bbl: log 1: ",
            "blackbox_decode",
        ),
        ("clip.mp4", b"\0\0\0\x18ftypmp42\0\0\0\0mp42isom", "a video", "ffmpeg -i "),
        (
            "other.json",
            b"{\"version\": 3, \"points\": [{\"a\": 1, \"b\": 2, \"c\": 3}]}",
            "JSON without samples that are known; it has points: a b c",
            "a sensor, a time and x, y, z",
        ),
        (
            "half.json",
            b"{\"rotations\": [{\"x\": 1, \"y\": 2, \"z\": 3, \"t\": 4}]}",
            "JSON of the gyroscope alone (`rotations`)",
            "objects",
        ),
    ] {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let done = check(&path, &[]);
        assert!(
            done.code == Some(2) && done.stderr.contains(words) && done.stderr.contains(remedy),
            "{done:?}"
        );
    }
    let video = dir.path().join("clip.mp4");
    let done = end(dpn().arg("run").arg(&video));
    assert!(done.code == Some(2) && done.stderr.contains("a video"), "{done:?}");
    // A table without a header that could mean two things.
    let row =
        |i: usize| format!("{},{},0.2,0.3,0.01,0.02,9.8{},0.{},0.4,0.5\n", 1_000_000 * i, 0.1, i % 7, i % 9);
    let log = write(dir.path(), "ms25.csv", &(0..50).map(row).collect::<String>());
    let done = check(&log, &[]);
    assert!(
        done.code == Some(2)
            && done.stderr.contains("say --columns 1,2,3,4,5,6,7 or --columns 1,8,9,10,5,6,7"),
        "{done:?}"
    );
    check(&log, &["--columns", "1,8,9,10,5,6,7"]).well();
    // A row's number before the stamp is told.
    let numbered: String =
        text(&level(2000)).lines().skip(1).enumerate().map(|(i, line)| format!("{i},{line}\n")).collect();
    let done = check(&write(dir.path(), "numbered.csv", &numbered), &[]).well();
    assert!(
        done.stdout.starts_with("2000 samples, 10.0 s, 200.00 Hz")
            && done.stdout.contains("row number, stamp, gyroscope"),
        "{done:?}"
    );
}

#[test]
fn an_asl_folder_whose_stamps_are_seconds_is_read_in_seconds() {
    let dir = tempfile::tempdir().unwrap();
    let lines: String = rows(2000, 5_000_000)
        .iter()
        .map(|(t, v)| format!("{:.6},{}\n", *t as f64 * 1e-9, v.map(|v| v.to_string()).join(",")))
        .collect();
    let data = put(dir.path(), "seconds", &lines);
    let done = check(&data.join("seconds"), &[]).well();
    assert!(done.stdout.starts_with("2000 samples, 10.0 s, 200.00 Hz\n"), "{done:?}");
}

#[test]
fn many_logs_are_a_table_with_a_row_for_what_cannot_be_read_and_fail_where_that_is_asked() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("robots");
    std::fs::create_dir(&folder).unwrap();
    write(&folder, "a_gyro_accel.csv", &text(&level(3000)));
    let mut lost = level(3000);
    lost.drain(1000..1040);
    write(&folder, "b.csv", &text(&lost));
    put(&folder, "c", &text(&rows(3000, 5_000_000)));
    write(&folder, "broken.bag", "no bag");
    let check = |more: &[&str]| {
        end(dpn().arg("check").arg(&folder).arg("--out").arg(dir.path().join("out")).args(more))
    };
    let done = check(&[]).well();
    let of = |name: &str| {
        done.stdout
            .lines()
            .find(|line| line.contains(name))
            .unwrap()
            .split_whitespace()
            .skip(1)
            .collect::<Vec<_>>()
    };
    let (a, b) = (of("a_gyro_accel.csv"), of("b.csv"));
    assert_eq!((a[0], a[2], a[7]), ("200.0", "0", "0"), "{done:?}");
    assert_eq!((b[2], b[7], b[9]), ("40", "1", "gaps"), "{done:?}");
    assert!(
        of("robots/c ")[0] == "200.0" && of("broken.bag").join(" ").contains("cannot be read: "),
        "{done:?}"
    );
    let json = check(&["--json"]).well().json();
    assert_eq!(json["logs"].as_array().unwrap().len(), 4);
    assert_eq!(json["logs"][0]["figures"]["lost"], 0.0);
    // The figures are those of a log alone.
    let alone = end(dpn()
        .arg("check")
        .arg(folder.join("b.csv"))
        .arg("--json")
        .arg("--out")
        .arg(dir.path().join("one")))
    .well();
    assert_eq!(json["logs"][1]["findings"], alone.json()["findings"]);
    assert_eq!(check(&["--fail-on", "bad"]).code, Some(3));
    let sound = end(dpn()
        .arg("check")
        .arg(folder.join("a_gyro_accel.csv"))
        .arg("--fail-on")
        .arg("warning")
        .arg("--out")
        .arg(dir.path().join("two")));
    assert_eq!(sound.code, Some(0), "{sound:?}");
}

#[test]
fn of_a_log_with_one_sensor_alone_is_said_what_can_be() {
    let dir = tempfile::tempdir().unwrap();
    let rows = level(6000);
    let of = |first: usize| -> String {
        rows.iter().map(|(t, v)| format!("{t},{},{},{}\n", v[first], v[first + 1], v[first + 2])).collect()
    };
    for (name, text, words) in [
        ("accelerometer.txt", format!("# timestamp ax ay az\n{}", of(3).replace(',', " ")), "accelerometer"),
        ("bare.csv", of(3), "accelerometer"),
        ("gyro.csv", format!("time [ns],gyro_x [rad/s],gyro_y,gyro_z\n{}", of(0)), "gyroscope"),
    ] {
        let log = write(dir.path(), name, &text);
        let done = check(&log, &[]).well();
        assert_eq!(warned(&done), ["sensors"], "{done:?}");
        assert!(
            done.stdout.contains(&format!("the log has the {words} alone"))
                && done.stdout.starts_with("6000 samples, 30.0 s, 200.00 Hz"),
            "{done:?}"
        );
        assert_eq!(
            done.stdout.contains("gravity: the accelerometer reads 9.8"),
            words == "accelerometer",
            "{done:?}"
        );
    }
}
