//! `dpn simulate tracks`.

use crate::run::{Done, dpn, end, run};
use dpn_io::asl::Sequence;
use dpn_io::read_tracks;
use std::path::{Path, PathBuf};

fn tracks(source: &Path, out: &Path, more: &[&str]) -> Done {
    end(dpn().args(["simulate", "tracks"]).arg(source).arg("--out").arg(out).args(more))
}

/// A few seconds of V1_01 with camera stamps and ground truth.
fn excerpt() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/euroc/V1_01_easy")
}

/// A copy of `files` of the excerpt in `dir`.
fn copied(dir: &Path, files: &[&str]) -> PathBuf {
    let copy = dir.join("V1_01_copy");
    for file in files {
        let to = copy.join("mav0").join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(excerpt().join("mav0").join(file), to).unwrap();
    }
    copy
}

const IMU: &str = "imu0/data.csv";
const TRUTH: &str = "state_groundtruth_estimate0/data.csv";
const CAMERA: &str = "cam0/sensor.yaml";

#[test]
fn tracks_of_a_sequence_are_on_its_camera_frames_every_second_one() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("a/tracks.txt");
    let said = tracks(&excerpt(), &out, &["--json", "--seed", "3"]).well().json();
    assert_eq!(
        (&said["sequence"], &said["world"], &said["seed"]),
        (&"V1_01_easy".into(), &"room".into(), &3.into())
    );
    let frames = read_tracks(&out).unwrap();
    assert_eq!(said["frames"], frames.len());
    let sequence = Sequence::open(&excerpt()).unwrap();
    let stamps: Vec<_> = sequence.camera_frames().unwrap().iter().map(|frame| frame.t).collect();
    let truth = sequence.ground_truth().unwrap();
    let (first, last) = (truth.states()[0].t, truth.states()[truth.states().len() - 1].t);
    let covered: Vec<_> = stamps.iter().copied().filter(|t| (first..=last).contains(t)).collect();
    let expected: Vec<_> = covered.iter().copied().step_by(2).collect();
    assert!(expected.len() > 10);
    assert_eq!(frames.iter().map(|frame| frame.t).collect::<Vec<_>>(), expected);
    assert!(frames.iter().all(|frame| (120..=150).contains(&frame.tracks.len())));
}

#[test]
fn the_same_seed_writes_the_same_bytes_and_flags_go_over_the_file() {
    let tmp = tempfile::tempdir().unwrap();
    let config = tmp.path().join("tracks.toml");
    std::fs::write(&config, "max_tracks = 20\npixel_noise_px = 3.0\n").unwrap();
    let of = |name: &str, more: &[&str]| {
        let out = tmp.path().join(name);
        tracks(&excerpt(), &out, more).well();
        std::fs::read(out).unwrap()
    };
    let config = config.to_str().unwrap();
    let plain = of("a", &["--seed", "5"]);
    assert!(plain == of("b", &["--seed", "5"]), "two runs of seed 5 differ");
    assert!(plain != of("c", &["--seed", "6"]), "seed 6 made the tracks of seed 5");
    let filed = of("d", &["--seed", "5", "--config", config]);
    assert_eq!(filed, of("e", &["--seed", "5", "--set", "max_tracks=20", "--set", "pixel_noise_px=3"]));
    assert_eq!(
        of(
            "f",
            &["--seed", "5", "--config", config, "--set", "max_tracks=150", "--set", "pixel_noise_px=.5"]
        ),
        plain
    );
    for more in [
        "world=hall",
        "rate_hz=20",
        "drift_px=1",
        "outlier_share=0.1",
        "life_time_s=0.3",
        "ground_truth_delay_s=-0.004",
    ] {
        assert!(of("g", &["--seed", "5", "--set", more]) != plain, "{more:?} changes nothing");
    }
}

#[test]
fn a_flight_by_name_and_as_a_folder_have_the_same_frames() {
    let tmp = tempfile::tempdir().unwrap();
    let flights = tmp.path().join("flights");
    end(dpn().args(["simulate", "flight", "hover", "--out"]).arg(&flights)).well();
    let (named, filed) = (tmp.path().join("named.txt"), tmp.path().join("filed.txt"));
    let said = tracks(Path::new("hover"), &named, &["--json"]).well().json();
    assert_eq!(said["sequence"], "f09-hover");
    tracks(&flights.join("f09-hover"), &filed, &[]).well();
    let (named, filed) = (read_tracks(&named).unwrap(), read_tracks(&filed).unwrap());
    // The folder's truth ends a sample before the flight does.
    assert!(named.len() - filed.len() <= 1);
    // Written poses are the exact ones, smoothed: tracks agree to hundredths until a border case makes one end sooner.
    let early = named.iter().zip(&filed).take(50);
    for (a, b) in early {
        assert_eq!(a.t, b.t);
        for (a, b) in a.tracks.iter().zip(&b.tracks) {
            assert!(a.id == b.id && (a.px - b.px).norm() < 0.05, "{a:?} {b:?}");
        }
    }
}

