//! `dpn noise LOG`: the track, its summary, what is out of range, and a configuration against it.

use crate::recording::{Rows, put, rows, text};
use crate::run::{Done, dpn, end, files};
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

/// 20 s at rest, 20 s of motors, 20 s of flight, at `step_ns`.
fn flight(step_ns: i64) -> Rows {
    let per_second = 1_000_000_000 / step_ns;
    let mut all = rows(60 * per_second as usize, step_ns);
    for (i, (_, values)) in all.iter_mut().enumerate() {
        let t = i as f64 / per_second as f64;
        if t >= 20.0 {
            values[3] += 1.2 * (2.0 * std::f64::consts::PI * 61.0 * t).sin();
        }
        if t >= 40.0 {
            values[0] += 0.8 * (2.0 * t).sin();
        }
    }
    all
}

fn noise(dir: &Path, rows: &Rows, more: &[&str]) -> Done {
    let data = put(&dir.join("log"), "log", &text(rows));
    end(dpn().arg("noise").arg(data.join("log")).arg("--out").arg(dir.join("out")).args(more))
}

#[test]
fn the_page_has_the_phases_and_shouts_what_is_out_of_range() {
    let dir = tempfile::tempdir().unwrap();
    let done = noise(dir.path(), &flight(5_000_000), &["--noise", "dualpronet"]).well();
    assert!(done.stderr.contains("warning: OUT OF RANGE: "), "{done:?}");
    assert!(
        done.stderr.contains("of the accel windows are unlike anything its network was trained on"),
        "{done:?}"
    );
    let rows: Vec<String> =
        done.stdout.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    for words in ["noise by dualpronet, every 10 samples", "at rest 20 s ", "motors on 20 s ", "moving 20 s "]
    {
        assert!(rows.iter().any(|row| row.starts_with(words)), "{words}: {}", done.stdout);
    }
    // What is extrapolated is no number to set against another: the spans are named, in the picture too.
    assert!(!done.stdout.contains("times as noisy"), "{done:?}");
    assert!(
        done.stdout
            .contains("accel: how much noisier moving than at rest is not known: moving it is out of range"),
        "{done:?}"
    );
    assert!(done.stdout.contains("accel out of range: s 1.0-60.0\n"), "{done:?}");
    let svg = std::fs::read_to_string(dir.path().join("out/plot.svg")).unwrap();
    assert!(svg.contains("accel out of range: s 1.0-60.0"), "the small print lists what is extrapolated");
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["noise.csv", "plot.csv", "plot.pdf", "plot.png", "plot.svg", "summary.json"]);
}

#[test]
fn a_simple_estimator_says_how_much_noisier_moving_is() {
    let dir = tempfile::tempdir().unwrap();
    let done = noise(dir.path(), &flight(5_000_000), &["--noise", "diff2"]).well();
    assert!(done.stdout.contains("times as noisy moving as at rest"), "{done:?}");
}

/// The promise of the command: what it says at a time does not depend on what comes later.
#[test]
fn the_track_of_a_log_cut_anywhere_is_that_of_the_whole_up_to_there() {
    let dir = tempfile::tempdir().unwrap();
    let all = flight(2_500_000);
    for spec in ["dualpronet", "diff2"] {
        let track = |rows: &Rows| {
            noise(dir.path(), rows, &["--noise", spec, "--every", "7"]).well();
            std::fs::read_to_string(dir.path().join("out/noise.csv")).unwrap()
        };
        let whole = track(&all);
        for cut in [500, 3001, 14_007, 23_999] {
            let part = track(&all[..cut].to_vec());
            assert_eq!(part.lines().count(), 1 + cut.div_ceil(7));
            assert!(whole.starts_with(&part), "{spec} {cut}");
        }
    }
}

#[test]
fn json_lines_summary_and_white_noise_of_a_simple_estimator() {
    let dir = tempfile::tempdir().unwrap();
    let done =
        noise(dir.path(), &rows(12_000, 5_000_000), &["--noise", "diff2", "--json", "--format", "jsonl"])
            .well();
    let json = done.json();
    assert_eq!((json["noise"].as_str(), json["rate_hz"].as_f64()), (Some("diff2"), Some(200.0)));
    assert_eq!(json["summary"]["outside"].as_array().map(Vec::len), Some(0));
    let whole = &json["summary"]["phases"][0];
    assert_eq!(whole["axes"].as_array().unwrap().len(), 6);
    // Uniform noise of a width of .05 and .004.
    for (axis, width) in [(0, 0.05), (3, 0.004)] {
        let middle = whole["axes"][axis]["sigma"]["middle"].as_f64().unwrap();
        assert!((middle / (width / 12f64.sqrt()) - 1.0).abs() < 0.05, "{middle}");
    }
    assert_eq!(json["summary"]["phases"][1]["phase"], "rest");
    let lines = std::fs::read_to_string(dir.path().join("out/noise.jsonl")).unwrap();
    let first: serde_json::Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(first["t_ns"].as_i64(), Some(1_400_000_000_000_000_000));
    assert_eq!(lines.lines().count(), 1200);
}

