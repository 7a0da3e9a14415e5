//! Bad arguments across the border: a code, words that name the argument, nothing else.
#![allow(clippy::unwrap_used)]

use dpn_c::*;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, ImuSample, Stamp};
use dpn_inertial::{Course, InertialConfig, Training};
use nalgebra::{Isometry3, Vector3};
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

fn words() -> String {
    // SAFETY: the library's own string, read at once.
    unsafe { CStr::from_ptr(dpn_last_error()) }.to_str().unwrap().to_owned()
}

fn shipped(sensor: u32) -> u64 {
    let mut weights = 0;
    // SAFETY: a place to write to.
    assert_eq!(unsafe { dpn_weights_shipped(sensor, &raw mut weights) }, Status::Ok, "{}", words());
    weights
}

fn stream() -> u64 {
    let (accel, gyro, mut stream) = (shipped(0), shipped(1), 0);
    // SAFETY: a place to write to.
    assert_eq!(unsafe { dpn_stream_new(accel, gyro, 10, &raw mut stream) }, Status::Ok, "{}", words());
    assert_eq!((dpn_weights_free(accel), dpn_weights_free(gyro)), (Status::Ok, Status::Ok));
    stream
}

fn feed(stream: u64, t_ns: i64, gyro: &[f64; 3], accel: &[f64; 3]) -> Status {
    // SAFETY: three doubles each.
    unsafe { dpn_stream_feed(stream, t_ns, gyro.as_ptr(), accel.as_ptr()) }
}

fn sigma(stream: u64) -> Sigma {
    let mut sigma = std::mem::MaybeUninit::uninit();
    // SAFETY: a place to write to, and written to where all is well.
    unsafe {
        assert_eq!(dpn_stream_sigma(stream, sigma.as_mut_ptr()), Status::Ok);
        sigma.assume_init()
    }
}

#[test]
fn null_pointers_are_named() {
    let mut weights = 0;
    // SAFETY: null is what is tested; all else may be read and written.
    unsafe {
        assert_eq!(dpn_weights_load(null(), &raw mut weights), Status::NullArgument);
        assert_eq!(words(), "`path` is null; expected a string that ends with a zero");
        assert_eq!(dpn_weights_load(c"a".as_ptr(), null_mut()), Status::NullArgument);
        assert_eq!(words(), "`weights` is null; expected where to write the result");
        assert_eq!(dpn_weights_from_bytes(null(), 3, &raw mut weights), Status::NullArgument);
        assert_eq!(dpn_stream_feed(stream(), 1, [0.0; 3].as_ptr(), null()), Status::NullArgument);
        assert_eq!(words(), "`accel` is null; expected three doubles: x, y, z");
        assert_eq!(dpn_stream_sigma(stream(), null_mut()), Status::NullArgument);
        assert_eq!(dpn_level_new(1.0, 1.0, null_mut()), Status::NullArgument);
    }
    assert_eq!(weights, 0, "nothing was written");
}

#[test]
fn a_second_free_and_another_kinds_handle_are_unknown() {
    let stream = stream();
    assert_eq!(dpn_weights_free(stream), Status::UnknownHandle, "a stream is no network");
    assert_eq!(dpn_stream_free(stream), Status::Ok);
    assert_eq!(words(), "");
    assert_eq!(dpn_stream_free(stream), Status::UnknownHandle);
    assert!(words().starts_with("`stream` is ") && words().contains("not freed yet"), "{}", words());
    assert_eq!(feed(stream, 1, &[0.0; 3], &[0.0; 3]), Status::UnknownHandle);
    assert_eq!(
        (dpn_level_free(0), dpn_level_feed(u64::MAX, 0, 1.0, 1.0)),
        (Status::UnknownHandle, Status::UnknownHandle)
    );
}

