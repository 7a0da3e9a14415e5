//! Logs of every kind and with every fault, through `dpn check`: what is wrong is said in one line each, what is left is used, and where
//! nothing is left the exit code is 2.

use crate::recording::{HEADER, put, rows, text};
use crate::run::{Done, dpn, end, finished};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

fn bags() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/bags")
}

fn check(dir: &Path, log: &Path, more: &[&str]) -> Done {
    end(dpn().arg("check").arg(log).arg("--out").arg(dir.join("out")).args(more))
}

/// Checks made-up text in a file.
fn check_text(text: &str, more: &[&str]) -> Done {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    check(dir.path(), &path, more)
}

/// The lines of a page about `about`, with their weight.
fn about(done: &Done, about: &str) -> Vec<String> {
    let marked = |line: &&str| {
        line.split_once(": ").is_some_and(|(_, rest)| {
            rest.starts_with(&format!("{about}: ")) || rest.trim_start().starts_with(&format!("{about}: "))
        })
    };
    done.stdout.lines().filter(marked).map(str::to_owned).collect()
}

#[test]
fn bags_of_every_kind_are_read_and_a_topic_is_asked_for_where_there_are_two() {
    let dir = tempfile::tempdir().unwrap();
    for name in [
        "plain.bag",
        "lz4.bag",
        "bz2.bag",
        "plain.mcap",
        "lz4.mcap",
        "zstd.mcap",
        "mcap",
        "sqlite",
        "sqlite/sqlite.db3",
    ] {
        let done = check(dir.path(), &bags().join(name), &[]).well();
        assert!(done.stdout.starts_with("12 samples, 0.1 s, 100.00 Hz\n"), "{name}: {done:?}");
    }
    let two = bags().join("two_imus.bag");
    let done = check(dir.path(), &two, &[]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(
        done.stderr.ends_with("two_imus.bag: 2 IMU topics: /imu0 (12 messages), /imu1 (12 messages)\n\nhint: say which one: --topic /imu0\n"),
        "{done:?}"
    );
    check(dir.path(), &two, &["--topic", "/imu1"]).well();
    let done = check(dir.path(), &two, &["--topic", "/imu2"]);
    assert!(done.code == Some(2) && done.stderr.contains("\n\nhint: did you mean `/imu"), "{done:?}");
    let done = check(dir.path(), &bags().join("no_imu.bag"), &[]);
    assert!(
        done.code == Some(2)
            && done.stderr.contains("no topic of type sensor_msgs/Imu; it has /talk (std_msgs/String)"),
        "{done:?}"
    );
}

#[test]
fn a_bag_cut_off_or_damaged_is_used_up_to_there_and_one_of_nothing_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cut.bag");
    let whole = std::fs::read(bags().join("plain.bag")).unwrap();
    std::fs::write(&path, &whole[..3 * whole.len() / 4]).unwrap();
    let done = check(dir.path(), &path, &[]).well();
    assert!(about(&done, "damage")[0].contains("cut off in the "), "{done:?}");
    std::fs::write(&path, &whole[..600]).unwrap();
    let done = check(dir.path(), &path, &[]);
    assert!(
        done.code == Some(2) && done.stderr.contains("hint: the bag is damaged (cut off in the "),
        "{done:?}"
    );
    let mut bytes = std::fs::read(bags().join("lz4.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 40].fill(0xaa);
    let path = dir.path().join("damaged.mcap");
    std::fs::write(&path, bytes).unwrap();
    let done = check(dir.path(), &path, &[]).well();
    assert!(about(&done, "damage")[0].contains("the chunk at byte "), "{done:?}");
    let path = dir.path().join("other.db3");
    std::fs::write(&path, "no database").unwrap();
    let done = check(dir.path(), &path, &[]);
    assert!(done.code == Some(2) && done.stderr.contains("does not begin as a db3 file does"), "{done:?}");
}

#[test]
fn stamps_that_repeat_or_go_back_and_nan_are_left_out_and_said_with_their_line() {
    let mut sick = rows(3000, 5_000_000);
    sick[100].0 = sick[99].0;
    sick[200].0 = sick[150].0;
    let mut lines: Vec<String> = text(&sick).lines().map(str::to_owned).collect();
    lines[301] = lines[301].rsplit_once(',').unwrap().0.to_owned() + ",NaN";
    let done = check_text(&lines.join("\n"), &[]).well();
    assert_eq!(
        about(&done, "stamps"),
        [
            "warning: stamps: left out: 1 sample(s) with the stamp of the one before, first at line 102",
            "warning: stamps: left out: 1 sample(s) whose stamp goes back, first at line 202",
        ]
    );
    assert_eq!(
        about(&done, "values"),
        ["warning: values: left out: 1 sample(s) with NaN or infinite values, first at line 302"]
    );
    assert!(about(&done, "gaps")[0].contains("3 hole(s), about 3 samples lost"), "{done:?}");
    // Backwards throughout: nothing can be done.
    let mut reversed = rows(3000, 5_000_000);
    reversed.reverse();
    let done = check_text(&text(&reversed), &[]);
    assert!(
        done.code == Some(2)
            && done.stderr.contains("time goes back at 2999 of 3000 samples, first at line 3"),
        "{done:?}"
    );
}

#[test]
fn a_last_line_cut_off_and_rows_that_cannot_be_read_are_said() {
    let whole = text(&rows(3000, 5_000_000));
    let cut = &whole[..whole.len() - 40];
    let done = check_text(cut, &[]).well();
    assert!(about(&done, "damage")[0].contains("its last line is cut off"), "{done:?}");
    let odd = whole.replacen(",9.", ",nine.", 1);
    let done = check_text(&odd, &[]).well();
    assert!(
        about(&done, "rows")[0].contains("left out: 1 row(s) that cannot be read, the first: "),
        "{done:?}"
    );
    let done = check_text(&whole.replace(",9.", ",nine."), &[]);
    assert!(done.code == Some(2) && done.stderr.contains("log.csv:2: accel_z is \"nine."), "{done:?}");
}

#[test]
fn swapped_columns_mixed_units_clipped_and_dead_axes_and_dropped_samples_are_told_apart() {
    let sick = |change: fn(usize, &mut [f64; 6])| {
        let mut rows = rows(4000, 5_000_000);
        for (i, (_, values)) in rows.iter_mut().enumerate() {
            change(i, values);
        }
        check_text(&text(&rows), &[]).well()
    };
    let done = sick(|_, v| v.rotate_left(3));
    assert!(
        about(&done, "columns")[0].starts_with("bad:     columns: gravity stands in the gyroscope's columns"),
        "{done:?}"
    );
    let done = sick(|_, v| (v[3], v[4], v[5]) = (v[3] / 9.80665, v[4] / 9.80665, v[5] / 9.80665));
    assert!(about(&done, "units")[0].contains("it counts in g"), "{done:?}");
    let done = sick(|_, v| v[5] -= 9.81);
    assert!(about(&done, "gravity")[0].contains("gravity is missing"), "{done:?}");
    let done = sick(|i, v| v[1] = (v[1] + 60.0 * (i as f64 * 0.01).sin()).min(40.0));
    assert!(about(&done, "units")[0].contains("it counts in degrees, or clips"), "{done:?}");
    let done = sick(|i, v| v[3] = (v[3] + 30.0 * (i as f64 * 0.3).sin()).clamp(-19.6, 19.6));
    assert!(about(&done, "clipped")[0].contains("accel x is saturated: it stays at "), "{done:?}");
    let done = sick(|_, v| v[2] = 0.25);
    assert!(about(&done, "dead")[0].contains("gyro z is dead: it reads 0.25"), "{done:?}");
    let mut rows = rows(4000, 5_000_000);
    rows.drain(1000..1050);
    let done = check_text(&text(&rows), &[]).well();
    assert!(about(&done, "gaps")[0].contains("1 hole(s), about 50 samples lost; at 5.00"), "{done:?}");
}

#[test]
fn units_that_nobody_named_are_guessed_and_a_flag_wins() {
    let plain: String = rows(3000, 5_000_000)
        .iter()
        .map(|(t, v)| {
            format!(
                "{},{},{},{},{},{},{}\n",
                t / 1000,
                v[3] / 9.80665,
                v[4] / 9.80665,
                v[5] / 9.80665,
                v[0],
                v[1],
                v[2]
            )
        })
        .collect();
    let done = check_text(&plain, &[]).well();
    let taken = &about(&done, "taken for granted")[0];
    for words in [
        "columns as stamp, accelerometer, gyroscope",
        "stamps in us",
        "gyroscope in rad/s",
        "accelerometer in g",
    ] {
        assert!(taken.contains(words), "{words}: {taken}");
    }
    assert!(about(&done, "gravity")[0].contains("the accelerometer reads 9.8"), "{done:?}");
    let done = check_text(
        &plain,
        &["--columns", "1,5,6,7,2,3,4", "--accel-unit", "m/s^2", "--gyro-unit", "rad/s", "--time-unit", "us"],
    )
    .well();
    assert!(about(&done, "taken for granted").is_empty(), "{done:?}");
    assert!(about(&done, "units")[0].contains("it counts in g"), "{done:?}");
}

#[test]
fn what_is_no_log_is_refused_with_what_was_looked_for() {
    let dir = tempfile::tempdir().unwrap();
    check(dir.path(), &dir.path().join("gone.csv"), &[]).refused(
        dir.path(),
        "error: [DIR]/gone.csv does not exist\n\nhint: [DIR] is there; look at the rest of the path",
    );
    let empty = dir.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    check(dir.path(), &empty, &[]).refused(
        dir.path(),
        "error: no log in [DIR]/empty: looked for mav0/imu0/data.csv, imu0/data.csv, *.mcap, *.db3, a *gyro* and an \
         *accel* file\n\nhint: give a CSV file, a bag, a ULog or ArduPilot log, or the folder of an ASL sequence (it holds `mav0` or `imu0`), of a \
         rosbag2 or of a phone's two files",
    );
    let data = put(&dir.path().join("logs"), "still", &text(&rows(300, 5_000_000)));
    let done = end(dpn().arg("allan").arg(&data).arg("--out").arg(dir.path().join("out")));
    assert!(
        done.code == Some(2) && done.stderr.contains("hint: there are 1 below it: give one, for example "),
        "{done:?}"
    );
    let done = check(dir.path(), &data.join("still"), &["--topic", "/imu0"]);
    assert!(
        done.code == Some(2) && done.stderr.contains("--topic is for bags, and this is none: ASL folder"),
        "{done:?}"
    );
    let done = check_text(HEADER, &[]);
    assert!(done.code == Some(2) && done.stderr.contains("no row of data"), "{done:?}");
}

/// Ends a command that reads `input` on stdin, or the pipe at `path` where there is one.
fn piped(args: &[&str], input: &[u8], dir: &Path) -> Done {
    let mut command = dpn();
    command.args(args).current_dir(dir).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A program that refuses its input closes it early.
    let _ = child.stdin.take().unwrap().write_all(input);
    finished(child.wait_with_output().unwrap())
}

#[test]
fn a_log_on_stdin_or_in_a_pipe_says_what_its_file_says() {
    let dir = tempfile::tempdir().unwrap();
    let csv = text(&rows(6000, 5_000_000)).into_bytes();
    std::fs::write(dir.path().join("log.csv"), &csv).unwrap();
    let page = |done: Done| done.well().stdout.replace("stdin", "LOG").replace("log.csv", "LOG");
    for command in ["check", "noise", "allan"] {
        let file = page(piped(&[command, "log.csv"], b"", dir.path()));
        assert_eq!(page(piped(&[command, "-"], &csv, dir.path())), file, "{command}");
        #[cfg(target_os = "linux")]
        assert_eq!(page(piped(&[command, "/dev/stdin"], &csv, dir.path())), file, "{command}");
    }
    for name in ["plain.bag", "lz4.bag", "bz2.bag", "plain.mcap", "zstd.mcap", "sqlite/sqlite.db3"] {
        let bytes = std::fs::read(bags().join(name)).unwrap();
        let done = piped(&["check", "-"], &bytes, dir.path()).well();
        assert!(done.stdout.starts_with("12 samples, 0.1 s, 100.00 Hz\n"), "{name}: {done:?}");
        assert_eq!(
            done.stdout.contains("copied to a temporary file first"),
            name.ends_with("db3"),
            "{done:?}"
        );
    }
    let done = piped(&["check", "-"], b"", dir.path());
    assert!(
        done.code == Some(2) && done.stderr.starts_with("error: stdin: empty, not a byte came"),
        "{done:?}"
    );
    let config = b"acc_n: 0.08\nacc_w: 4e-5\ngyr_n: 0.004\ngyr_w: 2e-6\n";
    let done =
        piped(&["noise", "convert", "-", "--to", "kalibr", "--rate", "200"], config, dir.path()).well();
    assert!(done.stdout.contains("accelerometer_noise_density"), "{done:?}");
}

#[test]
fn names_that_steer_a_terminal_are_spelt_out() {
    let dir = tempfile::tempdir().unwrap();
    let mut bag = std::fs::read(bags().join("plain.bag")).unwrap();
    // A name of the same length, so that all counts stay right.
    while let Some(at) = bag.windows(5).position(|w| w == b"/imu0") {
        bag[at..at + 5].copy_from_slice(b"/\x1b[2J");
    }
    let path = dir.path().join("evil.bag");
    std::fs::write(&path, bag).unwrap();
    let done = check(dir.path(), &path, &["--topic", "/other"]);
    assert!(done.code == Some(2) && done.stderr.contains(", /\\u{1b}[2J (sensor_msgs/Imu)"), "{done:?}");
    assert!(!done.stderr.contains('\u{1b}'), "{done:?}");
    // What is shown can be typed.
    check(dir.path(), &path, &["--topic", "/\\u{1b}[2J"]).well();
    let done = check_text("time,\x1b]0;owned\x07,gy,gz,ax,ay,az\n1,2,3,4,5,6,7\n2,2,3,4,5,6,7\n", &[]);
    assert!(done.code == Some(2) && done.stderr.contains("\\u{1b}]0;owned\\u{7}"), "{done:?}");
    for said in [done.stderr, done.stdout] {
        assert!(!said.contains(['\u{1b}', '\u{7}']), "{said:?}");
    }
}

#[test]
fn a_bag_that_unpacks_to_far_more_than_it_has_is_cut_off_there_unless_that_is_wanted() {
    let dir = tempfile::tempdir().unwrap();
    // The records of a sound bag, then a chunk of forty million zeros in fifty bytes, twice.
    let mut bag = std::fs::read(bags().join("plain.bag")).unwrap();
    let field = |text: &[u8]| [&(text.len() as u32).to_le_bytes()[..], text].concat();
    let header = [
        field(b"op=\x05"),
        field(b"compression=bz2"),
        field(&[b"size=", &80_000_000u32.to_le_bytes()[..]].concat()),
    ]
    .concat();
    let zeros = ZEROS.repeat(2);
    bag.extend(
        [&(header.len() as u32).to_le_bytes()[..], &header, &(zeros.len() as u32).to_le_bytes(), &zeros]
            .concat(),
    );
    let path = dir.path().join("bomb.bag");
    std::fs::write(&path, bag).unwrap();
    let done = check(dir.path(), &path, &[]).well();
    assert!(
        about(&done, "damage")[0]
            .contains("unpacks to more than 32 MB, from 102 bytes; --max-uncompressed 4GB lets it"),
        "{done:?}"
    );
    let done = check(dir.path(), &path, &["--max-uncompressed", "100MB"]).well();
    assert!(!done.stdout.contains("unpacks to more"), "{done:?}");
    let done = check(dir.path(), &path, &["--max-uncompressed", "much"]);
    assert!(done.code == Some(2) && done.stderr.contains("for example 4GB or 500MB"), "{done:?}");
}

/// Forty million zeros, as bz2 packs them.
const ZEROS: [u8; 51] = [
    0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0xd8, 0xec, 0xdd, 0xfe, 0x01, 0x32, 0x5f,
    0x40, 0x08, 0xc0, 0x00, 0x00, 0x10, 0x00, 0x08, 0x20, 0x00, 0x30, 0xcc, 0x09, 0xaa, 0x69, 0xa0, 0x4a,
    0x51, 0x5b, 0x50, 0x12, 0x94, 0x57, 0x8b, 0xb9, 0x22, 0x9c, 0x28, 0x48, 0x6c, 0x76, 0x6e, 0xff, 0x00,
];

/// Logs as people have them: none needs more than its name, and what was assumed is one line.
#[test]
fn logs_of_every_program_go_in_untouched_and_what_was_assumed_is_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/logs");
    let expected = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: serde_json::Value = serde_json::from_str(&expected).unwrap();
    let mut faults = Vec::new();
    for (name, expected) in expected["logs"].as_object().unwrap() {
        let flags: Vec<&str> =
            expected["flags"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
        let done = check(dir.path(), &folder.join(name), &flags);
        let head = format!("{} samples, ", expected["count"]);
        let rate = format!("{:.2} Hz", expected["rate_hz"].as_f64().unwrap());
        let first = done.stdout.lines().next().unwrap_or_default();
        if done.code != Some(0) || !first.starts_with(&head) || !first.ends_with(&rate) {
            faults.push(format!("{name}: {done:?}"));
        }
        let taken = about(&done, "taken for granted");
        let guesses = expected["guesses"].as_array().unwrap();
        let said =
            |words: &serde_json::Value| taken.iter().any(|line| line.contains(words.as_str().unwrap()));
        if taken.len() > 1 || !guesses.iter().all(said) {
            faults.push(format!("{name}: {taken:?} lacks one of {guesses:?}"));
        }
        // Gravity is where it belongs, in its unit.
        if !about(&done, "gravity").iter().any(|line| line.contains("the accelerometer reads 9.")) {
            faults.push(format!("{name}: {done:?}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn raw_counts_are_asked_about_and_mended_by_scale_or_sensor() {
    let dir = tempfile::tempdir().unwrap();
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/logs/counts.csv");
    let done = check(dir.path(), &log, &[]).well();
    let units = &about(&done, "units")[0];
    assert!(
        units.contains("raw counts, all of them whole numbers? Some 16")
            && done.stdout.contains("--sensor-scale NAME-RANGE"),
        "{done:?}"
    );
    let sensor = check(dir.path(), &log, &["--sensor-scale", "mpu6050-2g-250dps", "--json"]).well();
    let (accel, gyro) = ((9.80665f64 / 16384.0).to_string(), (1.0f64 / 131.0).to_radians().to_string());
    let scales = check(dir.path(), &log, &["--accel-scale", &accel, "--gyro-scale", &gyro, "--json"]).well();
    assert_eq!(sensor.stdout, scales.stdout);
    let done = check(dir.path(), &log, &["--sensor-scale", "mpu9250-2g"]);
    assert!(done.code == Some(2) && done.stderr.contains("known are mpu6050-{2/4/8/16}g"), "{done:?}");
    let done = check(dir.path(), &log, &["--accel-scale", "0"]);
    assert_eq!(done.code, Some(2), "{done:?}");
}

#[test]
fn columns_are_chosen_by_name_and_a_rate_that_disagrees_with_the_text_is_a_finding() {
    let mut rows = rows(400, 5_000_000);
    rows.iter_mut().for_each(|(t, _)| *t -= 1_400_000_000_000_000_000);
    let body: String = text(&rows).lines().skip(1).map(|line| format!("{line}\n")).collect();
    let odd = format!("# rate: 100 Hz\nwhen,p,q,r,u,v,w\n{body}");
    let done = check_text(&odd, &[]);
    assert!(done.code == Some(2) && done.stderr.contains("--columns T,GX,GY,GZ,AX,AY,AZ"), "{done:?}");
    let done = check_text(&odd, &["--columns", "when,p,q,R,5,v,w"]).well();
    assert!(done.stdout.starts_with("400 samples, 2.0 s, 200.00 Hz\n"), "{done:?}");
    assert!(
        about(&done, "rate")
            .iter()
            .any(|line| line.contains("the log's text says 100 Hz, its stamps 200.00 Hz")),
        "{done:?}"
    );
    let done = check_text(&odd, &["--columns", "when,p,q,s,u,v,w"]);
    assert!(
        done.code == Some(2) && done.stderr.contains("no column `s`; the header names when, p, q"),
        "{done:?}"
    );
    let done = check_text(&odd, &["--columns", "when,p,q,r,u,v,w", "--time-unit", "us"]).well();
    assert!(about(&done, "rate").iter().any(|line| line.contains("in a unit 1000 times ")), "{done:?}");
}
