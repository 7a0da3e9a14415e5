//! Bags and folders with images: the same trajectory from each, poses while a pipe is still open, and words where something is amiss.

use crate::bag::{begin, channels, image, message, record, sample_on, text};
use crate::run::{Done, dpn, end, files};
use dpn_core::ImuSample;
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::mpsc::channel;
use std::time::Duration;

pub(crate) const NOISE: [&str; 4] = ["--noise", "sg(11,2)", "--seed", "3"];

/// Messages of a sequence in the order in which they are recorded: images 3 ms late.
fn messages(dir: &Path) -> Vec<Vec<u8>> {
    messages_of(dir, |s| sample_on(1, s))
}

/// The same with samples as `sample` writes them.
fn messages_of(dir: &Path, sample: impl Fn(&ImuSample) -> Vec<u8>) -> Vec<Vec<u8>> {
    let sequence = Sequence::open(dir).unwrap();
    let images = ImageFolder::open(&sequence).unwrap();
    let mut all: Vec<(i64, Vec<u8>)> =
        sequence.imu().unwrap().samples().iter().map(|s| (s.t.ns(), sample(s))).collect();
    all.extend(
        (0..images.len())
            .map(|i| images.read(i).unwrap())
            .map(|i| (i.t.ns() + 3_000_000, image(i.t, &i.image))),
    );
    all.sort_by_key(|(t, _)| *t);
    all.into_iter().map(|(_, message)| message).collect()
}

fn odometry(source: &Path, out: &Path, more: &[&str]) -> Done {
    end(dpn().arg("run").arg(source).args(NOISE).arg("--out").arg(out).args(more))
}

/// Six seconds of a flight's small images, in a folder `live`: chance is a function of a recording's name.
pub(crate) fn rendered(tmp: &Path) -> PathBuf {
    let (dir, camera) = (tmp.join("live"), tmp.join("camera.toml"));
    let config = "[camera]\nresolution = [376, 240]\nintrinsics = [229.3, 228.6, 183.4, 123.9]\n";
    std::fs::write(&camera, config).unwrap();
    let mut command = dpn();
    command.args(["simulate", "images", "room-medium", "--from", "12", "--to", "18", "--config"]);
    end(command.arg(&camera).arg("--out").arg(&dir)).well();
    dir
}

#[test]
fn an_imu_on_two_topics_is_joined_and_wrong_units_are_named_from_a_file_and_from_a_pipe() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = rendered(tmp.path());
    let calibration = dir.join("mav0/cam0/sensor.yaml");
    let calib = ["--calib", calibration.to_str().unwrap()];
    let trajectory =
        |name: &str| std::fs::read_to_string(tmp.path().join(name).join("trajectory.tum")).unwrap();
    odometry(&dir, &tmp.path().join("of-folder"), &["--camera", "images"]).well();
    let expected = trajectory("of-folder");
    let piped = |bag: &Path, more: &[&str]| {
        let stdin = std::fs::File::open(bag).unwrap();
        end(dpn().args(["run", "-"]).args(calib).args(NOISE).args(more).stdin(stdin))
    };
    let bag = |folder: &str, begin: Vec<u8>, messages: Vec<Vec<u8>>| {
        let path = tmp.path().join(folder).join("live.mcap");
        std::fs::create_dir(path.parent().unwrap()).unwrap();
        std::fs::write(&path, [begin, messages.concat(), record(15, &[0; 4])].concat()).unwrap();
        path
    };

    // As a RealSense has it: the other sensor's values are zero.
    let [gyro, accel] = ["/camera/gyro/sample", "/camera/accel/sample"];
    let apart = bag(
        "apart",
        channels(&[
            (1, "sensor_msgs/Imu", gyro),
            (2, "sensor_msgs/Image", "/image"),
            (3, "sensor_msgs/Imu", accel),
        ]),
        messages_of(&dir, |s| {
            let (turn, force) = (ImuSample { accel: [0.0; 3], ..*s }, ImuSample { gyro: [0.0; 3], ..*s });
            [sample_on(1, &turn), sample_on(3, &force)].concat()
        }),
    );
    odometry(&apart, &tmp.path().join("of-apart"), &calib).well();
    assert!(trajectory("of-apart") == expected, "two topics give another trajectory");
    for topic in [&[][..], &["--topic", gyro], &["--topic", accel]] {
        let live = piped(&apart, topic).well();
        assert!(live.stdout == expected.split_once('\n').unwrap().1, "{topic:?}: {}", live.stderr);
    }

    let in_g = bag(
        "in-g",
        begin(),
        messages_of(&dir, |s| sample_on(1, &ImuSample { accel: s.accel.map(|v| v / 9.80665), ..*s })),
    );
    let out = tmp.path().join("of-g");
    let file = odometry(&in_g, &out, &calib);
    let live = piped(&in_g, &[]);
    for done in [&file, &live] {
        assert_eq!(done.code, Some(3), "{done:?}");
        assert!(done.stderr.ends_with("the run made no pose (exit code 3)\n"), "{}", done.stderr);
        for words in
            ["the accelerometer in g (a log's is mended by --accel-scale 9.80665)", "warning: no pose in "]
        {
            assert!(done.stderr.contains(words), "no `{words}` in {}", done.stderr);
        }
    }
    assert!(out.join("report.json").is_file(), "what was found out is kept");
    let scale = ["--accel-scale", "9.80665"];
    let live = piped(&in_g, &scale).well();
    let file = odometry(&in_g, &tmp.path().join("mended"), &[&calib[..], &scale].concat()).well();
    assert!(!file.stderr.contains("in g") && !live.stderr.contains("in g"));
    assert_eq!(live.stdout, trajectory("mended").split_once('\n').unwrap().1);
}

