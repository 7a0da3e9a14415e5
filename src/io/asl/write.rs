//! Writes sequences in ASL's layout, as the readers here (and other programs) read them. Each file is there in full or not at all;
//! numbers carry as many digits as bring the same bits back.

use super::imu_config::ImuConfig;
use super::sequence::{GROUND_TRUTH, IMU_DATA, IMU_SENSOR, Sequence};
use crate::{IoError, ResultPath, atomic_write};
use dpn_core::Recorded;
use dpn_core::imu::ImuRecording;
use dpn_core::truth::GroundTruth;
use nalgebra::Isometry3;
use std::io::{self, Write};

const IMU_HEADER: &str = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
    a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
const POSE_HEADER: &str =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []";
const VELOCITY_HEADER: &str = ",v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1]";
const BIAS_HEADER: &str = ",b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],\
    b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]";

/// What a sequence on disk is made of.
#[derive(Debug, Clone, Copy)]
pub struct SequenceParts<'a> {
    /// The inertial samples.
    pub imu: &'a ImuRecording,
    /// The IMU's rate and noise.
    pub imu_config: Option<&'a ImuConfig>,
    /// The true states.
    pub ground_truth: Option<&'a GroundTruth>,
}

/// Writes `parts` below `dir/mav0` and opens the sequence. The IMU's samples come last: a folder without them is no sequence, so that
/// one cut short is not taken for a whole one.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_sequence(dir: impl Into<ResultPath>, parts: &SequenceParts<'_>) -> Result<Sequence, IoError> {
    let dir = dir.into();
    let root = dir.join("mav0");
    if let Some(config) = parts.imu_config {
        write_imu_config(root.join(IMU_SENSOR), config)?;
    }
    if let Some(truth) = parts.ground_truth {
        write_ground_truth(root.join(GROUND_TRUTH[0]), truth)?;
    }
    write_imu(root.join(IMU_DATA), parts.imu)?;
    Sequence::open(dir.path())
}

/// Writes an `imu0/data.csv`.
///
/// # Errors
/// As [`atomic_write`].
pub(crate) fn write_imu(path: impl Into<ResultPath>, recording: &ImuRecording) -> Result<(), IoError> {
    atomic_write(path, |out| write_imu_rows(out, recording))
}

/// Writes the rows of an `imu0/data.csv`, header first.
///
/// # Errors
/// What cannot be written, or read again from a temporary file.
pub fn write_imu_rows(out: &mut dyn Write, recording: &dyn Recorded) -> io::Result<()> {
    writeln!(out, "{IMU_HEADER}")?;
    let mut written = Ok(());
    recording.each(0..recording.len(), &mut |sample| {
        let ([gx, gy, gz], [ax, ay, az]) = (sample.gyro, sample.accel);
        if written.is_ok() {
            written = writeln!(out, "{},{gx:?},{gy:?},{gz:?},{ax:?},{ay:?},{az:?}", sample.t.ns());
        }
    })?;
    written
}

/// Writes an `imu0/sensor.yaml`.
///
/// # Errors
/// As [`atomic_write`].
pub(crate) fn write_imu_config(path: impl Into<ResultPath>, config: &ImuConfig) -> Result<(), IoError> {
    atomic_write(path, |out| {
        writeln!(out, "sensor_type: imu")?;
        matrix(out, &config.body_from_imu)?;
        writeln!(out, "rate_hz: {}", yaml_number(config.rate.hz()))?;
        for (key, value, unit) in [
            ("gyroscope_noise_density", config.gyro_noise.get(), "rad / s / sqrt(Hz)"),
            ("gyroscope_random_walk", config.gyro_walk.get(), "rad / s^2 / sqrt(Hz)"),
            ("accelerometer_noise_density", config.accel_noise.get(), "m / s^2 / sqrt(Hz)"),
            ("accelerometer_random_walk", config.accel_walk.get(), "m / s^3 / sqrt(Hz)"),
        ] {
            writeln!(out, "{key}: {} # [ {unit} ]", yaml_number(value))?;
        }
        Ok(())
    })
}

