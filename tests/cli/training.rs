//! Trainings small enough for tests.

use crate::run::{Done, dpn, end};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A network of a few hundred parameters.
pub(crate) const TINY: &str = include_str!("../data/tiny_network.toml");

/// Writes `text` as a configuration in `dir`.
pub(crate) fn config(dir: &Path, text: &str) -> PathBuf {
    let path = dir.join("config.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// `dpn train --sensor accel` with the tiny network on `data`, for `epochs`, into `out`.
pub(crate) fn tiny(dir: &Path, data: &Path, epochs: u64, out: &Path) -> Command {
    let mut command = dpn();
    command.args(["train", "--sensor", "accel", "--epochs", &epochs.to_string(), "--config"]);
    command.arg(config(dir, TINY)).arg("--data").arg(data).arg("--out").arg(out);
    command
}

/// A command with more words.
pub(crate) fn with(mut command: Command, words: &[&str]) -> Command {
    command.args(words);
    command
}

/// Bytes of the weights in a finished run.
#[track_caller]
pub(crate) fn weights(out: &Path) -> Vec<u8> {
    std::fs::read(out.join("accel.safetensors")).unwrap()
}

/// Trains on `text` as a log's IMU file and checks that it is refused in the words `expected`, with nothing left behind.
#[track_caller]
pub(crate) fn refuses_log(text: &str, expected: &str) {
    let dir = tempfile::tempdir().unwrap();
    let data = crate::recording::put(&dir.path().join("log"), "still", text);
    refuses(dir.path(), &data, expected);
}

/// Trains on `data` and checks that it is refused in the words `expected`, with nothing left behind.
#[track_caller]
pub(crate) fn refuses(dir: &Path, data: &Path, expected: &str) {
    let out = dir.join("out");
    let done: Done = end(&mut tiny(dir, data, 1, &out));
    done.refused(dir, expected);
    assert!(!out.exists(), "a refused training left {}", out.display());
}
