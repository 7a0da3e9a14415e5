//! `dpn run`: one recording through the odometry, and what is said of bad input.

use crate::run::{Done, dpn, end, files};
use dpn_io::asl::Sequence;
use dpn_io::{read_tracks, read_tum, write_tracks};
use std::path::{Path, PathBuf};

fn excerpt() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/euroc/V1_01_easy")
}

fn odometry(source: &Path, out: &Path, more: &[&str]) -> Done {
    end(dpn().arg("run").arg(source).arg("--out").arg(out).args(more))
}

/// A copy of the excerpt in `dir` whose files are changed by `change`, which is handed each file's name and text.
fn changed(dir: &Path, change: impl Fn(&str, &str) -> Option<String>) -> PathBuf {
    let copy = dir.join("V1_01_copy");
    for (name, bytes) in files(&excerpt()) {
        let text = String::from_utf8(bytes).unwrap();
        if let Some(text) = change(&name, &text) {
            let to = copy.join(&name);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            std::fs::write(to, text).unwrap();
        }
    }
    copy
}

/// Tracks of the excerpt, in a file of `dir`.
fn tracks(dir: &Path) -> PathBuf {
    let path = dir.join("tracks.txt");
    end(dpn().args(["simulate", "tracks"]).arg(excerpt()).arg("--out").arg(&path)).well();
    path
}

#[test]
fn a_flight_leaves_a_trajectory_states_and_a_report_and_the_same_ones_twice() {
    let tmp = tempfile::tempdir().unwrap();
    let (first, again) = (tmp.path().join("a"), tmp.path().join("b"));
    let flight = |out: &Path, more: &[&str]| {
        odometry(Path::new("room-medium"), out, &[&["--from", "50", "--noise", "oracle"], more].concat())
    };
    let said = flight(&first, &["--json", "--set", "covariance=true"]).well().json();
    let row = &said["report"]["row"];
    assert_eq!((&row["sequence"], &row["noise"]), (&"f07-room-medium".into(), &"oracle".into()));
    assert_eq!(said["report"]["axes"]["verdict"]["verdict"], "consistent", "{said}");
    // It begins late, as was asked: nothing is wrong.
    assert_eq!(said["report"]["warnings"], serde_json::json!([]), "{said}");
    assert_eq!(said["camera_is_simulated"], true);
    let poses = read_tum(&first.join("trajectory.tum")).unwrap();
    assert_eq!(row["poses"], poses.len());
    let states = std::fs::read_to_string(first.join("states.csv")).unwrap();
    assert!(states.lines().nth(1).unwrap().starts_with("#anchor,"));
    let rows = states.lines().filter(|line| !line.starts_with("#anchor"));
    let widths: Vec<usize> = rows.map(|line| line.split(',').count()).collect();
    assert!(widths.iter().all(|w| *w == widths[0]) && widths.len() > poses.len(), "{widths:?}");
    assert!(!states.contains("NaN") && !states.contains("inf"));

    let done = flight(&again, &["--set", "covariance=true"]).well();
    assert!(!done.stderr.contains("covariances are"), "{}", done.stderr);
    let args = ["--from", "50", "--to", "54", "--noise", "self", "--set", "covariance=true"];
    let learned = odometry(Path::new("room-medium"), &tmp.path().join("c"), &args).well();
    assert!(!learned.stderr.contains("covariances are"), "{}", learned.stderr);
    let of_networks = ["--from", "50", "--to", "54", "--noise", "dualpronet"];
    let args = [&of_networks[..], &["--set", "covariance=true", "--set", "window.handover=reuse"]].concat();
    let twice = odometry(Path::new("room-medium"), &tmp.path().join("d"), &args).well();
    assert!(twice.stderr.contains("warning: covariances are some 2 times too small"), "{}", twice.stderr);
    let words = done.stdout;
    for word in ["initialised:", "poses:", "restarts:", "scale:", "time:", "ATE [m]:"] {
        assert!(words.contains(word), "no `{word}` in {words}");
    }
    let (first, again) = (files(&first), files(&again));
    assert_eq!(first.keys().collect::<Vec<_>>(), ["report.json", "states.csv", "trajectory.tum"]);
    for name in ["states.csv", "trajectory.tum"] {
        assert!(first[name] == again[name], "{name} differs between two runs");
    }
}

