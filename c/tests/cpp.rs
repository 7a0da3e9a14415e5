//! The C++ examples, compiled by g++ with its sanitizers and run: what they print is what the library and `dpn run` say.
#![allow(clippy::unwrap_used)]

use dpn_core::estimate::NoiseSpec;
use dpn_core::{ImuSample, NoiseModel, Sensor, Stamp};
use dpn_eval::closed_loop::{EstimatorOutput, RunInfo, RunSource, Span, Watchers, watched_run};
use dpn_pronet::{DualProNet, Weights};
use dpn_testing::packs;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::FedTracks;
use std::io::{Seek, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What reads or writes beyond what is there, leaks or is undefined ends the program.
const SANITIZED: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where this test lies, and the library beside it.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// Flags for this library and its headers.
fn linked() -> Vec<String> {
    let at = libraries().display().to_string();
    let headers = here().join("include").display().to_string();
    vec![
        format!("-I{headers}"),
        format!("-L{at}"),
        "-ldpn_c".into(),
        format!("-Wl,-rpath,{at}"),
        "-pthread".into(),
    ]
}

fn samples() -> Vec<ImuSample> {
    let shaken = |i: i64, prime: i64| ((i * prime) % 1000) as f64 / 1000.0 - 0.5;
    (0..1000)
        .map(|i| ImuSample {
            t: Stamp::from_ns(i * 5_000_000),
            gyro: [0.02 * shaken(i, 7919), 0.01 * shaken(i, 104_729), 0.03 * shaken(i, 1_299_709)],
            accel: [0.4 * shaken(i, 7907), 0.2 * shaken(i, 7883), 9.81 + 0.8 * shaken(i, 7879)],
        })
        .collect()
}

fn rows(samples: &[ImuSample]) -> String {
    let row = |s: &ImuSample| {
        let values: Vec<String> = s.gyro.iter().chain(&s.accel).map(|v| format!("{v:?}")).collect();
        format!("{},{}\n", s.t.ns(), values.join(","))
    };
    samples.iter().map(row).collect()
}

/// Variances at every 200th sample: stamp, accelerometer, gyroscope.
fn expected(samples: &[ImuSample]) -> Vec<Vec<f64>> {
    let load = |sensor: &str| {
        Weights::load(here().join("../models").join(sensor).join("sg11-s0.safetensors")).unwrap()
    };
    let mut networks = DualProNet::new("cpp", &load("accel"), &load("gyro"), 10).unwrap();
    let mut rows = Vec::new();
    for (i, sample) in samples.iter().enumerate() {
        let noise = networks.feed(sample);
        if (i + 1) % 200 == 0 {
            let variances =
                [Sensor::Accel, Sensor::Gyro].into_iter().flat_map(|s| noise.of(s)).map(|s| s * s);
            rows.push(std::iter::once(sample.t.ns() as f64).chain(variances).collect());
        }
    }
    rows
}

/// Compiles an example and feeds it the samples: what it ends with.
fn started(source: &str, flags: &[String], arguments: &[PathBuf], samples: &[ImuSample]) -> Output {
    let dir = tempfile::tempdir().unwrap();
    let program = dir.path().join("program");
    let mut compiler = Command::new("g++");
    compiler
        .args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-O1", "-g"])
        .args(SANITIZED)
        .args(["-o"])
        .arg(&program);
    compiler.arg(here().join(source)).args(flags);
    let compiled = compiler.output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    // A file and not a pipe: a program that says much before it reads would wait for its reader, and this writer for it.
    let mut fed = tempfile::tempfile().unwrap();
    fed.write_all(rows(samples).as_bytes()).unwrap();
    fed.rewind().unwrap();
    Command::new(&program).args(arguments).stdin(fed).output().unwrap()
}

/// The variances that an example prints.
fn run(source: &str, flags: &[String], arguments: &[PathBuf], samples: &[ImuSample]) -> Vec<Vec<f64>> {
    let output = started(source, flags, arguments, samples);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect()).collect()
}

fn hold(got: &[Vec<f64>], expected: &[Vec<f64>], tolerance: f64) {
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        assert_eq!(got.len(), 7);
        for (got, expected) in got.iter().zip(expected) {
            assert!((got - expected).abs() <= tolerance * expected.abs(), "{got}, expected {expected}");
        }
    }
}

#[test]
fn a_vins_estimators_weights_are_the_librarys() {
    let (samples, flags) = (samples(), linked());
    hold(&run("examples/vins_weights.cpp", &flags, &[], &samples), &expected(&samples), 1e-8);
}