#[test]
fn a_bag_gives_its_folders_trajectory_and_a_pipe_its_first_pose_before_its_end() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = rendered(tmp.path());
    let trajectory = |name: &str| std::fs::read(tmp.path().join(name).join("trajectory.tum")).unwrap();
    odometry(&dir, &tmp.path().join("of-folder"), &["--camera", "images"]).well();
    let expected = trajectory("of-folder");

    let messages = messages(&dir);
    let calibration = dir.join("mav0/cam0/sensor.yaml");
    let calib = calibration.to_str().unwrap();
    let bag: PathBuf = tmp.path().join("live.mcap");
    std::fs::write(&bag, [begin(), messages.concat(), record(15, &[0; 4])].concat()).unwrap();
    let shown = tmp.path().join("shown.mcap");
    let flags = ["--calib", calib, "--json", "--mcap", shown.to_str().unwrap()];
    let done = odometry(&bag, &tmp.path().join("of-bag"), &flags).well();
    let shown = String::from_utf8_lossy(&std::fs::read(shown).unwrap()).into_owned();
    for (what, least) in
        [("/camera/image", 1), ("\"data\":\"iVBORw0KGgo", 8), ("\"outline_color\":{\"a\"", 8), ("/state", 1)]
    {
        assert!(shown.matches(what).count() >= least, "{what}: {}", shown.matches(what).count());
    }
    assert_eq!(done.json()["report"]["row"]["camera"], "images");
    assert!(trajectory("of-bag") == expected, "a bag's trajectory is another");

    let mut child = dpn()
        .args(["run", "-", "--calib", calib])
        .args(NOISE)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (stdin, stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    let mut stdin = stdin;
    let (sender, lines) = channel();
    let reader = std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines() {
            // The test has failed already.
            let _ = sender.send(line.unwrap());
        }
    });
    // All but the last second; the pipe stays open.
    let part = messages.len() * 5 / 6;
    stdin.write_all(&[begin(), messages[..part].concat()].concat()).unwrap();
    stdin.flush().unwrap();
    let first = lines.recv_timeout(Duration::from_secs(120)).expect("no pose while the pipe is open");
    stdin.write_all(&messages[part..].concat()).unwrap();
    drop(stdin);
    reader.join().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(child.wait().unwrap().success(), "{said}");
    let live: String = std::iter::once(first).chain(lines.iter()).map(|line| line + "\n").collect();
    let expected = String::from_utf8(expected).unwrap();
    assert_eq!(live, expected.split_once('\n').unwrap().1, "{said}");
    assert!(said.contains("note: initialised at ") && said.contains("was never closed"), "{said}");
    assert!(!said.contains("swapped"), "{said}");

    // The extrinsics the wrong way about are named while the pipe goes on.
    let given = Sequence::open(&dir).unwrap().camera_config().unwrap().unwrap().body_from_cam;
    let wrong = given.inverse().to_homogeneous();
    let yaml = std::fs::read_to_string(&calibration).unwrap();
    let (before, after) = yaml.split_once("data: [").unwrap();
    let (_, after) = after.split_once(']').unwrap();
    let other = tmp.path().join("swapped.yaml");
    let numbers: Vec<String> = wrong.transpose().iter().map(f64::to_string).collect();
    std::fs::write(&other, format!("{before}data: [{}]{after}", numbers.join(", "))).unwrap();
    let stdin = std::fs::File::open(&bag).unwrap();
    let said = end(dpn().args(["run", "-", "--calib"]).arg(&other).stdin(stdin)).well().stderr;
    assert_eq!(said.matches("warning: the camera's extrinsics are swapped").count(), 1, "{said}");
}