#[test]
fn stamps_are_made_where_there_is_no_camera() {
    let tmp = tempfile::tempdir().unwrap();
    let copy = copied(tmp.path(), &[IMU, TRUTH]);
    let out = tmp.path().join("tracks.txt");
    tracks(&copy, &out, &["--set", "rate_hz=20"]).well();
    let frames = read_tracks(&out).unwrap();
    let truth = Sequence::open(&copy).unwrap().ground_truth().unwrap();
    assert_eq!(frames[0].t, truth.states()[0].t);
    assert!(frames.windows(2).all(|pair| pair[1].t.ns() - pair[0].t.ns() == 50_000_000));
}

#[test]
fn a_sequence_without_ground_truth_is_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let copy = copied(tmp.path(), &[IMU]);
    let out = tmp.path().join("tracks.txt");
    tracks(&copy, &out, &[]).refused(
        tmp.path(),
        "error: [DIR]/V1_01_copy: no ground truth: state_groundtruth_estimate0/data.csv and mocap0/data.csv are not there\n\n\
         hint: tracks are made along true poses; without them only real images can be tracked",
    );
    assert!(!out.exists());
}

#[test]
fn an_equidistant_camera_is_taken_and_a_lens_that_is_none_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let copy = copied(tmp.path(), &[IMU, TRUTH, CAMERA]);
    let yaml = copy.join("mav0").join(CAMERA);
    let fish_eye = std::fs::read_to_string(&yaml).unwrap().replace("radial-tangential", "equidistant");
    std::fs::write(&yaml, &fish_eye).unwrap();
    let out = tmp.path().join("tracks.txt");
    tracks(&copy, &out, &[]).well();
    std::fs::write(&yaml, fish_eye.replace("equidistant", "fov")).unwrap();
    let other = tmp.path().join("other.txt");
    tracks(&copy, &other, &[]).refused(
        tmp.path(),
        "error: [DIR]/V1_01_copy/mav0/cam0/sensor.yaml: `distortion_coefficients` make a lens that is fov with coefficients \
         [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-5]; it has 1 finite numbers, an angle between 0 and pi\n\n\
         hint: compare with an ASL sensor.yaml; without the file the caller's defaults hold",
    );
    assert!(!other.exists());
}

#[test]
fn what_is_neither_a_folder_nor_a_flight_is_named() {
    let done = run("simulate tracks hovr");
    assert_eq!(done.code, Some(2), "{done:?}");
    let begin = "error: there is no folder `hovr`, and no flight is called `hovr`; known are f01-hall-slow, ";
    assert!(done.stderr.starts_with(begin), "{done:?}");
    assert!(done.stderr.ends_with("or a flight of `dpn simulate flight --list`\n"), "{done:?}");
    let table = format!("{}/mav0/imu0/data.csv", excerpt().display());
    let done = run(&format!("run {table}"));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(
        done.stderr.starts_with(&format!("error: `{table}` holds no images, and no ground truth")),
        "{done:?}"
    );
}

#[test]
fn bad_options_are_named_with_their_bounds_all_at_once() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("tracks.txt");
    let sets = ["pixel_noise_px=-1", "life_time_s=0", "outlier_share=nan"].map(|set| ["--set", set]).concat();
    tracks(&excerpt(), &out, &sets).refused(
        tmp.path(),
        "error: pixel_noise_px=-1, life_time_s=0, outlier_share=nan: `pixel_noise_px` is -1, but must be 0 to 100; `outlier_share` is NaN, but must be 0 to 1; \
         `life_time_s` is 0, but must be above 0 and at most 1000000000",
    );
    let config = tmp.path().join("tracks.toml");
    std::fs::write(&config, "pixel_noise = 1.0\n").unwrap();
    let done = tracks(&excerpt(), &out, &["--config", config.to_str().unwrap()]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("tracks.toml:1: unknown field `pixel_noise`"), "{done:?}");
    assert!(done.stderr.ends_with("\n\nhint: did you mean `pixel_noise_px`?\n"), "{done:?}");
    let done = tracks(&excerpt(), &out, &["--set", "world=garden"]);
    let known = "expected one of `auto`, `room`, `hall`";
    assert!(done.code == Some(2) && done.stderr.contains(known), "{done:?}");
    assert!(!out.exists());
}

#[test]
fn camera_and_ground_truth_on_two_clocks_are_refused_with_both_spans() {
    let tmp = tempfile::tempdir().unwrap();
    let copy = copied(tmp.path(), &[IMU, TRUTH]);
    let camera = copy.join("mav0/cam0/data.csv");
    std::fs::create_dir_all(camera.parent().unwrap()).unwrap();
    std::fs::write(camera, "#timestamp [ns],filename\n0,a.png\n50000000,b.png\n").unwrap();
    let out = tmp.path().join("tracks.txt");
    tracks(&copy, &out, &[]).refused(
        tmp.path(),
        "error: none of the 2 camera frames, 0 to 50000000 ns, lies on the path, \
         1403715303262142976 to 1403715307212142848 ns: are both on one clock?",
    );
    assert!(!out.exists());
}
