//! Tests on real recordings: a few seconds in `tests/data`, and the full data sets where they are unpacked.

use super::asl::{Sequence, discover};
use super::{read_tum, tum};
use dpn_core::camera::Distortion;
use dpn_core::check::{CheckOptions, RecordingFault, check};
use dpn_core::imu::ImuRecording;
use dpn_core::time::SampleRate;
use dpn_testing::{pack, repository};
use std::path::{Path, PathBuf};

fn excerpts() -> PathBuf {
    repository().join("tests/data")
}

fn named(dir: &Path, name: &str) -> Sequence {
    let sequences = discover(dir).unwrap();
    let found = sequences.iter().find(|s| s.short_name() == name);
    found.unwrap_or_else(|| panic!("no {name}")).clone()
}

/// Largest distance of a value from an integer number of the ADIS16448's counts.
fn off_counts(recording: &ImuRecording) -> f64 {
    let gyro = 0.04 * std::f64::consts::PI / 180.0;
    let accel = 9.80665 / 1200.0;
    let off = |value: f64, unit: f64| (value / unit - (value / unit).round()).abs();
    let samples = recording.samples().iter();
    samples
        .flat_map(|s| s.gyro.map(|v| off(v, gyro)).into_iter().chain(s.accel.map(|v| off(v, accel))))
        .fold(0.0, f64::max)
}

#[test]
fn the_excerpts_are_found_two_levels_down() {
    let sequences = discover(&excerpts()).unwrap();
    let names: Vec<_> = sequences.iter().map(Sequence::short_name).collect();
    assert_eq!(names, ["MH_01_easy", "V1_01_easy", "room1"]);
}

#[test]
fn every_part_of_a_euroc_sequence_is_read() {
    let sequence = named(&excerpts(), "V1_01_easy");
    let imu = sequence.imu().unwrap();
    assert_eq!(imu.len(), 800);
    assert!(off_counts(&imu) < 1e-6);
    assert!((imu.rate().hz() - 200.0).abs() < 0.01);

    let config = sequence.imu_config().unwrap().unwrap();
    assert_eq!((config.rate, config.gyro_noise.get()), (SampleRate::HZ_200, 1.6968e-4));
    let camera = sequence.camera_config().unwrap().unwrap();
    assert_eq!((camera.resolution, camera.distortion), ([752, 480], Distortion::RadialTangential));

    let frames = sequence.camera_frames().unwrap();
    assert_eq!(frames.len(), 80);
    assert_eq!(frames[0].file, format!("{}.png", frames[0].t.ns()));

    let truth = sequence.ground_truth().unwrap();
    assert_eq!(truth.states().len(), 80);
    assert!(truth.has_velocity() && truth.has_biases());
}

/// The float parser against the standard library's, bit by bit.
#[test]
fn every_number_is_the_nearest_float() {
    let sequence = named(&excerpts(), "V1_01_easy");
    let text = std::fs::read_to_string(sequence.imu_path()).unwrap();
    let imu = sequence.imu().unwrap();
    for (line, sample) in text.lines().skip(1).zip(imu.samples()) {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields[0].parse(), Ok(sample.t.ns()));
        let values: Vec<f64> = fields[1..].iter().map(|f| f.parse().unwrap()).collect();
        assert_eq!(values, [sample.gyro, sample.accel].concat());
    }
}

/// In the air the mean specific force, turned into the world, is gravity plus the mean acceleration: this holds only if quaternion order,
/// frames and stamps are read right.
#[test]
fn turned_into_the_world_the_accelerometer_reads_the_change_of_velocity() {
    let sequence = named(&excerpts(), "V1_01_easy");
    let (imu, truth) = (sequence.imu().unwrap(), sequence.ground_truth().unwrap());
    let states = truth.states();
    let (first, last) = (&states[0], &states[states.len() - 1]);
    let mut sum = nalgebra::Vector3::zeros();
    let mut count = 0.0;
    for sample in imu.samples() {
        let next = states.partition_point(|s| s.t <= sample.t);
        if next == 0 || next == states.len() {
            continue;
        }
        let (a, b) = (&states[next - 1], &states[next]);
        let share = sample.t.seconds_since(a.t) / b.t.seconds_since(a.t);
        let rotation = a.world_from_body.rotation.slerp(&b.world_from_body.rotation, share);
        let bias = a.biases.unwrap().accel;
        sum += rotation * (nalgebra::Vector3::from(sample.accel) - bias);
        count += 1.0;
    }
    let gained = last.vel_in_world.unwrap() - first.vel_in_world.unwrap();
    let accel_in_world = gained / last.t.seconds_since(first.t);
    let gravity = accel_in_world - sum / count;
    assert!((gravity - nalgebra::Vector3::new(0.0, 0.0, -9.81)).norm() < 0.1, "{gravity}");
}