#[test]
fn a_recording_without_ground_truth_runs_on_given_tracks_and_has_no_error() {
    let tmp = tempfile::tempdir().unwrap();
    let tracks = tracks(tmp.path());
    let copy = changed(tmp.path(), |name, text| (!name.contains("groundtruth")).then(|| text.to_owned()));
    let out = tmp.path().join("out");
    let done = odometry(&copy, &out, &["--noise", "x4", "--tracks", tracks.to_str().unwrap()]).well();
    assert!(done.stdout.contains("ATE [m]:        none"), "{}", done.stdout);
    let refused = odometry(&copy, &out, &["--noise", "x4"]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("no ground truth, along which camera tracks"), "{}", refused.stderr);
}

#[test]
fn bad_input_is_named_and_never_a_panic() {
    let tmp = tempfile::tempdir().unwrap();
    let (out, good) = (tmp.path().join("out"), tracks(tmp.path()));
    let frames = read_tracks(&good).unwrap();
    let with = |name: &str, change: &dyn Fn(usize, &mut dpn_core::TrackFrame)| {
        let mut frames = frames.clone();
        frames.iter_mut().enumerate().for_each(|(i, frame)| change(i, frame));
        let path = tmp.path().join(name);
        write_tracks(&path, &frames).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let later = with("later.txt", &|_, f| f.t = f.t.plus_seconds(1000.0));
    let jumping = with("jumping.txt", &|i, f| {
        let ids: Vec<u64> = f.tracks.iter().map(|t| t.id).collect();
        let n = ids.len();
        f.tracks.iter_mut().enumerate().for_each(|(k, t)| t.id = ids[(k + 31 * i) % n]);
    });
    let noise = tmp.path().join("noise.csv");
    let header = "#timestamp [ns],accel_std_x,accel_std_y,accel_std_z,gyro_std_x,gyro_std_y,gyro_std_z";
    let start = Sequence::open(&excerpt()).unwrap().imu().unwrap().samples()[0].t.ns();
    std::fs::write(
        &noise,
        format!("{header}\n{start},.1,.1,.1,.01,.01,.01\n{},.1,.1,.1,.01,.01,.01\n", start + 5_000_000),
    )
    .unwrap();
    let noise = format!("file(\"{}\")", noise.display());
    let good = good.to_str().unwrap();
    for (more, words) in [
        (vec!["--tracks", &later], "fewer than 20 frames have samples; are both on one clock"),
        (vec!["--tracks", &jumping], "an id must stay with its point"),
        (vec!["--tracks", good, "--noise", &noise], "the noise track goes from"),
        (vec!["--tracks", good, "--noise", "oracle"], "known for simulated flights alone"),
        (vec!["--tracks", good, "--noise", "mean-of-train(x1)"], "training sequences"),
        (vec!["--tracks", "none.txt"], "does not exist"),
        (vec!["--tracks", good, "--from", "3"], "what is run, from 3 s, has fewer than 20"),
    ] {
        let done = odometry(&excerpt(), &out, &more);
        assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{more:?}: {done:?}");
        assert!(
            done.stderr.starts_with("error: ") && done.stderr.contains(words),
            "{more:?}: {}",
            done.stderr
        );
    }
    assert!(!out.exists(), "a refused run left files");
}

#[test]
fn gaps_and_early_frames_are_survived_and_said() {
    let tmp = tempfile::tempdir().unwrap();
    let tracks = tracks(tmp.path());
    let hole = |name: &str, text: &str| {
        let keep =
            |i: &usize| !name.starts_with("mav0/imu0/data") || *i < 1 || (120..400).contains(i) || *i > 480;
        Some(text.lines().enumerate().filter(|(i, _)| keep(i)).map(|(_, line)| format!("{line}\n")).collect())
    };
    let copy = changed(tmp.path(), hole);
    let done =
        odometry(&copy, &tmp.path().join("out"), &["--noise", "x4", "--tracks", tracks.to_str().unwrap()])
            .well();
    assert!(done.stderr.contains("lie before the first IMU sample"), "{}", done.stderr);
    assert!(done.stderr.contains("warning: IMU: 1 gap(s)"), "{}", done.stderr);
}

#[test]
fn a_spike_is_passed_over_and_named_and_the_camera_is_not_blamed() {
    let tmp = tempfile::tempdir().unwrap();
    let tracks = tracks(tmp.path());
    let spike = |name: &str, text: &str| {
        let line = |(i, line): (usize, &str)| {
            let fields: Vec<&str> = line.split(',').collect();
            match fields[..] {
                [t, _, ref rest @ ..] if name.starts_with("mav0/imu0/data") && i == 500 => {
                    format!("{t},1000,{}\n", rest.join(","))
                }
                _ => format!("{line}\n"),
            }
        };
        Some(text.lines().enumerate().map(line).collect())
    };
    let copy = changed(tmp.path(), spike);
    let run = |source: &Path, out: &str| {
        let done =
            odometry(source, &tmp.path().join(out), &["--noise", "x4", "--tracks", tracks.to_str().unwrap()]);
        let done = done.well();
        (read_tum(&tmp.path().join(out).join("trajectory.tum")).unwrap(), done.stderr)
    };
    let ((good, silent), (passed, said)) = (run(&excerpt(), "good"), run(&copy, "spike"));
    assert_eq!(silent, "");
    assert!(
        said.starts_with("warning: IMU: 1 sample(s) were passed over as spikes: an IMU sample at "),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
    let end = |poses: &[dpn_core::trajectory::StampedPose]| {
        poses.last().unwrap().world_from_body.translation.vector
    };
    assert!((end(&good) - end(&passed)).norm() < 0.05);
}

#[test]
fn swapped_axes_are_told_from_the_camera() {
    let tmp = tempfile::tempdir().unwrap();
    end(dpn().args(["simulate", "flight", "room-medium", "--out"]).arg(tmp.path())).well();
    let flight = tmp.path().join("f07-room-medium");
    let tracks = tmp.path().join("tracks.txt");
    end(dpn().args(["simulate", "tracks"]).arg(&flight).arg("--out").arg(&tracks)).well();
    let cam = flight.join("mav0/cam0");
    std::fs::create_dir_all(&cam).unwrap();
    std::fs::copy(excerpt().join("mav0/cam0/sensor.yaml"), cam.join("sensor.yaml")).unwrap();
    let imu = flight.join("mav0/imu0/data.csv");
    let swapped: String = std::fs::read_to_string(&imu)
        .unwrap()
        .lines()
        .map(|line| match line.split(',').collect::<Vec<_>>().as_slice() {
            [t, x, y, rest @ ..] if !t.starts_with('#') => format!("{t},{y},{x},{}\n", rest.join(",")),
            _ => format!("{line}\n"),
        })
        .collect();
    std::fs::write(&imu, swapped).unwrap();
    let more = ["--noise", "x4", "--from", "50", "--tracks", tracks.to_str().unwrap()];
    let done = odometry(&flight, &tmp.path().join("out"), &more).well();
    assert!(done.stderr.contains("camera and gyro turn in mirrored axes"), "{}", done.stderr);
}

#[test]
fn a_calibration_is_taken_and_said_and_one_without_extrinsics_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/calibrations");
    let file = |name: &str| golden.join(name).display().to_string();
    // The tracks that are made are those of the fish-eye that the file describes.
    let done =
        odometry(&excerpt(), &tmp.path().join("a"), &["--calib", &file("vins.yaml"), "--camera", "tracks"])
            .well();
    let said = "calibration: VINS: 512 x 512 px, equidistant lens (4 coefficients), focal lengths 191.0 and 191.0 px; \
                `extrinsicRotation` maps camera to IMU; camera's stamps +0.0013 s; IMU noise as vins in ";
    assert!(done.stderr.starts_with(said), "{}", done.stderr);
    let alone = file("kalibr/camchain.yaml");
    odometry(&excerpt(), &tmp.path().join("b"), &["--calib", &alone]).refused(
        &golden,
        "error: [DIR]/kalibr/camchain.yaml: no `cam0.T_cam_imu`\n\n\
         hint: a camchain.yaml of the cameras alone does not say how they sit on the IMU: take camchain-imucam.yaml, which \
         kalibr_calibrate_imu_camera writes",
    );
    assert!(!tmp.path().join("b").exists());
}

#[test]
fn a_run_is_judged_by_ape_and_rpe_which_flags_that_are_gone_name() {
    let tmp = tempfile::tempdir().unwrap();
    let (out, log) = (tmp.path().join("out"), tmp.path().join("run.mcap"));
    let more = ["--from", "50", "--to", "58", "--noise", "x4", "--set", "covariance=true", "--draw"];
    let album = tmp.path().join("album");
    let more = [&more[..], &[album.to_str().unwrap(), "--mcap", log.to_str().unwrap()]].concat();
    odometry(Path::new("room-medium"), &out, &more).well();
    // The log begins and ends as MCAP does.
    let bytes = std::fs::read(&log).unwrap();
    assert!(bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n"));
    let timeline = std::fs::read_to_string(album.join("timeline.svg")).unwrap();
    for words in ["yaw [deg]", "truth", "Bands: three deviations"] {
        assert!(timeline.contains(words), "{words}");
    }
    // A run held against itself from the log: the deviations beside it become bands.
    let truth = tmp.path().join("truth.tum");
    std::fs::copy(out.join("trajectory.tum"), &truth).unwrap();
    let plot = tmp.path().join("errors.svg");
    end(dpn().args(["ape"]).args([&truth, &out]).arg("--save_plot").arg(&plot)).well();
    assert!(std::fs::read_to_string(&plot).unwrap().contains("Bands: three deviations"));
    for (flag, instead) in [("--rpe", "dpn rpe"), ("--kitti", "dpn ape")] {
        let refused = odometry(Path::new("room-medium"), &out, &[flag]);
        assert!(refused.code == Some(2) && refused.stderr.contains(instead), "{refused:?}");
    }
}

/// Neither quick flight nor a ground truth that disagrees with the IMU is a jump; those that are there are found in `vio/tests/bias_jump.rs`.
#[test]
fn on_flights_as_they_are_no_bias_jumps() {
    let Some(euroc) = dpn_testing::pack("euroc") else { return };
    let tmp = tempfile::tempdir().unwrap();
    for (sequence, noise) in [("V1_02_medium", "x1"), ("V2_03_difficult", "self")] {
        let flags = ["--camera", "tracks", "--seed", "60", "--noise", noise, "--json"];
        let said = odometry(&euroc.join(sequence), &tmp.path().join("out"), &flags).well().json();
        assert_eq!(said["report"]["bias_jumps"], serde_json::json!([]), "{sequence} {noise}");
    }
}

/// A start in flight on given tracks: from its first motion to its pose \[s\], and its scale's error.
fn start(sequence: &str, from: &str, to: &str) -> Option<[f64; 2]> {
    let [euroc, tracks] = dpn_testing::packs(["euroc", "tracks"])?;
    let tmp = tempfile::tempdir().unwrap();
    let span =
        ["--from", from, "--to", to, "--noise", "self", "--json", "--tracks", tracks.to_str().unwrap()];
    let said = odometry(&euroc.join(sequence), &tmp.path().join("out"), &span).well().json();
    let row = &said["report"]["row"];
    Some(["init_in_motion_s", "scale_error"].map(|key| row[key].as_f64().expect("it starts")))
}

/// An adjustment of this start that begins at the linear alignment's scale ends with three and a half times the size.
#[test]
fn a_start_in_flight_with_two_answers_is_waited_through() {
    let Some([_, scale]) = start("MH_04_difficult", "44", "55") else { return };
    assert!(scale.abs() < 0.1, "{scale}");
}

/// The linear alignment has no scale for it in the first two seconds.
#[test]
fn a_start_whose_scale_the_linear_alignment_does_not_know_is_early() {
    let Some([seconds, scale]) = start("MH_03_medium", "26", "34") else { return };
    assert!(seconds < 1.6 && scale.abs() < 0.1, "{seconds} s, {scale}");
}

#[test]
fn a_noise_made_of_a_first_run_is_that_of_a_closed_loop() {
    let tmp = tempfile::tempdir().unwrap();
    let span = ["--from", "50", "--to", "58", "--noise", "mean(self)"];
    let run = tmp.path().join("run");
    odometry(Path::new("room-medium"), &run, &span).well();
    let cells = tmp.path().join("cells");
    let mut closed = dpn();
    closed
        .args(["eval", "--closed-loop", "--sequences", "room-medium", "--trajectories", "--out"])
        .arg(&cells);
    end(closed.args(span)).well();
    let cell = std::fs::read(cells.join("trajectories/f07-room-medium.mean_self.seed0.tum")).unwrap();
    assert!(!cell.is_empty() && std::fs::read(run.join("trajectory.tum")).unwrap() == cell);
}

#[test]
fn what_was_learned_is_in_the_report_the_states_the_noise_and_the_picture() {
    let tmp = tempfile::tempdir().unwrap();
    let (out, pictures) = (tmp.path().join("out"), tmp.path().join("pictures"));
    let draw = ["--to", "25", "--json", "--draw", pictures.to_str().unwrap()];
    let run = |noise: &str| {
        odometry(Path::new("room-medium"), &out, &[&["--noise", noise][..], &draw].concat()).well().json()
    };
    let told = run("x1");
    assert!(told["report"]["learned"].is_null() && !out.join("noise_learned.csv").exists());
    let header =
        |file: &str| std::fs::read_to_string(out.join(file)).unwrap().lines().next().unwrap().to_owned();
    assert!(!header("states.csv").contains("level"));

    let said = run("self");
    let learned = &said["report"]["learned"];
    for sensor in ["accel", "gyro"] {
        let axes = learned[sensor].as_array().unwrap();
        assert!(axes.len() == 3 && axes.iter().all(|level| level.as_f64().unwrap() > 0.0), "{learned}");
    }
    // What moves them is not what was told.
    assert!(
        learned["accel_walk"].as_f64().unwrap() > 1.0 && learned["pixel"].as_f64().unwrap() < 1.0,
        "{learned}"
    );
    assert!(header("states.csv").ends_with(",accel_walk_level,gyro_walk_level,pixel_level"));
    let noise = dpn_io::read_noise_track(&out.join("noise_learned.csv")).unwrap();
    let accel = |at: usize| noise.noises()[at].of(dpn_core::Sensor::Accel)[0];
    assert!(accel(0) != accel(noise.noises().len() - 1), "a noise that was learned is no constant");
    let drawn = std::fs::read_to_string(pictures.join("timeline.csv")).unwrap();
    assert!(drawn.contains("estimated, times what is given") && drawn.contains("pixels"));
}

/// From levels of a start's residuals, which hold what followed points are off too, a window may not come back.
#[test]
fn levels_begin_at_what_was_given_where_points_are_followed() {
    let Some(handheld) = dpn_testing::pack("handheld") else { return };
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    odometry(&handheld.join("bedroom"), &out, &["--to", "4", "--noise", "self"]).well();
    let noise = dpn_io::read_noise_track(&out.join("noise_learned.csv")).unwrap();
    let accel: Vec<f64> = noise.noises().iter().map(|n| n.of(dpn_core::Sensor::Accel)[0]).collect();
    let first = accel.iter().find(|first| **first != accel[0]).expect("they are learned") / accel[0];
    assert!((0.5..2.0).contains(&first), "{first}");
}

#[test]
fn noise_that_no_imu_has_is_refused_and_no_panic() {
    let tmp = tempfile::tempdir().unwrap();
    for noise in
        ["self(x1e-300)", "x1e300", "const(1e-200,1e-200)", "self(const(1e200,1e200))", "plus(x1,x1e160)"]
    {
        let done =
            odometry(Path::new("room-medium"), &tmp.path().join("out"), &["--to", "8", "--noise", noise]);
        assert_eq!(done.code, Some(2), "{noise}: {done:?}");
        assert!(done.stderr.contains("give deviations of an IMU"), "{noise}: {}", done.stderr);
    }
}
