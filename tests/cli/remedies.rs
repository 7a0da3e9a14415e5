//! Sick logs of a kind each through `dpn check`: the cause is named, and its remedy, followed, makes the finding go.

use crate::recording::{Rows, put, rows, text};
use crate::run::{Done, dpn, end};
use serde_json::Value;
use std::collections::BTreeMap;
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
fn stamps_that_could_be_two_units_or_rows_are_asked_about() {
    let dir = tempfile::tempdir().unwrap();
    let stamped = |step: i64, from: i64| {
        let text = changed(3000, |i, t, _| *t = from + step * i as i64);
        under("time,gx [rad/s],gy,gz,ax [m/s^2],ay,az", &text)
    };
    for (text, readings, flags, head) in [
        (
            stamped(200, 7000),
            "could be us (5000.0 Hz) or ms (5.0 Hz)",
            ["--time-unit", "ms"],
            "3000 samples, 599.8 s, 5.00 Hz",
        ),
        (
            stamped(100, 7000),
            "could be us (10000.0 Hz) or ms (10.0 Hz)",
            ["--time-unit", "ms"],
            "3000 samples, 299.9 s, 10.00 Hz",
        ),
        (
            stamped(1, 0),
            "could be ms (1000.0 Hz), or the rows' numbers",
            ["--rate", "200"],
            "3000 samples, 15.0 s, 200.00 Hz",
        ),
        (
            stamped(1, 1),
            "could be ms (1000.0 Hz), or the rows' numbers",
            ["--time-unit", "ms"],
            "3000 samples, 3.0 s, 1000.00 Hz",
        ),
    ] {
        let log = write(dir.path(), "log.csv", &text);
        let done = check(&log, &[]);
        assert!(done.code == Some(2) && done.stderr.contains(readings), "{done:?}");
        let told = check(&log, &flags).well();
        assert!(told.stdout.starts_with(head), "{told:?}");
    }
    // Newest first is what it is.
    let backwards = write(dir.path(), "backwards.csv", &stamped(-5000, 90_000_000));
    let done = check(&backwards, &[]);
    assert!(done.code == Some(2) && done.stderr.contains("time goes back at 2999 of 3000"), "{done:?}");
}

#[test]
fn microseconds_under_a_header_of_nanoseconds_are_a_word_of_every_command() {
    let dir = tempfile::tempdir().unwrap();
    let log = write(dir.path(), "us.csv", &changed(3000, |_, t, _| *t /= 1000));
    let out = dir.path().join("out.csv");
    let done = end(dpn().arg("convert").arg(&log).arg("--out").arg(&out)).well();
    assert!(done.stderr.contains("rate: 200000 Hz: no IMU is as fast"), "{done:?}");
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
        let allan = run(&["allan"], &log, &[]);
        assert!(allan.code == Some(2) && allan.stderr.contains("`dpn noise LOG` says its"), "{allan:?}");
        assert_eq!(
            done.stdout.contains("gravity: the accelerometer reads 9.8"),
            words == "accelerometer",
            "{done:?}"
        );
        // Of the zeros that stand for the other sensor nothing is said.
        let noise = run(&["noise"], &log, &[]).well();
        let other = if words == "gyroscope" { "accel" } else { "gyro" };
        let said = format!("{}{}", noise.stdout, noise.stderr);
        let is_of_other = |line: &&str| line.contains(other) && !line.contains("zeros");
        assert_eq!(said.lines().filter(is_of_other).collect::<Vec<_>>(), [] as [&str; 0], "{said}");
    }
}

