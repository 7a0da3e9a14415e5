//! Real windows: some seconds of EuRoC and TUM-VI.

use dpn_core::Sensor;
use dpn_io::asl::Sequence;
use dpn_testing::repository;

/// Windows of `len` samples of every axis of `sensor`, one after another, from the committed seconds of real recordings.
pub(crate) fn real(sensor: Sensor, len: usize) -> Vec<f32> {
    let mut windows = Vec::new();
    for sequence in ["euroc/V1_01_easy", "tumvi/dataset-room1_512_16"] {
        let imu = Sequence::open(&repository().join("tests/data").join(sequence)).unwrap().imu().unwrap();
        for stretch in imu.samples().chunks_exact(len) {
            for axis in 0..3 {
                windows.extend(stretch.iter().map(|sample| match sensor {
                    Sensor::Accel => sample.accel[axis] as f32,
                    Sensor::Gyro => sample.gyro[axis] as f32,
                }));
            }
        }
    }
    assert!(windows.len() >= 12 * len, "{}", windows.len());
    windows
}