#[test]
fn another_rate_gets_a_simple_estimator_and_is_refused_for_networks() {
    let dir = tempfile::tempdir().unwrap();
    let slow = rows(6000, 25_000_000);
    let done = noise(dir.path(), &slow, &[]).well();
    assert!(done.stderr.contains("the simple estimator diff2 is asked instead"), "{done:?}");
    noise(dir.path(), &slow, &["--noise", "dualpronet"]).refused(
        dir.path(),
        "error: the log has 40.0 Hz; the networks of `dualpronet` were trained at 50.0 Hz and count samples, not time\n\n\
         hint: faster logs are averaged to 50 Hz by themselves, a slower one has too few samples: train networks of its rate (dpn train --rate 40), let the odometry find its noise (dpn run --noise self), or give a simple estimator (--noise diff2)",
    );
    for (step_ns, words) in [
        (2_500_000, "the networks saw means of 2 samples (200 Hz; trained at 200 Hz)"),
        (8_000_000, "the networks saw every sample (125 Hz; trained at 100 Hz)"),
    ] {
        let done = noise(dir.path(), &rows(6000, step_ns), &[]).well();
        assert!(done.stdout.contains(words), "{done:?}");
    }
    for step_ns in [10_000_000, 20_000_000] {
        let done = noise(dir.path(), &rows(6000, step_ns), &["--noise", "dualpronet"]).well();
        assert!(!done.stdout.contains("the networks saw means"), "{done:?}");
    }
    let done = noise(dir.path(), &slow, &["--noise", "shuffled(x1)"]);
    assert!(done.code == Some(2) && done.stderr.contains("is not causal"), "{done:?}");
    let done = noise(dir.path(), &rows(150, 5_000_000), &[]);
    assert!(done.code == Some(2) && done.stderr.contains("the first window alone has 1.00 s"), "{done:?}");
}

/// `rows` behind one pole at 20 Hz of 200.
fn behind(rows: &mut Rows) {
    let k = (0.1 * std::f64::consts::PI).tan();
    let (mut x, mut y) = (rows[0].1, rows[0].1);
    for (_, values) in rows {
        for axis in 0..6 {
            y[axis] = (k * (values[axis] + x[axis]) + (1.0 - k) * y[axis]) / (1.0 + k);
        }
        (x, *values) = (*values, y);
    }
}

#[test]
fn an_estimate_that_the_spectrum_at_rest_contradicts_is_no_figure() {
    let dir = tempfile::tempdir().unwrap();
    let mut still = rows(6_000, 5_000_000);
    let said =
        |rows: &Rows, name: &str| noise(&dir.path().join(name), rows, &["--noise", "diff2"]).well().stderr;
    let white = said(&still, "white");
    assert!(!white.contains("NOT KNOWN"), "{white}");
    behind(&mut still);
    let hidden = said(&still, "hidden");
    for sensor in ["accel", "gyro"] {
        let found = hidden.lines().any(|line| {
            line.starts_with("warning: NOT KNOWN: at rest diff2 says")
                && line.contains(&format!("of the {sensor}'s "))
        });
        assert!(found, "{sensor}: {hidden}");
    }
}