#[test]
fn tables_with_a_sensor_a_row_with_the_stamp_last_in_two_columns_or_in_days_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let rows = rows(4000, 5_000_000);
    let axes = |v: &[f64]| v.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let seconds = |t: i64| format!("{}.{:09}", t / 1_000_000_000, t % 1_000_000_000);
    let text = |head: &str, row: &dyn Fn(i64, &[f64; 6]) -> String| -> String {
        format!("{head}\n{}", rows.iter().map(|(t, v)| row(*t, v) + "\n").collect::<String>())
    };
    let head = "time,gx,gy,gz,ax,ay,az";
    let preamble = (0..400).map(|i| format!("line {i} of a preamble\n")).collect::<String>();
    for (name, text, said) in [
        (
            "apart",
            text(head, &|t, v| {
                let (t, later) = (seconds(t), seconds(t + 2_000_000));
                format!("{t},{},,,\n{later},,,,{}", axes(&v[..3]), axes(&v[3..]))
            }),
            "the gyro's rows",
        ),
        ("last", text("", &|t, v| format!("{},{}", axes(v), seconds(t))), "gyroscope, accelerometer, stamp"),
        (
            "two",
            text("sec,usec,gx,gy,gz,ax,ay,az", &|t, v| {
                format!("{},{},{}", t / 1_000_000_000, t % 1_000_000_000 / 1000, axes(v))
            }),
            "",
        ),
        (
            "days",
            text(head, &|t, v| format!("{:.11},{}", t as f64 / 86_400e9 + 25_569.0, axes(v))),
            "stamps in days",
        ),
        ("preamble", preamble + &text(head, &|t, v| format!("{},{}", seconds(t), axes(v))), "stamps in s"),
    ] {
        let done = check(&write(dir.path(), &format!("{name}.csv"), &text), &[]).well();
        let rate = done.stdout.split(", ").nth(2).and_then(|words| words.split(' ').next());
        let hz: f64 = rate.unwrap().parse().unwrap();
        assert!((hz / 200.0 - 1.0).abs() < 1e-3 && done.stdout.contains(said), "{name}: {done:?}");
        assert!(!done.stdout.contains("bad: ") && done.stdout.contains("reads 9.8"), "{name}: {done:?}");
    }
    // Wider ones are asked about, and what is offered works.
    let wide =
        write(dir.path(), "wide.csv", &text("", &|t, v| format!("{},.1,.2,.3,{}", axes(v), seconds(t))));
    let asked = check(&wide, &[]);
    assert!(asked.code == Some(2) && asked.stderr.contains("say --columns 10,1,2,3,4,5,6 or"), "{asked:?}");
    check(&wide, &["--columns", "10,1,2,3,4,5,6"]).well();
}

/// A log and the flags that it is checked with.
type Told = (String, &'static [&'static str]);

/// A fault: what its finding is about, words of the remedy, a log that has it, and that log with the remedy followed.
type Fault = (&'static str, &'static str, Told, Told);

/// A log at rest with a change to every row: its number, stamp, gyroscope and accelerometer.
fn changed(count: usize, change: impl Fn(usize, &mut i64, &mut [f64; 6])) -> String {
    let mut rows = level(count);
    rows.iter_mut().enumerate().for_each(|(i, (t, v))| change(i, t, v));
    text(&rows)
}

/// The same log with a field of one row replaced.
fn with_field(row: usize, column: usize, text: &str) -> String {
    let rows = changed(3000, |_, _, _| {});
    let mut lines: Vec<&str> = rows.lines().collect();
    let mut fields: Vec<&str> = lines[row + 1].split(',').collect();
    fields[column] = text;
    let line = fields.join(",");
    lines[row + 1] = &line;
    lines.join("\n") + "\n"
}

/// A header that says no unit.
fn under(header: &str, text: &str) -> String {
    format!("{header}\n{}", text.split_once('\n').unwrap().1)
}

