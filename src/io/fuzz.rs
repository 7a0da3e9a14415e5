//! Random and damaged bytes for every reader: whatever comes, it is a value or an error with a message, never a panic.

use super::asl::{camera, ground_truth, imu_config};
use super::imu_csv::parse_imu_csv;
use super::row_fault::RowFault;
use super::understood::CsvOptions;
use super::{
    AccelUnit, GyroUnit, ImuColumns, ImuLines, IoError, TimeUnit, calibration, noise_csv,
    parse_imu_csv_loosely, tracks, tum,
};
use dpn_core::random::{Stream, StreamRng};
use dpn_testing::forged::{Draw, damage};
use rand::Rng;
use std::path::Path;

const IMU: &[u8] = include_bytes!("../../tests/data/euroc/V1_01_easy/mav0/imu0/data.csv");
const IMU_YAML: &[u8] = include_bytes!("../../tests/data/euroc/V1_01_easy/mav0/imu0/sensor.yaml");
const CAM_YAML: &[u8] = include_bytes!("../../tests/data/euroc/V1_01_easy/mav0/cam0/sensor.yaml");
const FRAMES: &[u8] = include_bytes!("../../tests/data/euroc/V1_01_easy/mav0/cam0/data.csv");
const TRUTH: &[u8] =
    include_bytes!("../../tests/data/euroc/V1_01_easy/mav0/state_groundtruth_estimate0/data.csv");
const TUM: &[u8] = b"# t x y z qx qy qz qw\n1403636625.363555670 -0.08 -0.085 0.09 0.82185319 0.07738167 0.56290056 -0.04138068\n\
    1403636625.463555574 -0.076 -0.09 0.095 0.82441144 0.07739116 0.55914737 -0.04135955\n";
const NOISE: &[u8] =
    b"#timestamp [ns],accel_std_x [m s^-2],accel_std_y [m s^-2],accel_std_z [m s^-2],gyro_std_x [rad s^-1],\
    gyro_std_y [rad s^-1],gyro_std_z [rad s^-1]\n5,.1,.1,.1,.01,.01,.01\n10,.1,.2,.1,.01,.01,.02\n";
const TRACKS: &[u8] =
    b"1403715273262142976 3 0 643.97 225.50 1 57.02 192.62 2 175.68 114.94\n1403715273362142976 0\n\
    1403715273462142976 2 2 88.00 81.31 5 162.24 158.22\n";

/// Feeds every reader; an error must say something, in one line, and a hint must too.
fn feed(bytes: &[u8]) {
    let path = Path::new("fuzz");
    let columns = CsvOptions {
        columns: Some(ImuColumns::new(6, [0, 1, 2], [3, 4, 900]).into()),
        time: Some(TimeUnit::Seconds),
        gyro: Some(GyroUnit::DegPerSecond),
        accel: Some(AccelUnit::StandardGravity),
        rate: None,
    };
    let counted = CsvOptions { rate: dpn_core::SampleRate::from_hz(100.0), ..CsvOptions::default() };
    let errors = [
        parse_imu_csv(bytes, path, &CsvOptions::default()).err(),
        parse_imu_csv(bytes, path, &columns).err(),
        parse_imu_csv_loosely(bytes, path, &CsvOptions::default()).err(),
        parse_imu_csv_loosely(bytes, path, &columns).err(),
        parse_imu_csv_loosely(bytes, path, &counted).err(),
        super::asl::parse_imu(bytes, path).err(),
        camera::parse_frames(bytes, path).err(),
        camera::parse_config(bytes, path).err(),
        imu_config::parse(bytes, path).err(),
        ground_truth::parse(bytes, path).err(),
        tum::parse(bytes, path).err(),
        noise_csv::parse(bytes, path).err(),
        tracks::parse(bytes, path).err(),
    ];
    let mut lines = ImuLines::new(path, CsvOptions::default());
    let pushed = bytes.split_inclusive(|b| *b == b'\n').filter_map(|line| lines.push(line).err());
    for error in errors.into_iter().flatten().chain(pushed) {
        let said = error.to_string();
        assert!(said.starts_with("fuzz") && !said.contains('\n'), "{said:?}");
        assert_ne!(error.hint().as_deref(), Some(""));
    }
}

