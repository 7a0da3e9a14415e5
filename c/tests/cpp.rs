//! The C++ examples, compiled by g++ and run: variances of both are the library's own.
#![allow(clippy::unwrap_used)]

use dpn_core::{ImuSample, NoiseModel, Sensor, Stamp};
use dpn_pronet::{DualProNet, Weights};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where this test lies, and the library beside it.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
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
    compiler.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-O1", "-o"]).arg(&program);
    compiler.arg(here().join("examples").join(source)).args(flags);
    let compiled = compiler.output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let mut child = Command::new(&program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Who refuses its arguments reads nothing.
    let _ = child.stdin.take().unwrap().write_all(rows(samples).as_bytes());
    child.wait_with_output().unwrap()
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
    let samples = samples();
    let libraries = libraries();
    let at = libraries.display();
    let flags = [
        format!("-I{}/include", here().display()),
        format!("-L{at}"),
        "-ldpn_c".into(),
        format!("-Wl,-rpath,{at}"),
    ];
    hold(&run("vins_weights.cpp", &flags, &[], &samples), &expected(&samples), 1e-8);
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
    hold(&run("vins_weights_onnx.cpp", &flags, &networks, &samples), &expected(&samples), 1e-4);

    let refused = |networks: &[PathBuf], words: &str| {
        let output = started("vins_weights_onnx.cpp", &flags, networks, &samples);
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