/// Findings that warn, with a log each that has what is found, and what their remedies make of it.
fn faults() -> Vec<Fault> {
    let sound = || (changed(3000, |_, _, _| {}), &[][..]);
    let told = |text: &String, flags: &'static [&'static str]| (text.clone(), flags);
    let scaled = |by: f64| changed(3000, |_, _, v| v[3..].iter_mut().for_each(|v| *v *= by));
    let at_hz = |hz: f64| {
        changed(6000, |i, _, v| v[3] += 0.3 * (std::f64::consts::TAU * hz * 0.005 * i as f64).sin())
    };
    let turning = |most: f64, to: f64| {
        changed(3000, move |i, _, v| v[0] = to * (2.0 * (0.02 * i as f64).sin() + v[0]).clamp(-most, most))
    };
    let stepped =
        |step: f64| changed(3000, |_, _, v| v[..3].iter_mut().for_each(|v| *v = (*v / step).round() * step));
    let without = |rows: std::ops::Range<usize>| {
        let mut all = level(3000);
        all.drain(rows);
        text(&all)
    };
    let in_g = scaled(1.0 / 9.80665);
    let in_mg = scaled(1e3 / 9.80665);
    let said_g = under("time [ns],gx [rad/s],gy,gz,ax [g],ay,az", &changed(3000, |_, _, _| {}));
    let coarse = changed(3000, |i, t, _| *t = 10_000_000 * (i as i64 / 2));
    let counts = changed(3000, |_, _, v| {
        v[..3].iter_mut().for_each(|v| *v = (v.to_degrees() * 131.0).round());
        v[3..].iter_mut().for_each(|v| *v = (*v / 9.80665 * 16384.0).round());
    });
    let counts = under("t [ns],gx,gy,gz,ax,ay,az", &counts);
    let in_us = under("time,gx [rad/s],gy,gz,ax [m/s^2],ay,az", &changed(3000, |_, t, _| *t /= 1000));
    let in_deg = turning(9.0, 30.0);
    let swapped = changed(3000, |_, _, v| v.rotate_left(3));
    let heavy = scaled(1.05);
    let biased = changed(3000, |_, _, v| v[0] += 0.3);
    let late = changed(3000, |i, t, _| *t += if i % 7 == 0 { 1_000_000 } else { 0 });
    let bursts = changed(3000, |i, t, _| *t = 20_000_000 * (i as i64 / 4) + 100_000 * (i as i64 % 4));
    let jumped = changed(3000, |i, t, _| *t += if i < 20 { 0 } else { 1_400_000_000_000_000_000 });
    let warms = changed(30_000, |i, _, v| v[0] += 3e-6 * 10_000_usize.saturating_sub(i) as f64);
    let slow = level(3000);
    let frozen = changed(3000, |i, _, v| *v = slow[i - usize::from(i % 5 == 4)].1);
    let in_gal = scaled(100.0);
    let stopped = changed(3000, |i, _, v| *v = slow[if (1000..1400).contains(&i) { 1000 } else { i }].1);
    let flipped =
        changed(3000, |i, _, v| v[3..].iter_mut().for_each(|v| *v *= if i < 1500 { 1.0 } else { -1.0 }));
    let over = |range: f64| {
        let run = |v: f64| (v + range).rem_euclid(2.0 * range) - range;
        changed(3000, move |i, _, v| v[0] = run(v[0] + 1.4 * (0.02 * i as f64).sin()))
    };
    // Rolled to and fro, the gyroscope's x and y swapped.
    let rolled = changed(6000, |i, _, v| {
        let (sin, cos) = (0.02 * i as f64).sin_cos();
        let (up, level) = (1.2 * sin).sin_cos();
        (v[1], v[4], v[5]) = (v[1] + 4.8 * cos, v[4] + 9.81 * up, v[5] + 9.81 * (level - 1.0));
    });
    // Waved about two axes.
    let waved = |bias: f64| {
        let rate = |t: f64| nalgebra::Vector3::new(1.1 * (1.3 * t).sin(), 0.9 * (0.8 * t).cos(), 0.0);
        let mut body_from_world = nalgebra::UnitQuaternion::identity();
        let mut rows = level(8000);
        for (t, v) in &mut rows {
            let rate = rate(*t as f64 * 1e-9);
            body_from_world = nalgebra::UnitQuaternion::from_scaled_axis(-0.005 * rate) * body_from_world;
            let force = body_from_world * nalgebra::Vector3::new(0.0, 0.0, 9.81);
            (0..3)
                .for_each(|k| (v[k], v[3 + k]) = (v[k] + rate[k], v[3 + k] + force[k] - [0.0, 0.0, 9.81][k]));
            v[1] += bias;
        }
        text(&rows)
    };
    // On its side, and on its back.
    let laid = |scale: f64| {
        changed(6000, move |i, _, v| {
            let turn = (i as f64 / 200.0 - 14.0).clamp(0.0, 1.0);
            let (sin, cos) = (std::f64::consts::FRAC_PI_2 * turn).sin_cos();
            v[0] += if turn > 0.0 && turn < 1.0 { 1.57 } else { 0.0 };
            (v[4], v[5]) = (scale * (v[4] + 9.81 * sin), v[5] - 9.81 + 9.81 * cos);
        })
    };
    let pasted = text(&{
        let (mut all, rows) = (level(5000), level(3000));
        all[3000..].iter_mut().zip(&rows).for_each(|((_, v), (_, again))| *v = *again);
        all
    });
    let own = rows(4000, 4_000_000);
    let mut held = rows(6400, 2_500_000);
    held.iter_mut().enumerate().for_each(|(i, (_, v))| v[3..].copy_from_slice(&own[i * 5 / 8].1[3..]));
    let mut twice = level(3000);
    twice.extend(level(2000));
    vec![
        (
            "units",
            "--accel-unit g",
            told(&in_g, &["--accel-unit", "m/s^2"]),
            told(&in_g, &["--accel-unit", "g"]),
        ),
        (
            "units",
            "--accel-unit mg",
            told(&in_mg, &["--accel-unit", "m/s^2"]),
            told(&in_mg, &["--accel-unit", "mg"]),
        ),
        (
            "units",
            "--accel-unit cm/s^2",
            told(&in_gal, &["--accel-unit", "m/s^2"]),
            told(&in_gal, &["--accel-unit", "cm/s^2"]),
        ),
        ("frozen", "leave these seconds out", told(&stopped, &[]), told(&stopped, &["--from", "7.1"])),
        ("axes", "cut the log there", told(&flipped, &[]), told(&flipped, &["--to", "7.4"])),
        ("axes", "--columns orders them", told(&rolled, &[]), told(&rolled, &["--columns", "1,3,2,4,5,6,7"])),
        ("bias", "calibrate the gyroscope at rest", (waved(0.5), &[]), (waved(0.0), &[])),
        ("scale", "on its six sides", (laid(1.05), &[]), (laid(1.0), &[])),
        ("copies", "leave the second one out", told(&pasted, &[]), told(&pasted, &["--to", "14.9"])),
        ("overflow", "a larger measuring range", (over(1.0), &[]), (over(9.0), &[])),
        ("units", "--accel-unit m/s^2", told(&said_g, &[]), told(&said_g, &["--accel-unit", "m/s^2"])),
        (
            "units",
            "--sensor-scale NAME-RANGE",
            told(&counts, &[]),
            told(&counts, &["--sensor-scale", "mpu6050-2g-250dps"]),
        ),
        ("units", "--gyro-unit deg/s", told(&in_deg, &[]), told(&in_deg, &["--gyro-unit", "deg/s"])),
        ("columns", "--columns", told(&swapped, &[]), told(&swapped, &["--columns", "1,5,6,7,2,3,4"])),
        ("gravity", "log the specific force", (changed(3000, |_, _, v| v[5] -= 9.81), &[]), sound()),
        ("gravity", "calibrate its scale", told(&heavy, &[]), told(&heavy, &["--accel-scale", "0.9524"])),
        ("bias", "--gyro-unit deg/s", told(&biased, &[]), told(&biased, &["--gyro-unit", "deg/s"])),
        (
            "rate",
            "--time-unit s, ms, us",
            told(&in_us, &["--time-unit", "ms"]),
            told(&in_us, &["--time-unit", "us"]),
        ),
        ("jitter", "count them: --rate", told(&late, &[]), told(&late, &["--rate", "200"])),
        ("jitter", "count them: --rate", told(&bursts, &[]), told(&bursts, &["--rate", "200"])),
        ("gaps", "full buffer", (without(1000..1040), &[]), sound()),
        ("repeats", "log at its own rate", (frozen, &[]), sound()),
        ("held", "each sensor at its own rate", (text(&held), &[]), (text(&own), &[])),
        ("stamps", "count them (--rate)", told(&coarse, &[]), told(&coarse, &["--rate", "200"])),
        ("stamps", "published twice", (with_field(1500, 0, "7495000000"), &[]), sound()),
        ("stamps", "two writers", (with_field(1500, 0, "7450000001"), &[]), sound()),
        ("values", "a failed read", (with_field(1500, 2, "nan"), &[]), (without(1500..1501), &[])),
        ("values", "a failed read", (with_field(1500, 2, "1e300"), &[]), (without(1500..1501), &[])),
        ("rows", "what wrote them", (with_field(1500, 2, "1,2"), &[]), sound()),
        ("outliers", "leave such samples out", (with_field(1500, 2, "900"), &[]), (without(1500..1501), &[])),
        ("clipped", "a larger measuring range", (turning(1.0, 1.0), &[]), (turning(9.0, 1.0), &[])),
        ("dead", "the wiring or the column", (changed(3000, |_, _, v| v[1] = 0.0), &[]), sound()),
        ("steps", "a smaller measuring range", (stepped(0.0035), &[]), (stepped(0.0001), &[])),
        ("clock", "cut the log there", told(&jumped, &[]), told(&jumped, &["--from", "1400000000100000000"])),
        ("parts", "cut the log there", (text(&twice), &[]), sound()),
        ("drift", "warm up", told(&warms, &[]), told(&warms, &["--from", "50"])),
        ("vibration", "softer or balance", (at_hz(40.0), &[]), sound()),
        ("vibration", "switch on its low-pass filter", (at_hz(95.0), &[]), sound()),
    ]
}