/// Writes a `state_groundtruth_estimate0/data.csv` of 8, 11 or 17 columns, as much as the states hold.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_ground_truth(path: impl Into<ResultPath>, truth: &GroundTruth) -> Result<(), IoError> {
    atomic_write(path, |out| {
        let velocity = if truth.has_velocity() { VELOCITY_HEADER } else { "" };
        let biases = if truth.has_biases() { BIAS_HEADER } else { "" };
        writeln!(out, "{POSE_HEADER}{velocity}{biases}")?;
        for state in truth.states() {
            let p = state.world_from_body.translation.vector;
            let q = state.world_from_body.rotation.coords;
            write!(out, "{}", state.t.ns())?;
            let pose = [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
            let velocity = state.vel_in_world.iter().flatten();
            let biases = state.biases.iter().flat_map(|b| b.gyro.iter().chain(&b.accel));
            for value in pose.iter().chain(velocity).chain(biases) {
                write!(out, ",{value:?}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Writes `T_BS`.
pub(super) fn matrix(out: &mut dyn Write, body_from_sensor: &Isometry3<f64>) -> io::Result<()> {
    let matrix = body_from_sensor.to_homogeneous();
    let row = |i: usize| {
        let row: Vec<_> = matrix.row(i).iter().map(|v| yaml_number(*v)).collect();
        row.join(", ")
    };
    writeln!(out, "T_BS:\n  cols: 4\n  rows: 4")?;
    writeln!(out, "  data: [{},", row(0))?;
    writeln!(out, "         {},", row(1))?;
    writeln!(out, "         {},", row(2))?;
    writeln!(out, "         {}]", row(3))
}

/// A float that YAML 1.1 readers (PyYAML) take for one too: with a point, and a sign in the exponent.
pub(super) fn yaml_number(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((digits, exponent)) => {
            let point = if digits.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{digits}{point}e{sign}{exponent}")
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::imu::ImuSample;
    use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
    use dpn_core::random::Stream;
    use dpn_core::time::{SampleRate, Stamp};
    use dpn_core::truth::{Biases, TrueState};
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
    use rand::Rng;

    fn vector(rng: &mut impl Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0) * 10f64.powi(rng.random_range(-9..3)))
    }

    fn truth(rng: &mut impl Rng, velocity: bool, biases: bool) -> GroundTruth {
        let states = (0..50).map(|i| TrueState {
            t: Stamp::from_ns(1_403_636_580_838_555_392 + i * 5_000_000),
            world_from_body: Isometry3::from_parts(
                Translation3::from(vector(rng)),
                UnitQuaternion::from_scaled_axis(vector(rng)),
            ),
            vel_in_world: velocity.then(|| vector(rng)),
            biases: biases.then(|| Biases { gyro: vector(rng), accel: vector(rng) }),
        });
        GroundTruth::new(states.collect()).unwrap()
    }

    #[test]
    fn a_written_sequence_is_read_back_bit_by_bit() {
        let mut rng = Stream::new(1).named("test").rng();
        let samples = (0..50).map(|i| ImuSample {
            t: Stamp::from_ns(1_403_636_580_838_555_392 + i * 5_000_000),
            gyro: vector(&mut rng).into(),
            accel: vector(&mut rng).into(),
        });
        let imu = ImuRecording::new(samples.collect()).unwrap();
        let config = ImuConfig {
            rate: SampleRate::from_hz(199.4).unwrap(),
            gyro_noise: GyroNoiseDensity::new(1e-5).unwrap(),
            gyro_walk: GyroBiasWalkDensity::new(1.9393e-5).unwrap(),
            accel_noise: AccelNoiseDensity::new(0.002).unwrap(),
            accel_walk: AccelBiasWalkDensity::new(1e17).unwrap(),
            body_from_imu: Isometry3::identity(),
        };
        let dir = tempfile::tempdir().unwrap();
        for (velocity, biases) in [(false, false), (true, false), (true, true)] {
            let truth = truth(&mut rng, velocity, biases);
            let parts = SequenceParts { imu: &imu, imu_config: Some(&config), ground_truth: Some(&truth) };
            let sequence = write_sequence(dir.path().join("flight_01"), &parts).unwrap();
            assert_eq!(sequence.name(), "flight_01");
            assert_eq!(sequence.imu().unwrap(), imu);
            assert_eq!(sequence.imu_config().unwrap().unwrap(), config);
            assert_eq!(sequence.ground_truth().unwrap(), truth);
            assert!(sequence.camera_config().unwrap().is_none());
        }
    }

    #[test]
    pub(super) fn yaml_numbers_suit_old_readers() {
        assert_eq!(yaml_number(1e-5), "1.0e-5");
        assert_eq!(yaml_number(1.5e17), "1.5e+17");
        assert_eq!(yaml_number(200.0), "200.0");
    }

    #[test]
    fn an_unwritable_place_is_an_error_and_leaves_no_sequence() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("mav0"), "in the way").unwrap();
        let at = |t| ImuSample { t: Stamp::from_ns(t), gyro: [0.0; 3], accel: [0.0; 3] };
        let imu = ImuRecording::new(vec![at(0), at(5)]).unwrap();
        let parts = SequenceParts { imu: &imu, imu_config: None, ground_truth: None };
        let error = write_sequence(dir.path(), &parts).unwrap_err();
        assert!(matches!(error, IoError::Write { .. }), "{error}");
        assert!(Sequence::open(dir.path()).is_err());
    }
}
