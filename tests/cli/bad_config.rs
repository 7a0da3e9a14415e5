//! Configurations that are refused, before a byte of data is read.

use crate::recording::sound;
use crate::run::{dpn, end};
use crate::training::{TINY, config, tiny, with};
use std::path::Path;

/// Trains with `text` as configuration and checks the refusal's words; `[DIR]` stands for the folder.
#[track_caller]
fn refuses(sensor: &str, text: &str, expected: &str) {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let mut command = dpn();
    command.args(["train", "--sensor", sensor, "--config"]).arg(config(dir.path(), text));
    command.arg("--data").arg(dir.path().join("never-read")).arg("--out").arg(&out);
    end(&mut command).refused(dir.path(), expected);
    assert!(!out.exists());
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
    let dir = tempfile::tempdir().unwrap();
    let path = config(dir.path(), "seed = 3\n\n[fit]\nepochs = 2\nlerning_rate = 0.1\n");
    let done = end(dpn().args(["train", "--sensor", "accel", "--config"]).arg(&path));
    assert_eq!(done.code, Some(2), "{done:?}");
    let start = format!("error: {}:5: unknown field `lerning_rate`", path.display());
    assert!(done.stderr.starts_with(&start), "{done:?}");
    assert!(done.stderr.ends_with("\n\nhint: did you mean `learning_rate`?\n"), "{done:?}");
}

#[test]
fn all_bad_values_are_named_at_once_with_key_value_and_bound() {
    refuses(
        "accel",
        "[fit]\nlearning_rate = -1.0\n[augment]\ngrow = 0.5\n[network]\nleak = 3.0\n",
        "error: [DIR]/config.toml: `network.leak` is 3, but must be 0 to 1; \
         `augment.grow` is 0.5, but must be 1 to 100; \
         `fit.learning_rate` is -1, but must be above 0 and at most 1",
    );
}

#[test]
fn lists_of_another_length_than_the_channels_are_refused() {
    refuses(
        "accel",
        "[network]\nchannels = [4, 4]\nkernels = [5, 3]\nstrides = [1, 4, 2]\npaddings = [2, 1]\n",
        "error: [DIR]/config.toml: `network.strides` is [1, 4, 2], but must be one entry a block, 2 as in `channels`",
    );
}

#[test]
fn a_value_of_another_kind_is_named_with_its_line() {
    let dir = tempfile::tempdir().unwrap();
    let path = config(dir.path(), "seed = 1\n[fit]\nepochs = \"many\"\n");
    let done = end(dpn().args(["train", "--sensor", "accel", "--config"]).arg(&path));
    assert_eq!(done.code, Some(2), "{done:?}");
    let words = format!("error: {}:3: `epochs`: invalid type", path.display());
    assert!(done.stderr.starts_with(&words), "{done:?}");
}

#[test]
fn a_configuration_of_the_other_sensor_is_refused() {
    refuses(
        "gyro",
        &TINY.replace("[network]", "[network]\nsensor = \"accel\""),
        "error: [DIR]/config.toml is for the sensor `accel`\n\n\
         hint: say --sensor accel, or give a configuration for `gyro`",
    );
}

#[test]
fn a_configuration_that_is_not_there_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("none.toml");
    let done = end(dpn().args(["train", "--sensor", "accel", "--config"]).arg(&path));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with(&format!("error: cannot read {}: ", path.display())), "{done:?}");
    assert!(done.stderr.ends_with("\n\nhint: configs/ holds files to start from\n"), "{done:?}");
}

/// Trains on sound data with flags over the tiny configuration.
#[track_caller]
fn refuses_flags(flags: &[&str], expected: &str) {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let data: &Path = &sound(dir.path());
    end(&mut with(tiny(dir.path(), data, 1, &out), flags)).refused(dir.path(), expected);
    assert!(!out.exists());
}

#[test]
fn a_flag_is_held_to_the_same_bounds_as_its_key() {
    refuses_flags(
        &["--base", "sg(10,2)"],
        "error: `base` is sg(10,2), but must be an odd window above its order",
    );
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let done = end(&mut tiny(dir.path(), &sound(dir.path()), 0, &out));
    done.refused(dir.path(), "error: `fit.epochs` is 0, but must be at least 1");
    assert!(!out.exists());
}
