//! An ASL folder: its files are the input's parts between bytes of 0xff, which no text has.
#![no_main]

use dpn_io::ImageFolder;
use dpn_io::asl::{Sequence, discover};
use libfuzzer_sys::fuzz_target;
use std::path::{Component, Path};

const FILES: [&str; 5] = [
    "imu0/data.csv",
    "imu0/sensor.yaml",
    "cam0/data.csv",
    "cam0/sensor.yaml",
    "state_groundtruth_estimate0/data.csv",
];

fuzz_target!(|bytes: &[u8]| {
    let Ok(dir) = tempfile::tempdir() else { return };
    for (name, part) in FILES.into_iter().zip(bytes.split(|b| *b == 0xff)) {
        let path = dir.path().join(name);
        let folder = path.parent().expect("every file is in a folder");
        if std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, part)).is_err() {
            return;
        }
    }
    let _ = discover(dir.path());
    let Ok(sequence) = Sequence::open(dir.path()) else { return };
    let _ = (sequence.imu(), sequence.imu_config(), sequence.camera_config(), sequence.ground_truth());
    for frame in sequence.camera_frames().unwrap_or_default() {
        let inside = Path::new(&frame.file).components().all(|part| matches!(part, Component::Normal(_)));
        assert!(inside, "{:?} leads out of the folder", frame.file);
    }
    if let Ok(images) = ImageFolder::open(&sequence) {
        let _ = images.coverage().to_string();
    }
});