#[test]
fn what_is_no_network_is_refused_with_its_reason() {
    let mut weights = 0;
    let missing = CString::new("/no/such/file").unwrap();
    // SAFETY: strings and bytes that are there, a place to write to.
    unsafe {
        assert_eq!(dpn_weights_load(missing.as_ptr(), &raw mut weights), Status::BadWeights);
        assert!(words().starts_with("/no/such/file: cannot be read"), "{}", words());
        assert_eq!(dpn_weights_from_bytes(b"none".as_ptr(), 4, &raw mut weights), Status::BadWeights);
        assert!(words().contains("no whole safetensors file"), "{}", words());
        assert_eq!(
            dpn_weights_from_bytes(b"none".as_ptr(), usize::MAX, &raw mut weights),
            Status::BadArgument
        );
        assert_eq!(dpn_weights_shipped(7, &raw mut weights), Status::BadArgument);
        // Each as the other's, and never asked.
        let (accel, gyro, mut stream) = (shipped(0), shipped(1), 0);
        assert_eq!(dpn_stream_new(gyro, accel, 10, &raw mut stream), Status::BadArgument);
        assert!(words().contains("give the accel's weights there"), "{}", words());
        assert_eq!(dpn_stream_new(accel, gyro, 0, &raw mut stream), Status::BadArgument);
    }
}

#[test]
fn bad_samples_change_nothing() {
    let (sound, hurt) = (stream(), stream());
    for i in 0..450_i64 {
        let shaken = ((i * 7919) % 1000) as f64 / 1000.0 - 0.5;
        let (gyro, accel) = ([0.02 * shaken; 3], [0.4 * shaken, -0.2 * shaken, 9.81 + 0.4 * shaken]);
        let t = i * 5_000_000;
        assert_eq!(feed(sound, t, &gyro, &accel), Status::Ok);
        assert_eq!(feed(hurt, t, &gyro, &accel), Status::Ok);
        assert_eq!(feed(hurt, t, &gyro, &accel), Status::BadArgument);
        assert!(words().ends_with("stamps must increase"), "{}", words());
        assert_eq!(feed(hurt, t + 1, &[f64::NAN; 3], &accel), Status::BadArgument);
        assert_eq!(words(), "`gyro` is [NaN, NaN, NaN]; expected three finite numbers");
        assert_eq!(sigma(sound).known, u8::from(i >= 199), "{i}");
    }
    assert_eq!(sigma(sound), sigma(hurt));
    assert_eq!(sigma(sound).wrong_rate, 0);
    assert!(sigma(sound).accel.iter().all(|s| *s > 0.0));
}

#[test]
fn another_rate_and_windows_beyond_the_training_are_flagged() {
    let stream = stream();
    for i in 0..450_i64 {
        let shaken = ((i * 7919) % 1000) as f64 / 1000.0 - 0.5;
        feed(
            stream,
            i * 10_000_000,
            &[0.01 * shaken; 3],
            &[0.2 * shaken, 0.2 * shaken, 9.81 + 500.0 * shaken],
        );
    }
    let sigma = sigma(stream);
    assert_eq!((sigma.wrong_rate, sigma.accel_out_of_range), (1, 1), "{sigma:?}");
}

/// A network, after no step, of an IMU that swings about x and whose gyroscope reads .01 rad/s too much there.
fn swinging() -> dpn_inertial::Model {
    let samples = (0..900).map(|i| ImuSample {
        t: Stamp::from_ns(i * 5_000_000),
        gyro: [0.01 + 0.3 * (0.01 * i as f64).sin(), 0.0, 0.0],
        accel: [0.0, 0.0, 9.81],
    });
    let pose = |i: i64| {
        let angle = 0.15 * (1.0 - (0.1 * i as f64).cos());
        let world_from_body = Isometry3::rotation(Vector3::x() * angle);
        StampedPose { t: Stamp::from_ns(i * 50_000_000), world_from_body }
    };
    let poses: Vec<_> = (0..91).map(pose).collect();
    let recording = ImuRecording::new(samples.collect()).unwrap();
    let courses = [Course::new("swings", &recording, &poses).unwrap()];
    let config = InertialConfig {
        train: vec!["swings".into()],
        steps: 1,
        batch: 1,
        window: 32,
        spans: vec![32],
        ..Default::default()
    };
    Training::new(&config, &courses).unwrap().model()
}