/// 40 s in motion behind one pole and behind two, a log whose rate changes, and a gyroscope that is off.
#[test]
fn what_a_figure_cannot_be_made_of_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let mut white = rows(8000, 5_000_000);
    for poles in [1, 2] {
        behind(&mut white);
        let mut turning = white.clone();
        turning
            .iter_mut()
            .enumerate()
            .for_each(|(i, (_, values))| values[0] += 0.8 * (0.01 * i as f64).sin());
        let done = noise(dir.path(), &turning, &[]).well();
        if poles == 1 {
            let shape =
                done.stdout.matches("in motion, by the shape of a low pass (1st order, about").count();
            assert_eq!(shape, 2, "{done:?}");
        } else {
            let words = "NOT KNOWN: the gyro's spectrum above 35 Hz falls as behind a low pass";
            assert!(done.stderr.contains(words), "{done:?}");
            assert!(done.stdout.contains("gyroscope noise: not known, above 35 Hz"), "{done:?}");
        }
    }
    let mut halved = rows(8000, 5_000_000);
    let mut index = 0;
    halved.retain(|_| {
        index += 1;
        index < 4000 || index % 2 == 0
    });
    let done = noise(dir.path(), &halved, &[]).well();
    assert!(done.stderr.contains("the rate changes at 20.0 s from 200.0 to 100.0 Hz"), "{done:?}");
    let mut off = rows(4000, 5_000_000);
    off.iter_mut().for_each(|(_, values)| values[..3].fill(0.0));
    let done = noise(dir.path(), &off, &["--paste", "vins"]).well();
    assert!(done.stdout.contains("gyroscope noise: not known, its values are zeros"), "{done:?}");
    assert!(done.stdout.contains("\nacc_n: ") && !done.stdout.contains("\ngyr_n: "), "{done:?}");
}

#[test]
fn a_configuration_is_held_against_floor_and_envelope() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("vins.yaml");
    let check = |acc: f64, gyr: f64| {
        std::fs::write(&config, format!("acc_n: {acc}\nacc_w: 4e-5\ngyr_n: {gyr}\ngyr_w: 2e-6\n")).unwrap();
        noise(dir.path(), &flight(5_000_000), &["--noise", "diff2", "--check", config.to_str().unwrap()])
            .well()
    };
    let line = |done: &Done, key: &str| {
        done.stdout.lines().find(|l| l.contains(&format!("`{key}` is"))).unwrap_or_default().to_owned()
    };
    // At rest .0144 and .00115; the accelerometer shakes by much more in the air.
    let done = check(1.0, 0.00115 * 57.3);
    assert!(
        line(&done, "acc_n").starts_with("ok:      accelerometer noise")
            && line(&done, "acc_n").ends_with("fits the log in motion"),
        "{done:?}"
    );
    assert!(
        line(&done, "gyr_n").starts_with("warning:")
            && line(&done, "gyr_n").contains("degrees where radians belong"),
        "{done:?}"
    );
    let done = check(0.0144 / 200f64.sqrt(), 0.00115);
    assert!(
        line(&done, "acc_n").contains(
            "the IMU is trusted too much; looks like a density where a deviation per sample belongs"
        ),
        "{done:?}"
    );
    assert!(line(&done, "gyr_n").starts_with("ok:"), "{done:?}");
    let done = check(0.02, 0.00115);
    assert!(line(&done, "acc_n").contains("fits the sensor at rest, "), "{done:?}");
    // The networks say what they can of 1.2 m/s^2 at 61 Hz; what is compared is the signal's own, whatever is asked of the track.
    let envelope = |spec: &str| {
        let done = noise(
            dir.path(),
            &flight(5_000_000),
            &["--noise", spec, "--json", "--check", config.to_str().unwrap()],
        );
        done.well().json()["check"]["white"][0].clone()
    };
    let by_networks = envelope("dualpronet");
    assert_eq!(by_networks, envelope("diff2"));
    let in_motion = by_networks["in_motion"].as_f64().unwrap();
    assert!((in_motion / (1.2 / 2f64.sqrt()) - 1.0).abs() < 0.12, "{by_networks}");
    // A zero is a warning with a remedy, a negative number is refused.
    std::fs::write(&config, "acc_n: 0\nacc_w: 4e-5\ngyr_n: 0.002\ngyr_w: 0.0\n").unwrap();
    let done = noise(dir.path(), &flight(5_000_000), &["--check", config.to_str().unwrap()]).well();
    for key in ["acc_n", "gyr_w"] {
        assert!(line(&done, key).starts_with("warning:"), "{key}: {done:?}");
        assert!(line(&done, key).contains("put the sensor's figure there"), "{key}: {done:?}");
    }
    for bad in ["-0.1", ".nan"] {
        std::fs::write(&config, format!("acc_n: {bad}\nacc_w: 4e-5\ngyr_n: 1\ngyr_w: 2e-6\n")).unwrap();
        let done = noise(dir.path(), &flight(5_000_000), &["--check", config.to_str().unwrap()]);
        assert!(done.code == Some(2) && done.stderr.contains("vins.yaml:1: "), "{done:?}");
    }
}