#[test]
fn a_tumvi_sequence_has_motion_capture_for_ground_truth() {
    let sequence = named(&excerpts(), "room1");
    assert!(sequence.ground_truth_path().unwrap().ends_with("mocap0/data.csv"));
    let rate = sequence.imu().unwrap().rate().hz();
    assert!((rate - 199.4).abs() < 0.2, "{rate}");
    let truth = sequence.ground_truth().unwrap();
    assert!(!truth.has_velocity() && !truth.has_biases());
    assert!(sequence.imu_config().unwrap().is_none());
}

const ROWS: [(&str, usize); 11] = [
    ("MH_01_easy", 36820),
    ("MH_02_easy", 29992),
    ("MH_03_medium", 27008),
    ("MH_04_difficult", 20320),
    ("MH_05_difficult", 22721),
    ("V1_01_easy", 29120),
    ("V1_02_medium", 17100),
    ("V1_03_difficult", 21500),
    ("V2_01_easy", 22800),
    ("V2_02_medium", 23490),
    ("V2_03_difficult", 23370),
];

#[test]
fn the_eleven_euroc_sequences_are_read_to_the_last_row_and_count() {
    let Some(euroc) = pack("euroc") else { return };
    let sequences = discover(&euroc).unwrap();
    let options = CheckOptions { expected_rate: Some(SampleRate::HZ_200), ..CheckOptions::default() };
    let read: Vec<_> = sequences
        .iter()
        .map(|sequence| {
            let imu = sequence.imu().unwrap();
            let name = sequence.name();
            assert!(off_counts(&imu) < 1e-6, "{name}: not in counts");
            let findings = check(&imu, &options);
            assert_eq!(findings.faults, [], "{name}");
            let steps = imu.samples().windows(2).map(|w| w[1].t.ns() - w[0].t.ns());
            assert!(steps.clone().min() >= Some(4_999_936) && steps.max() <= Some(5_000_192), "{name}");
            (name, imu.len())
        })
        .collect();
    assert_eq!(read, ROWS);
}

#[test]
fn ground_truth_and_frames_of_euroc_have_the_published_layout() {
    let Some(euroc) = pack("euroc") else { return };
    for sequence in discover(&euroc).unwrap() {
        let truth = sequence.ground_truth().unwrap();
        let eight = ["MH_01_easy", "MH_02_easy", "MH_03_medium"].contains(&sequence.name());
        assert_eq!((truth.has_velocity(), truth.has_biases()), (!eight, !eight), "{}", sequence.name());
        let frames = sequence.camera_frames().unwrap();
        // 414 times V2_03's camera left one frame out; the others never did.
        let steps = frames.windows(2).map(|w| w[1].t.seconds_since(w[0].t));
        let dropped = steps.filter(|s| *s > 0.06).count();
        let expected = if sequence.name() == "V2_03_difficult" { 414 } else { 0 };
        assert_eq!(dropped, expected, "{}", sequence.name());
        assert_eq!(sequence.camera_config().unwrap().unwrap().intrinsics[0], 458.654);
    }
}

#[test]
fn tumvi_rooms_are_read_with_their_rate_and_the_gaps_of_their_motion_capture() {
    let Some(tumvi) = pack("tumvi") else { return };
    let read: Vec<_> = discover(&tumvi)
        .unwrap()
        .iter()
        .map(|sequence| {
            let imu = sequence.imu().unwrap();
            let rate = imu.rate().hz();
            assert!((rate - 199.4).abs() < 0.2, "{rate}");
            let options =
                CheckOptions { expected_rate: SampleRate::from_hz(199.4), ..CheckOptions::default() };
            let faults = check(&imu, &options).faults;
            assert!(
                !faults
                    .iter()
                    .any(|f| matches!(f, RecordingFault::WrongRate { .. } | RecordingFault::Constant { .. }))
            );
            let truth = sequence.ground_truth().unwrap();
            let states = truth.states();
            let longest = states.windows(2).map(|w| w[1].t.ns() - w[0].t.ns()).max().unwrap();
            (sequence.short_name().to_owned(), imu.len(), states.len(), longest / 1_000_000)
        })
        .collect();
    let expected = [
        ("room1", 28122, 16541, 1058),
        ("room2", 28732, 15477, 2491),
        ("room3", 28124, 15200, 1991),
        ("room4", 22212, 13075, 483),
    ];
    assert_eq!(read, expected.map(|(name, imu, truth, gap)| (name.to_owned(), imu, truth, gap)));
}

#[test]
fn trajectories_of_a_peer_come_back_the_same_after_writing() {
    let Some(peers) = pack("peers") else { return };
    let path = peers.join("vins_mono/MH_01_easy.x1.tum");
    let poses = read_tum(&path).unwrap();
    assert_eq!(poses[0].t.ns(), 1_403_636_625_363_555_670);
    let dir = tempfile::tempdir().unwrap();
    let copy = dir.path().join("copy.tum");
    tum::write_tum(&copy, &poses).unwrap();
    assert_eq!(read_tum(&copy).unwrap(), poses);
}
