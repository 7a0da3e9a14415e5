//! `dpn simulate images`, and the odometry on what is rendered while it runs.

use crate::run::{Done, dpn, end, run};
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use std::path::{Path, PathBuf};

/// A few seconds of V1_01 with camera stamps and ground truth.
fn excerpt() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/euroc/V1_01_easy")
}

/// A camera of 94 x 60 px, so that a test renders in no time.
fn small_camera(dir: &Path) -> PathBuf {
    let path = dir.join("small.toml");
    let text = "[camera]\nresolution = [94, 60]\nintrinsics = [57.3, 57.2, 45.9, 31.0]\n";
    std::fs::write(&path, text).unwrap();
    path
}

fn images(source: &Path, out: &Path, more: &[&str]) -> Done {
    end(dpn().args(["simulate", "images"]).arg(source).arg("--out").arg(out).args(more))
}

#[test]
fn a_rendered_sequence_is_one_that_others_can_read() {
    let tmp = tempfile::tempdir().unwrap();
    let (out, small) = (tmp.path().join("a/V1_01"), small_camera(tmp.path()));
    let small = small.to_str().unwrap();
    let said = images(&excerpt(), &out, &["--json", "--seed", "3", "--config", small]).well().json();
    assert_eq!((&said["sequence"], &said["world"]), (&"V1_01_easy".into(), &"room".into()));
    let (sequence, original) = (Sequence::open(&out).unwrap(), Sequence::open(&excerpt()).unwrap());
    assert_eq!(sequence.imu().unwrap(), original.imu().unwrap());
    assert_eq!(sequence.ground_truth().unwrap(), original.ground_truth().unwrap());
    assert_eq!(sequence.imu_config().unwrap(), original.imu_config().unwrap());
    let config = sequence.camera_config().unwrap().unwrap();
    assert_eq!((config.resolution, config.intrinsics), ([94, 60], [57.3, 57.2, 45.9, 31.0]));
    let folder = ImageFolder::open(&sequence).unwrap();
    assert!(folder.coverage().is_complete() && said["images"] == folder.len());
    // Frames before the first true pose are left out; the others are the camera's.
    let truth = original.ground_truth().unwrap();
    let (first, last) = (truth.states()[0].t, truth.states()[truth.states().len() - 1].t);
    let stamps = original.camera_frames().unwrap().into_iter().map(|frame| frame.t);
    assert!(folder.stamps().eq(stamps.filter(|t| (first..=last).contains(t))));
    let image = folder.read(5).unwrap().image;
    let mean = image.pixels().iter().map(|g| f64::from(*g)).sum::<f64>() / image.pixels().len() as f64;
    assert!((90.0..170.0).contains(&mean), "{mean}");
}

#[test]
fn the_same_seed_renders_the_same_bytes_on_any_number_of_threads_and_a_part_is_a_part() {
    let tmp = tempfile::tempdir().unwrap();
    let small = small_camera(tmp.path());
    let of = |name: &str, more: &[&str]| {
        let out = tmp.path().join(name);
        let more = [&["--config", small.to_str().unwrap(), "--from", "2.5", "--to", "3"], more].concat();
        images(&excerpt(), &out, &more).well();
        let sequence = Sequence::open(&out).unwrap();
        let folder = ImageFolder::open(&sequence).unwrap();
        let files: Vec<_> =
            sequence.camera_frames().unwrap().iter().map(|f| sequence.image_path(f)).collect();
        assert!((10..=11).contains(&folder.len()), "{}", folder.len());
        let imu = sequence.imu().unwrap();
        assert!((1.4..1.6).contains(&imu.duration()), "{}", imu.duration());
        files.into_iter().map(|file| std::fs::read(file).unwrap()).collect::<Vec<_>>()
    };
    let plain = of("a", &["--seed", "5", "--threads", "1"]);
    assert!(plain == of("b", &["--seed", "5", "--threads", "3"]), "threads change images");
    for more in [
        &["--seed", "6"][..],
        &["--seed", "5", "--set", "world=hall"],
        &["--seed", "5", "--set", "motion_blur.exposure_s=0.05"],
        &["--seed", "5", "--set", "low_light.share=1"],
        &["--seed", "5", "--set", "ground_truth_delay_s=-0.05"],
    ] {
        assert!(of(&more.join("_"), more) != plain, "{more:?} changes nothing");
    }
}

#[test]
fn a_flight_is_rendered_along_its_exact_path() {
    let tmp = tempfile::tempdir().unwrap();
    let (out, small) = (tmp.path().join("hover"), small_camera(tmp.path()));
    let more = ["--json", "--config", small.to_str().unwrap(), "--from", "10", "--to", "10.2"];
    let said = images(Path::new("hover"), &out, &more).well().json();
    assert_eq!((&said["sequence"], &said["images"]), (&"f09-hover".into(), &5.into()));
    assert!(Sequence::open(&out).unwrap().ground_truth().is_ok());
}