/// What is found in these logs, one process for those that are checked alike.
fn findings_of(all: &[Told], dir: &Path) -> Vec<Vec<Value>> {
    let file = |place: usize| dir.join(format!("{place}.csv"));
    let mut alike: BTreeMap<&[&str], Vec<usize>> = BTreeMap::new();
    for (place, (text, flags)) in all.iter().enumerate() {
        std::fs::write(file(place), text).unwrap();
        alike.entry(*flags).or_default().push(place);
    }
    let mut found = vec![Vec::new(); all.len()];
    for (flags, places) in alike {
        // Of two and more there are no pictures.
        let logs = places.iter().chain(&places[..1]).map(|place| file(*place));
        let done =
            end(dpn().arg("check").args(logs).args(flags).arg("--json").arg("--out").arg(dir.join("out")));
        let json = done.well().json();
        for (place, log) in places.iter().zip(json["logs"].as_array().unwrap()) {
            found[*place] = log["findings"].as_array().unwrap_or_else(|| panic!("{place}: {log}")).clone();
        }
    }
    found
}

#[test]
fn every_remedy_when_followed_makes_its_finding_go() {
    let dir = tempfile::tempdir().unwrap();
    let faults = faults();
    let told: Vec<Told> =
        faults.iter().flat_map(|(.., sick, mended)| [sick.clone(), mended.clone()]).collect();
    let found = findings_of(&told, dir.path());
    for ((about, words, ..), found) in faults.iter().zip(found.chunks(2)) {
        let warns = |found: &Value| found["about"] == *about && found["weight"] != "note";
        let is_told = |found: &Value| warns(found) && found["remedy"].as_str().unwrap().contains(words);
        assert!(found[0].iter().any(is_told), "{about}, {words}: {:?}", found[0]);
        assert!(!found[1].iter().any(warns), "{about}, {words}: {:?}", found[1]);
    }
}