/// Feeds the reader of cameras, with the same demands.
fn feed_calibration(bytes: &[u8]) {
    let error = match calibration::parse(bytes, Path::new("fuzz")) {
        Ok(calibration) => {
            let numbers = format!("{:?}", calibration.camera);
            return assert!(!numbers.contains("NaN") && !numbers.contains("inf"), "{numbers}");
        }
        Err(error) => error,
    };
    let said = error.to_string();
    assert!(said.starts_with("fuzz") && !said.contains('\n'), "{said:?}");
    assert_ne!(error.hint().as_deref(), Some(""));
}

/// A stretch of lines of a real file, so that cases stay small.
fn excerpt(file: &[u8], rng: &mut StreamRng) -> Vec<u8> {
    let lines: Vec<_> = file.split_inclusive(|b| *b == b'\n').collect();
    if lines.len() < 20 {
        return file.to_vec();
    }
    let start = rng.random_range(1..lines.len() - 8);
    [&lines[..1], &lines[start..start + 8]].concat().concat()
}

#[test]
fn random_bytes_panic_no_reader() {
    const LETTERS: &[u8] = b"0123456789.,,;-+eE \t\r\n\n#%\"nai[]{}:&*!|>?x\xff\xc3";
    for case in 0..3000 {
        let mut rng = Stream::new(1).named("fuzz").named("random").index(case).rng();
        let length = rng.random_range(0..200);
        let bytes: Vec<u8> = if case % 3 == 0 {
            (0..length).map(|_| rng.random()).collect()
        } else {
            (0..length).map(|_| LETTERS[rng.random_range(0..LETTERS.len())]).collect()
        };
        feed(&bytes);
        feed_calibration(&bytes);
    }
}

#[test]
fn damaged_calibrations_panic_no_reader() {
    let files: [&[u8]; 9] = [
        include_bytes!("../../golden/calibrations/asl.yaml"),
        include_bytes!("../../golden/calibrations/basalt.json"),
        include_bytes!("../../golden/calibrations/kalibr/camchain-imucam.yaml"),
        include_bytes!("../../golden/calibrations/okvis2.yaml"),
        include_bytes!("../../golden/calibrations/openvins/kalibr_imucam_chain.yaml"),
        include_bytes!("../../golden/calibrations/orbslam3.yaml"),
        include_bytes!("../../golden/calibrations/orbslam3_old.yaml"),
        include_bytes!("../../golden/calibrations/vins.yaml"),
        include_bytes!("../../golden/calibrations/vins_fusion/cam0.yaml"),
    ];
    for case in 0..4500 {
        let mut bytes = files[case as usize % files.len()].to_vec();
        damage(&mut bytes, &mut Draw::new(case, "damaged calibrations"));
        feed_calibration(&bytes);
    }
}

#[test]
fn damaged_files_panic_no_reader() {
    let files = [IMU, IMU_YAML, CAM_YAML, FRAMES, TRUTH, TUM, NOISE, TRACKS];
    for case in 0..4000 {
        let mut rng = Stream::new(1).named("fuzz").named("damaged").index(case).rng();
        let mut bytes = excerpt(files[rng.random_range(0..files.len())], &mut rng);
        damage(&mut bytes, &mut Draw::new(case, "damaged files"));
        feed(&bytes);
    }
}

#[test]
fn a_row_cut_anywhere_but_in_its_last_field_is_an_error_with_its_line() {
    let lines: Vec<_> = IMU.split_inclusive(|b| *b == b'\n').take(4).collect();
    let whole = lines.concat();
    let (head, last) = (whole.len() - lines[3].len(), lines[3]);
    let last_field = last.iter().rposition(|b| *b == b',').unwrap();
    for cut in 1..=last_field {
        let error = super::asl::parse_imu(&whole[..head + cut], Path::new("f")).unwrap_err();
        assert!(
            matches!(error, IoError::Row { line: 4, fault: RowFault::FieldCount { .. }, .. }),
            "{cut}: {error}"
        );
    }
}
