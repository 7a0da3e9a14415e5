//! Standard output that closes early, or is full: an end without a panic.

use crate::recording::sound;
use crate::run::dpn;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

/// Kalibr's file, with EuRoC's figures.
const IMU_YAML: &str = "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\ngyroscope_noise_density: 1.6968e-4\ngyroscope_random_walk: 1.9393e-5\nrostopic: /imu0\nupdate_rate: 200.0\n";

/// A command of every kind that says something, on the log in `dir`.
fn commands(dir: &Path) -> Vec<Command> {
    let log = sound(dir).join("still/mav0/imu0/data.csv");
    std::fs::write(dir.join("imu.yaml"), IMU_YAML).unwrap();
    let log = log.to_str().expect("temporary folders have plain names");
    let lines: [&[&str]; 6] = [
        &["simulate", "flight", "--list"],
        &["noise", log, "--noise", "diff2"],
        &["noise", log, "--noise", "diff2", "--json"],
        &["check", log],
        &["allan", log],
        &["noise", "convert", "imu.yaml", "--to", "vins"],
    ];
    let command = |line: &[&str]| {
        let mut command = dpn();
        command.current_dir(dir).args(line).stdin(Stdio::null());
        command
    };
    lines.iter().map(|line| command(line)).collect()
}

#[test]
#[cfg(unix)]
fn a_reader_that_leaves_ends_the_program_quietly() {
    let tmp = tempfile::tempdir().unwrap();
    for mut command in commands(tmp.path()) {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let usual = command.output().unwrap();
        let output = command.stdout(writer).output().unwrap();
        // What was going to be refused is refused all the same.
        let expected = if usual.stdout.is_empty() { usual.status.code() } else { Some(0) };
        assert_eq!(output.status.code(), expected, "{command:?}: {output:?}");
        assert_eq!(output.stderr, usual.stderr, "{command:?}: {output:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_output_is_an_error_and_behind_standard_error_none() {
    let tmp = tempfile::tempdir().unwrap();
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let mut told = 0;
    for mut command in commands(tmp.path()) {
        let usual = command.output().unwrap();
        let output = command.stderr(full()).output().unwrap();
        assert_eq!((output.status.code(), output.stdout), (usual.status.code(), usual.stdout.clone()));
        let output = command.stderr(Stdio::piped()).stdout(full()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        if !usual.stdout.is_empty() {
            assert_eq!(output.status.code(), Some(2), "{command:?}: {stderr}");
            assert!(
                stderr.ends_with("error: standard output: No space left on device (os error 28)\n"),
                "{stderr}"
            );
            told += 1;
        }
    }
    assert!(told >= 5, "{told} commands said something");
}