/// With ONNX Runtime where it is: its headers in `$ORT/include`, its library in `$ORT/lib`, networks by `dpn export onnx` in `$DPN_ONNX`.
#[test]
#[ignore = "wants ONNX Runtime in $ORT and exported networks in $DPN_ONNX"]
fn onnx_runtime_says_the_same() {
    let (ort, onnx) = (std::env::var("ORT").unwrap(), PathBuf::from(std::env::var("DPN_ONNX").unwrap()));
    let samples = samples();
    let flags = [
        format!("-I{ort}/include"),
        format!("-L{ort}/lib"),
        "-lonnxruntime".into(),
        format!("-Wl,-rpath,{ort}/lib"),
    ];
    let networks = ["accel", "gyro"].map(|sensor| onnx.join(sensor).join("sg11-s0.onnx"));
    hold(&run("examples/vins_weights_onnx.cpp", &flags, &networks, &samples), &expected(&samples), 1e-4);

    let refused = |networks: &[PathBuf], words: &str| {
        let output = started("examples/vins_weights_onnx.cpp", &flags, networks, &samples);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && said.contains(words) && output.stdout.is_empty(),
            "{said}"
        );
    };
    let [accel, gyro] = networks;
    refused(&[gyro.clone(), accel.clone()], "sensor is 'gyro'; expected 'accel'");
    // The same network at another rate: a digit of its metadata.
    let mut bytes = std::fs::read(&gyro).unwrap();
    let key = b"rate_hz\x12\x03";
    let at = bytes.windows(key.len()).position(|part| part == key).unwrap() + key.len();
    bytes[at] = b'4';
    let dir = tempfile::tempdir().unwrap();
    let other = dir.path().join("other.onnx");
    std::fs::write(&other, bytes).unwrap();
    refused(&[accel, other], "rate_hz is '400'; expected '200'");
}

/// What `dpn run` makes of a source, or of a recording's tracks.
fn run_by_dpn(source: &Path, tracks: Option<&Path>, to_s: Option<f64>) -> EstimatorOutput {
    let config = EstimatorConfig {
        fed_tracks: if tracks.is_some() { FedTracks::Followed } else { FedTracks::White },
        ..EstimatorConfig::default()
    };
    let how = RunSource { tracks: tracks.map(Path::to_owned), ..RunSource::default() };
    let (set, place) = how.one(&source.display().to_string()).unwrap();
    let recording = set.recording(place, 0).unwrap();
    let span = Span { from_s: 0.0, to_s };
    let camera = set.camera_input(place, 0, &span).unwrap();
    let noise: NoiseSpec = "self".parse().unwrap();
    let info = RunInfo {
        camera: set.camera().into(),
        truth: set.truth(),
        noise: noise.clone(),
        seed: 0,
        from_s: 0.0,
        to_s,
        front_end: None,
    };
    let watchers = Watchers { images: &mut (), updates: &mut |_, _| ControlFlow::Continue(()) };
    watched_run(&config, &recording, camera, &noise, info, &[], watchers).unwrap().output
}

fn words(output: Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_euroc_folder_fed_from_cpp_has_the_bits_of_dpn_run() {
    let Some([motion]) = packs(["motion"]) else { return };
    let folder = motion.join("MH_01_easy_start");
    let printed = words(started("examples/euroc.cpp", &linked(), &[folder.join("mav0")], &[]));
    let expected = run_by_dpn(&folder, None, None).poses();
    assert!(expected.len() > 80, "{}", expected.len());
    let found: Vec<&str> = printed.lines().collect();
    assert_eq!(found.len(), expected.len());
    for (line, pose) in found.iter().zip(&expected) {
        let (stamp, numbers) = line.split_once(' ').unwrap();
        let numbers: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        let (p, q) = (pose.world_from_body.translation.vector, pose.world_from_body.rotation.coords);
        assert_eq!(stamp.parse::<i64>().unwrap(), pose.t.ns());
        assert_eq!(numbers, [p.x, p.y, p.z, q.x, q.y, q.z, q.w], "{}", pose.t);
    }
}

#[test]
fn the_noise_for_a_vins_estimator_is_what_dpn_run_learns_of_its_tracks() {
    let Some([euroc, tracks]) = packs(["euroc", "tracks"]) else { return };
    let folder = euroc.join("V1_01_easy");
    let dir = tempfile::tempdir().unwrap();
    // The first half minute.
    let all = std::fs::read_to_string(tracks.join("V1_01_easy.txt")).unwrap();
    let lines: Vec<&str> = all.lines().filter(|line| !line.starts_with('#')).take(300).collect();
    let seen = dir.path().join("V1_01_easy.txt");
    std::fs::write(&seen, lines.join("\n") + "\n").unwrap();
    let mav = folder.join("mav0");
    let arguments = [mav.join("cam0/sensor.yaml"), mav.join("imu0/data.csv"), seen.clone()];
    let printed = words(started("examples/vins_noise.cpp", &linked(), &arguments, &[]));
    let output = run_by_dpn(&folder, Some(&seen), None);
    let levels = output.updates.last().unwrap().levels.as_deref().unwrap();
    let [ax, ay, az, gx, gy, gz, ..] = levels.inertial.0;
    let expected = [0.08 * ax.max(ay).max(az), 0.004 * gx.max(gy).max(gz)];
    let found = ["acc_n: ", "gyr_n: "].map(|key| {
        let line = printed.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.split(' ').next().unwrap().parse::<f64>().unwrap()
    });
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found}, {expected}; {printed}");
    }
    let none = [arguments[0].clone(), dir.path().join("none.csv"), seen];
    let refused = started("examples/vins_noise.cpp", &linked(), &none, &[]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
}

#[test]
fn what_must_not_be_called_is_an_error_and_nothing_else() {
    let said = words(started("tests/misuse.cpp", &linked(), &[], &[]));
    assert_eq!(said, "all refused\n");
}