/// Kalibr's `camchain.yaml` of a sequence's camera: all of it, or the extrinsics alone.
fn camchain(sequence: &Sequence, with_lens: bool) -> String {
    let camera = sequence.camera_config().unwrap().unwrap();
    let matrix = camera.body_from_cam.inverse().to_homogeneous();
    let rows: String =
        matrix.row_iter().map(|r| format!("  - [{}, {}, {}, {}]\n", r[0], r[1], r[2], r[3])).collect();
    let lens = format!(
        "  camera_model: pinhole\n  intrinsics: {:?}\n  distortion_model: radtan\n  distortion_coeffs: {:?}\n  resolution: {:?}\n",
        camera.intrinsics, camera.coefficients, camera.resolution
    );
    format!("cam0:\n{}  T_cam_imu:\n{rows}", if with_lens { lens.as_str() } else { "" })
}

#[test]
fn folders_as_other_programs_have_them_run_with_the_calibration_that_lies_in_them() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = rendered(tmp.path());
    let sequence = Sequence::open(&dir).unwrap();
    let frames = sequence.camera_frames().unwrap();
    let put = |name: &str, text: &str| {
        let path = tmp.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let copy = |image: &Path, name: &str| {
        put(name, "");
        std::fs::copy(image, tmp.path().join(name)).unwrap();
    };
    let imu = sequence.imu().unwrap();
    let rows = |between: &str, sign: f64| -> String {
        let line = |s: &ImuSample| {
            let numbers = s.gyro.into_iter().chain(s.accel.map(|v| sign * v)).map(|v| v.to_string());
            [vec![s.t.ns().to_string()], numbers.collect()].concat().join(between) + "\n"
        };
        imu.samples().iter().map(line).collect()
    };
    let samples = |between: &str| rows(between, 1.0);
    // Kalibr's bagcreater, and DM-VIO with the extrinsics apart from the lens.
    put(
        "kalibr/imu0.csv",
        &format!("timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z\n{}", samples(",")),
    );
    put("kalibr/camchain.yaml", &camchain(&sequence, true));
    put("kalibr/imu.yaml", "accelerometer_noise_density: 0.01\n");
    put("dmvio/imu.txt", &samples(" "));
    put("dmvio/camchain.yaml", &camchain(&sequence, false));
    let camera = sequence.camera_config().unwrap().unwrap();
    let numbers: Vec<String> =
        camera.intrinsics.iter().chain(&camera.coefficients).map(f64::to_string).collect();
    let [width, height] = camera.resolution;
    put("dmvio/cam0/camera.txt", &format!("RadTan {}\n{width} {height}\ncrop\n640 480\n", numbers.join(" ")));
    let mut times = String::new();
    for (i, frame) in frames.iter().enumerate() {
        let image = sequence.image_path(frame);
        copy(&image, &format!("kalibr/cam0/{}.png", frame.t.ns()));
        copy(&image, &format!("dmvio/cam0/images/{i:05}.png"));
        times.push_str(&format!("{i:05} {}\n", frame.t.ns()));
    }
    put("dmvio/cam0/times.txt", &times);
    let run = |name: &str, more: &[&str]| {
        odometry(&tmp.path().join(name), &tmp.path().join("out"), &[&["--to", "2", "--json"], more].concat())
    };
    let runs = |done: &Done| done.json()["report"]["row"]["poses"].as_u64() > Some(5);
    for name in ["kalibr", "dmvio", "dmvio/cam0"] {
        let done = run(name, &[]).well();
        assert!(done.stderr.contains("calibration: found in ") && runs(&done), "{done:?}");
    }
    let other = camchain(&sequence, true).replace("pinhole\n  intrinsics: [", "pinhole\n  intrinsics: [1");
    // A calibration that is broken, and one given in its place.
    let broken = dir.join("mav0/cam0/sensor.yaml");
    copy(&broken, "given.yaml");
    std::fs::write(&broken, "T_cam0_body: !!opencv-matrix\n   rows: 4 cols: 4 dt: d\n").unwrap();
    assert!(run("live", &[]).stderr.contains("sensor.yaml:"));
    let given = tmp.path().join("given.yaml");
    let calib = ["--calib", given.to_str().unwrap()];
    assert!(runs(&run("live", &calib).well()));
    // Two that differ are asked about.
    put("kalibr/other.yaml", &other);
    let done = run("kalibr", &[]);
    assert!(done.code == Some(2) && done.stderr.contains("several calibrations of the camera: "), "{done:?}");
    // Units hold for a sequence too: an accelerometer as iPhones have it is turned round.
    put("live/mav0/imu0/data.csv", &rows(",", -1.0));
    assert!(runs(&run("live", &[&calib[..], &["--accel-scale", "-1"]].concat()).well()));
}

