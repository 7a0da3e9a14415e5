//! Every file of `configs/run` is read, and the default one says, key by key, what the program does without it.

use dpn_io::config::{load, parse};
use dpn_testing::written_out;
use dpn_vio::EstimatorConfig;
use dpn_vio::components::ComponentsConfig;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/run")
}

#[test]
fn every_file_is_a_configuration() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            load::<EstimatorConfig>(&path).unwrap_or_else(|error| panic!("{error}"));
            count += 1;
        }
    }
    assert!(count >= 1);
}

#[test]
fn the_default_file_is_the_default_and_leaves_no_key_out_and_none_without_a_comment() {
    let path = folder().join("vio.toml");
    assert_eq!(load::<EstimatorConfig>(&path).unwrap(), EstimatorConfig::default());
    written_out(&path, &EstimatorConfig::default());
}

#[test]
fn the_table_of_learning_stands_there_as_a_comment() {
    let path = folder().join("vio.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let table: Vec<&str> = text
        .lines()
        .skip_while(|line| !line.starts_with("# [components]"))
        .map_while(|line| line.strip_prefix("# "))
        .collect();
    let config: EstimatorConfig = parse(&table.join("\n"), &path).unwrap();
    assert_eq!(config.components, Some(ComponentsConfig::default()));
    let keys = serde_json::to_value(ComponentsConfig::default()).unwrap();
    assert_eq!(table.len() - 1, keys.as_object().unwrap().len(), "{keys}");
}
