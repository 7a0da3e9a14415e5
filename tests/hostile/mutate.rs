//! Small real inputs, damaged.

use crate::judge::Case;
use crate::set::{excerpt, put};
use dpn_testing::forged::{Draw, damage};
use dpn_testing::repository;
use std::path::Path;
use std::sync::Arc;

const IMU: &str = "tests/data/euroc/V1_01_easy/mav0/imu0/data.csv";
const CAMERA: &str = "tests/data/euroc/V1_01_easy/mav0/cam0/sensor.yaml";
/// Logs of every kind, and as what they are read.
const LOGS: [(&str, &str); 9] = [
    (IMU, "log.csv"),
    ("tests/data/tumvi/dataset-room1_512_16/mav0/imu0/data.csv", "log.csv"),
    ("golden/bags/plain.bag", "log.bag"),
    ("golden/bags/lz4.bag", "log.bag"),
    ("golden/bags/bz2.bag", "log.bag"),
    ("golden/bags/plain.mcap", "log.mcap"),
    ("golden/bags/lz4.mcap", "log.mcap"),
    ("golden/bags/zstd.mcap", "log.mcap"),
    ("golden/bags/sqlite/sqlite.db3", "log.db3"),
];
/// Files of a sequence that a run reads.
const SEQUENCE: [&str; 5] = [
    "imu0/data.csv",
    "imu0/sensor.yaml",
    "cam0/data.csv",
    "cam0/sensor.yaml",
    "state_groundtruth_estimate0/data.csv",
];
/// Bags of images, and a calibration of their camera.
const RIGS: [(&str, &str); 2] =
    [("golden/rigs/encodings.bag", "rig.bag"), ("golden/rigs/encodings.mcap", "rig.mcap")];
const CALIBRATION: &[u8] = b"rate_hz: 10\nresolution: [64, 48]\nintrinsics: [60, 60, 32, 24]\nT_BS:\n  \
    data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
/// Other programs' noise figures.
const FIGURES: [&[u8]; 4] = [
    b"rostopic: /imu0\nupdate_rate: 200.0\naccelerometer_noise_density: 0.006\naccelerometer_random_walk: 0.0002\n\
      gyroscope_noise_density: 0.0004\ngyroscope_random_walk: 4.0e-06\n",
    b"imu_topic: \"/imu0\"\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 4.0e-5\ngyr_w: 2.0e-6\ng_norm: 9.81007\n",
    b"%YAML:1.0\n---\nIMU.NoiseGyro: 1.7e-4\nIMU.NoiseAcc: 2.0e-03\nIMU.GyroWalk: 1.9393e-05\nIMU.AccWalk: 3.e-03\nIMU.Frequency: 200.0\n",
    b"{\"value0\": {\"accel_noise_std\": [0.016, 0.016, 0.016], \"gyro_noise_std\": [0.00028, 0.00028, 0.00028], \
      \"accel_bias_std\": [0.001, 0.001, 0.001], \"gyro_bias_std\": [0.0001, 0.0001, 0.0001], \"imu_update_rate\": 200.0}}\n",
];

/// A file before it is damaged: its bytes, the name that it gets, and the folder that it belongs to.
type Whole = (Arc<Vec<u8>>, String, &'static str);

/// `files` damaged files for each of six commands.
pub(crate) fn all(files: usize) -> impl Iterator<Item = Case> + Send {
    let repository = |path: &str| Arc::new(std::fs::read(repository().join(path)).unwrap());
    let logs = LOGS.map(|(path, name)| (repository(path), name.to_owned(), ""));
    let rigs = RIGS.map(|(path, name)| (repository(path), name.to_owned(), "rig"));
    let parts = SEQUENCE.map(|part| {
        let path = Path::new(IMU).parent().unwrap().with_file_name(part);
        (repository(path.to_str().unwrap()), format!("seq/mav0/{part}"), "seq")
    });
    let mut figures = FIGURES.map(|text| (Arc::new(text.to_vec()), "config.yaml".to_owned(), "")).to_vec();
    figures.push((repository(CAMERA), "config.yaml".to_owned(), ""));
    let commands = [
        ("check LOG --out out", logs.to_vec()),
        ("noise LOG --noise diff2 --out out", logs.to_vec()),
        ("allan LOG --all --out out", logs.to_vec()),
        ("run seq --noise x4 --to 1.5 --out out", parts.to_vec()),
        ("run LOG --noise x4 --calib rig.yaml --image-topic /bgr8/image_raw --out out", rigs.to_vec()),
        ("noise convert --to kalibr config.yaml", figures),
    ];
    (0..files).flat_map(move |n| {
        let of = |(line, inputs): &(&'static str, Vec<Whole>)| {
            let line: &'static str = line;
            let (whole, name, folder) = inputs[n % inputs.len()].clone();
            let command = line.replace("LOG", &name);
            let prepare = move |dir: &Path| {
                match folder {
                    "seq" => excerpt(dir),
                    "rig" => put(&dir.join("rig.yaml"), CALIBRATION),
                    _ => {}
                }
                let mut bytes = whole.to_vec();
                damage(&mut bytes, &mut Draw::new(n as u64, line));
                put(&dir.join(&name), &bytes);
            };
            Case { name: format!("damage {n}"), prepare: Box::new(prepare), commands: vec![command] }
        };
        commands.iter().map(of).collect::<Vec<_>>()
    })
}