#[test]
fn what_cannot_be_rendered_is_refused_and_nothing_is_written() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    images(&excerpt(), &out, &["--set", "motion_blur.exposure_s=1", "--set", "low_light.share=nan"]).refused(
        tmp.path(),
        "error: motion_blur.exposure_s=1, low_light.share=nan: `motion_blur.exposure_s` is 1, but must be 0 to 0.05; `low_light.share` is NaN, but must be 0 to 1",
    );
    images(&excerpt(), &out, &["--from", "1000"]).refused(
        tmp.path(),
        &format!(
            "error: V1_01_easy: at none of its {} frames asked for there is a true pose\n\n\
             hint: widen --from and --to, and see that camera and ground truth are on one clock",
            Sequence::open(&excerpt()).unwrap().camera_frames().unwrap().len()
        ),
    );
    let bare = tmp.path().join("bare");
    let imu = "mav0/imu0/data.csv";
    std::fs::create_dir_all(bare.join(imu).parent().unwrap()).unwrap();
    std::fs::copy(excerpt().join(imu), bare.join(imu)).unwrap();
    images(&bare, &out, &[]).refused(
        tmp.path(),
        "error: [DIR]/bare: no ground truth: state_groundtruth_estimate0/data.csv and mocap0/data.csv are not there\n\n\
         hint: images are made along true poses; without them only real images can be tracked",
    );
    assert!(!out.exists());
    std::fs::create_dir_all(out.join("mav0")).unwrap();
    images(&excerpt(), &out, &[]).refused(
        tmp.path(),
        "error: [DIR]/out is there already\n\n\
         hint: name another folder with --out, or remove this one: images of two runs are not mixed",
    );
    assert!(std::fs::read_dir(out.join("mav0")).unwrap().next().is_none());
    let done = run("simulate images hovr");
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(
        done.stderr.starts_with("error: there is no folder `hovr`, and no flight is called `hovr`"),
        "{done:?}"
    );
}

#[test]
fn a_recording_with_repeated_rows_as_phones_have_them_is_run_on() {
    let tmp = tempfile::tempdir().unwrap();
    let (small, phone) = (small_camera(tmp.path()), tmp.path().join("V1_01_easy"));
    images(&excerpt(), &phone, &["--config", small.to_str().unwrap()]).well();
    let table = Sequence::open(&phone).unwrap().imu_path();
    let (text, mut twice) = (std::fs::read_to_string(&table).unwrap(), 0);
    let mut repeated = String::new();
    for (i, row) in text.lines().enumerate() {
        let copies = 1 + usize::from(i > 0 && i % 50 == 0);
        twice += copies - 1;
        repeated += &format!("{row}\n").repeat(copies);
    }
    std::fs::write(&table, repeated).unwrap();
    // What others refuse, the odometry takes and says.
    assert!(Sequence::open(&phone).unwrap().imu().is_err());
    let mut command = dpn();
    command.arg("run").arg(&phone).args(["--camera", "images", "--noise", "x4", "--json", "--out"]);
    let report = end(command.arg(tmp.path().join("run"))).without_pose().json();
    let said = report["report"]["warnings"].to_string();
    assert!(
        said.contains(&format!("left out: {twice} sample(s) with the stamp of the one before")),
        "{said}"
    );
}

#[test]
fn the_odometry_runs_on_images_that_are_rendered_meanwhile_as_on_those_written_before() {
    let tmp = tempfile::tempdir().unwrap();
    let (small, written) = (small_camera(tmp.path()), tmp.path().join("V1_01_easy"));
    let small = small.to_str().unwrap();
    images(&excerpt(), &written, &["--config", small]).well();
    let of = |source: &Path, name: &str, more: &[&str]| {
        let out = tmp.path().join(name);
        let mut command = dpn();
        command.arg("run").arg(source).args(["--noise", "x4", "--json", "--out"]).arg(&out).args(more);
        let report = end(&mut command).without_pose().json();
        let row = &report["report"]["row"];
        (row["camera"].clone(), row["frames"].clone(), row["front_end"]["tracks"].clone())
    };
    let (camera, frames, tracks) = of(&excerpt(), "a", &["--camera", "rendered", "--images-config", small]);
    assert_eq!(camera, "rendered");
    let (camera, of_files, same) = of(&written, "b", &["--camera", "images"]);
    assert_eq!((camera, of_files, same), ("images".into(), frames, tracks));
    let mut command = dpn();
    command.arg("run").arg(excerpt()).args(["--camera", "rendered", "--tracks", "x.txt"]);
    end(&mut command).refused(
        tmp.path(),
        "error: `tracks` and `camera` images or rendered ask for two things\n\nhint: leave one of them away",
    );
}