#[test]
fn a_gyroscopes_bias_is_known_after_as_much_past_as_the_network_looks_at() {
    let (dir, mut bias) = (tempfile::tempdir().unwrap(), 0);
    let path = dir.path().join("network.safetensors");
    std::fs::write(&path, swinging().to_bytes().unwrap()).unwrap();
    let path = CString::new(path.to_str().unwrap()).unwrap();
    let other =
        CString::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/gyro/sg11-s0.safetensors")).unwrap();
    // SAFETY: strings that end with a zero, three doubles each, places to write to; null is what is tested.
    unsafe {
        assert_eq!(dpn_gyro_bias_load(null(), &raw mut bias), Status::NullArgument);
        assert_eq!(dpn_gyro_bias_load(path.as_ptr(), null_mut()), Status::NullArgument);
        assert_eq!(dpn_gyro_bias_load(other.as_ptr(), &raw mut bias), Status::BadWeights);
        assert!(words().contains("where dpn-inertial-network is needed"), "{}", words());
        assert_eq!(dpn_gyro_bias_feed(bias, 1, [0.0; 3].as_ptr(), [0.0; 3].as_ptr()), Status::UnknownHandle);
        assert_eq!(dpn_gyro_bias_load(path.as_ptr(), &raw mut bias), Status::Ok, "{}", words());
        for i in 0..600_i64 {
            let (gyro, accel) = ([0.01, 0.0, 0.0], [0.0, 0.0, 9.81]);
            assert_eq!(dpn_gyro_bias_feed(bias, i * 5_000_000, gyro.as_ptr(), accel.as_ptr()), Status::Ok);
            assert_eq!(dpn_gyro_bias_feed(bias, 0, gyro.as_ptr(), accel.as_ptr()), Status::BadArgument);
            let mut found = std::mem::MaybeUninit::<GyroCorrection>::uninit();
            assert_eq!(dpn_gyro_bias_correction(bias, found.as_mut_ptr()), Status::Ok);
            let found = found.assume_init();
            assert_eq!((found.known, found.wrong_rate), (u8::from(i >= 510), 0));
            let rate = found.matrix[0] * 0.01 + found.bias[0];
            assert!(rate.abs() < 1e-3, "{found:?}");
        }
    }
    assert_eq!(dpn_gyro_bias_free(bias), Status::Ok);
    assert_eq!(dpn_gyro_bias_free(bias), Status::UnknownHandle);
}

#[test]
fn a_level_finds_what_it_was_not_told() {
    let (mut level, mut factor) = (0, 0.0);
    // SAFETY: places to write to.
    unsafe {
        assert_eq!(dpn_level_new(-1.0, 2.0, &raw mut level), Status::BadArgument);
        assert_eq!(dpn_level_new(10.0, 2.0, &raw mut level), Status::Ok);
        for i in 0..400 {
            assert_eq!(dpn_level_factor(level, &raw mut factor), Status::Ok);
            // Noise twice as loud as told, 12 of 15 degrees of freedom left.
            assert_eq!(
                dpn_level_feed(level, i * 50_000_000, 12.0 * (2.0 / factor).powi(2), 12.0),
                Status::Ok
            );
        }
    }
    assert!((factor - 2.0).abs() < 0.02, "{factor}");
    assert_eq!(dpn_level_feed(level, 0, 1.0, 1.0), Status::BadArgument);
    assert!(words().ends_with("time must not go back"), "{}", words());
    assert_eq!(dpn_level_feed(level, i64::MAX, f64::NAN, 1.0), Status::BadArgument);
}

#[test]
fn many_threads_may_make_and_free() {
    let work = |_| {
        for _ in 0..20 {
            let one = stream();
            assert_eq!(feed(one, 1, &[0.0; 3], &[0.0; 3]), Status::Ok);
            assert_eq!(dpn_stream_free(one), Status::Ok);
        }
    };
    let threads: Vec<_> = (0..4).map(|k| std::thread::spawn(move || work(k))).collect();
    threads.into_iter().for_each(|thread| thread.join().unwrap());
}