#[test]
fn what_is_amiss_is_said_with_a_remedy() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/rigs").join(name);
    let calib = tmp.path().join("sensor.yaml");
    let yaml = |size: &str| {
        format!(
            "rate_hz: 10\nresolution: [{size}]\nintrinsics: [60, 60, 32, 24]\nT_BS:\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
        )
    };
    std::fs::write(&calib, yaml("64, 48")).unwrap();
    let other = tmp.path().join("other.yaml");
    std::fs::write(&other, yaml("752, 480")).unwrap();
    let refused = |source: &Path, calib: Option<&Path>, more: &[&str], words: &[&str]| {
        let mut command = dpn();
        command.arg("run").arg(source).args(more).arg("--out").arg(tmp.path().join("out"));
        if let Some(calib) = calib {
            command.arg("--calib").arg(calib);
        }
        let done = end(&mut command);
        assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{done:?}");
        for words in words {
            assert!(done.stderr.contains(words), "no `{words}` in {}", done.stderr);
        }
        assert!(!tmp.path().join("out").exists());
    };
    let (bag, sqlite, calib) = (dir("encodings.mcap"), dir("sqlite"), Some(calib.as_path()));
    refused(&sqlite, None, &[], &["no calibration of its camera", "hint: name it with --calib"]);
    refused(
        &sqlite,
        calib,
        &[],
        &["2 topics of images: /bgr8/image_raw", "hint: say which one: --image-topic"],
    );
    refused(
        &bag,
        calib,
        &["--image-topic", "/cam"],
        &["no topic of images `/cam`; it has /mono8/image_raw, "],
    );
    let one = ["--image-topic", "/jpeg/image_raw/compressed"];
    refused(
        &bag,
        Some(&other),
        &one,
        &["image 1 on /jpeg/image_raw/compressed has 64 x 48 px; the camera's have 752 x 480"],
    );
    refused(&bag, calib, &["--camera", "rendered"], &["is a log with images"]);
    refused(&bag, calib, &["--truth", "nothing.txt"], &["nothing.txt"]);
    refused(
        &dir("../bags/plain.bag"),
        calib,
        &[],
        &["no images on any topic", "hint: record the camera's topic too"],
    );
    refused(Path::new("-"), calib, &[], &["--out is for recordings"]);
    // What is read as it comes has no other use of these flags either.
    for flag in [
        &["--from", "3"][..],
        &["--to", "3"],
        &["--skip-missing"],
        &["--columns", "1,2,3,4,5,6,7"],
        &["--time-unit", "ns"],
        &["--rate", "200"],
        &["--tracks-config", "t.toml"],
        &["--images-config", "i.toml"],
        &["--no-vibration"],
        &["--paste", "all"],
        &["--walks"],
    ] {
        let words = format!("{} is for recordings; `-` is read as it comes", flag[0]);
        refused(Path::new("-"), calib, flag, &[&words]);
    }
    // Images without an IMU; a list of another length; a step below a row; an encoding that nobody knows.
    let folder = tmp.path().join("folder");
    for (name, bytes) in files(&dir("folder_jpeg")) {
        let to = folder.join(&name);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::write(to, bytes).unwrap();
    }
    refused(&folder, calib, &[], &["its frames last 0.1 s", "record for longer"]);
    std::fs::remove_file(folder.join("images/1.jpg")).unwrap();
    refused(
        &folder,
        calib,
        &[],
        &["times.txt lists 2 images, and images/ beside it holds 1", "--skip-missing"],
    );
    std::fs::remove_file(folder.join("imu.txt")).unwrap();
    refused(
        &folder,
        calib,
        &["--skip-missing"],
        &["images, and no IMU", "hint: put the IMU's samples beside times.txt"],
    );
    let seen = |encoding: &str, step: u32| {
        let size = [48u32, 64].map(u32::to_le_bytes).concat();
        let pixels = text(&"x".repeat(64 * 48));
        let image = [&size[..], &text(encoding), &[0], &step.to_le_bytes(), &pixels].concat();
        let path = tmp.path().join(format!("{encoding}.mcap"));
        let samples: Vec<u8> = (0..40)
            .flat_map(|i| {
                sample_on(
                    1,
                    &ImuSample {
                        t: dpn_core::Stamp::from_ns(5_000_000 * i + 1),
                        gyro: [0.1; 3],
                        accel: [9.8; 3],
                    },
                )
            })
            .collect();
        std::fs::write(
            &path,
            [begin(), samples, message(2, 100_000_000, &image), record(15, &[0; 4])].concat(),
        )
        .unwrap();
        path
    };
    refused(
        &seen("32FC1", 256),
        calib,
        &[],
        &["image 1 on /cam0/image_raw is encoded as `32FC1`; known are mono8, mono16"],
    );
    refused(
        &seen("mono8", 60),
        calib,
        &[],
        &["has rows of 64 px, which are 64 bytes, but a step of 60 bytes"],
    );
    refused(&seen("rgb8", 192), calib, &[], &["is cut off: 3072 bytes hold no 64 x 48 px"]);
}