#[test]
fn a_cut_bag_recorded_again_and_covariances_written_anew_are_no_findings() {
    let dir = tempfile::tempdir().unwrap();
    let log = write(dir.path(), "still.csv", &text(&rows(8000, 5_000_000)));
    let bag = dir.path().join("still.mcap");
    run(&["noise"], &log, &["--noise", "const(3,.2)", "--into", bag.to_str().unwrap()]).well();
    let line = |done: &Done, about: &str| {
        done.stdout.lines().skip_while(|line| !line.contains(about)).take(2).collect::<Vec<_>>().join("\n")
    };
    let moving = end(dpn().arg("run").arg(&bag));
    assert!(moving.code == Some(2) && moving.stderr.contains("no images on any topic"), "{moving:?}");
    let done = check(&bag, &[]).well();
    let found = line(&done, "warning: covariance: ");
    assert!(found.contains("`dpn noise LOG --into FILE.mcap` writes them anew"), "{done:?}");
    let anew = dir.path().join("anew.mcap");
    run(&["noise"], &bag, &["--noise", "diff2", "--into", anew.to_str().unwrap()]).well();
    let done = check(&anew, &[]).well();
    assert!(warned(&done).is_empty(), "{done:?}");
    let whole = std::fs::read(&anew).unwrap();
    let cut = dir.path().join("cut.mcap");
    std::fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    let done = check(&cut, &[]).well();
    assert!(line(&done, " damage: ").contains("-> copy or record it again"), "{done:?}");
}
