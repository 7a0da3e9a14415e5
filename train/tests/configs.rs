//! Every file of `configs/train` is read, and the default ones say what the program does without them.

use dpn_core::Sensor;
use dpn_train::config::{TrainConfig, load};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/train")
}

#[test]
fn every_file_is_a_configuration_of_its_sensor() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let config = load(&path, Sensor::Accel).unwrap();
        assert!(name.starts_with(config.sensor().name()), "{name}");
        count += 1;
    }
    assert!(count >= 8, "{count} files");
}

#[test]
fn the_default_files_are_the_defaults() {
    for sensor in Sensor::ALL {
        let file = load(&folder().join(format!("{sensor}.toml")), sensor).unwrap();
        assert_eq!(file.resolved(), TrainConfig::for_sensor(sensor).resolved());
    }
}