#[test]
fn deviations_follow_lines_on_stdin_and_are_those_of_the_log() {
    let dir = tempfile::tempdir().unwrap();
    let all = flight(5_000_000);
    noise(dir.path(), &all, &[]).well();
    let whole = std::fs::read_to_string(dir.path().join("out/noise.csv")).unwrap();
    let mut child = dpn()
        .args(["noise", "--follow"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut lines = text(&all);
    lines.push_str("what is this\n");
    let writer = std::thread::spawn(move || input.write_all(lines.as_bytes()).unwrap());
    let done = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(done.status.success(), "{done:?}");
    assert_eq!(String::from_utf8(done.stdout).unwrap(), whole);
    let stderr = String::from_utf8(done.stderr).unwrap();
    // Half of the log turns, and the network hears some of that in the gyroscope, which the spectrum does not.
    assert!(
        stderr.lines().any(|line| line.starts_with("warning: NOT KNOWN: the gyro's spectrum")),
        "{stderr}"
    );
    assert!(stderr.ends_with("\nwarning: stdin:12002: 1 fields, expected 7; passed over\n"), "{stderr}");
    let done = end(dpn().args(["noise", "--follow"]).stdin(Stdio::null())).well();
    assert_eq!(done.stdout.lines().count(), 1);
}

#[test]
fn a_log_is_written_again_with_the_covariances_of_its_track() {
    let dir = tempfile::tempdir().unwrap();
    let into = dir.path().join("into.mcap");
    let into = into.to_str().unwrap();
    let rows = flight(5_000_000);
    let done = noise(dir.path(), &rows, &["--noise", "const(0.5,0.25)", "--into", into]).well();
    assert!(done.stdout.contains(&format!("log:      {into} (12000 messages of /imu)")), "{done:?}");
    assert!(done.stderr.contains("is copied by its samples alone"), "{done:?}");
    // That log copied in turn: message by message, but for the second before the first window.
    let again = dir.path().join("again.mcap");
    let out = dir.path().join("out");
    let copy = |into: &Path, more: &[&str]| {
        end(dpn()
            .args(["noise", dir.path().join("into.mcap").to_str().unwrap(), "--noise", "diff2"])
            .arg("--into")
            .arg(into)
            .arg("--out")
            .arg(&out)
            .args(more))
    };
    let done = copy(&again, &["--json"]).well();
    let words = done.json()["into"]["messages"].as_str().unwrap().to_owned();
    assert_eq!(
        words,
        "11800 messages of /imu with covariances, 200 before the first window as they were, 0 of other topics"
    );
    let (first, second) = (std::fs::read(into).unwrap(), std::fs::read(&again).unwrap());
    assert!(first.len() == second.len() && first != second, "the same messages, other covariances");
    for (into, more, words) in [
        (dir.path().join("into.mcap"), &[][..], "into.mcap, which is read"),
        (dir.path().join("c.mcap"), &["--accel-scale", "0.01"][..], "are said not to be SI units"),
    ] {
        let refused = copy(&into, more);
        assert!(refused.code == Some(2) && refused.stderr.contains(words), "{refused:?}");
    }
    assert_eq!(std::fs::read(into).unwrap(), first);
}

#[test]
fn the_networks_of_a_folder_are_asked_alone_and_what_is_not_there_is_an_error() {
    let tmp = tempfile::tempdir().unwrap();
    let log = crate::recording::sound(tmp.path()).join("still");
    // The gyroscope's network in the accelerometer's place, under its name.
    let own = tmp.path().join("own/accel/sg11-s0.safetensors");
    std::fs::create_dir_all(own.parent().unwrap()).unwrap();
    let gyro = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/gyro/sg11-s0.safetensors");
    std::fs::copy(gyro, &own).unwrap();
    let out = tmp.path().join("out");
    let ask = || {
        end(dpn().arg("noise").arg(&log).arg("--weights").arg(tmp.path().join("own")).arg("--out").arg(&out))
    };
    let done = ask();
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("there is no accel network `sg11-s0`; known are none"), "{}", done.stderr);
    // A hundred times the noise, by hand.
    let mut bytes = std::fs::read(&own).unwrap();
    let scale = b"output_scale\\\":0.";
    let at = bytes.windows(scale.len()).position(|part| part == scale).unwrap();
    bytes[at + scale.len()] = b'9';
    std::fs::write(&own, bytes).unwrap();
    let done = ask();
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("its checksum does not fit its numbers and description"), "{}", done.stderr);
    assert!(!out.exists());
}
