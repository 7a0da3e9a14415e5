//! XRSLAM's configuration of a device: matrices `cov_a`, `cov_g`, `cov_ba`, `cov_bg` below `imu.noise`, squares of densities. Kalibr's keys above them are read by nobody
//! there, and say something else.

use super::calibration::{Given, NoiseCalibration};
use super::error::FormatError;
use super::format::Format;
use super::key_fault::KeyFault;
use super::keyed;
use super::step::{Remark, Step};
use super::tree::Tree;
use dpn_core::noise::{Axes, Figure, Meaning};
use dpn_core::time::SampleRate;
use std::path::Path;

const KEYS: [(&str, Figure, Meaning); 4] = [
    ("cov_a", Figure::AccelWhite, Meaning::Density),
    ("cov_ba", Figure::AccelWalk, Meaning::WalkDensity),
    ("cov_g", Figure::GyroWhite, Meaning::Density),
    ("cov_bg", Figure::GyroWalk, Meaning::WalkDensity),
];

/// Reads them; none where the file has no such matrices.
///
/// # Errors
/// Numbers that no noise has.
pub(super) fn read(tree: &Tree, path: &Path, given: &Given) -> Result<Option<NoiseCalibration>, FormatError> {
    let blocks = tree.blocks();
    let block = blocks.iter().find(|block| block.path == "imu.noise");
    let Some(entries) =
        block.and_then(|block| KEYS.map(|(key, ..)| block.get(key)).into_iter().collect::<Option<Vec<_>>>())
    else {
        return Ok(None);
    };
    let mut source = NoiseCalibration::new(Format::Kalibr);
    source.figures.rate = given.rate;
    // Densities ask for none.
    let rate = given.rate.or_else(|| SampleRate::from_hz(1.0)).expect("one is a rate");
    for (entry, (key, figure, meaning)) in entries.into_iter().zip(KEYS) {
        let squares = keyed::axes(entry, path, false, &mut source.remarks)?.expect("a zero was refused");
        let bad = |bad: dpn_core::noise::units::BadNoise| {
            FormatError::key(path, entry.line, key, KeyFault::NotPositive { value: bad.0 })
        };
        let values = match squares {
            Axes::Same(square) => Axes::Same(square.sqrt()),
            Axes::Each(squares) => Axes::Each(squares.map(f64::sqrt)),
        };
        source.figures.set(figure, meaning, values, rate).map_err(bad)?;
        source.steps.push(Step::to_density(
            &format!("sqrt({key})"),
            figure,
            meaning,
            values,
            &source.figures,
            rate,
        ));
    }
    source.remarks.push(Remark(
        "XRSLAM reads the matrices below `imu.noise`, whose roots are densities, and passes over the keys above them".to_owned(),
    ));
    Ok(Some(source))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A device's, with what decorates it.
    pub(crate) const DEVICE: &str = "%YAML:1.0
imu:
  gyroscope_noise_density: 4.e-8
  accelerometer_noise_density: 4.e-6
  extrinsic:
    q_bi: [ 0.0, 0.0, 0.0, 1.0 ]
    p_bi: [ 0.0, 0.0, 0.5 ]
  noise:
    cov_g: [
      4.0e-8, 0.0, 0.0,
      0.0, 4.0e-8, 0.0,
      0.0, 0.0, 9.0e-8]
    cov_a: [4.0e-6, 0, 0, 0, 4.0e-6, 0, 0, 0, 4.0e-6]
    cov_bg: [4.0e-10, 0, 0, 0, 4.0e-10, 0, 0, 0, 4.0e-10]
    cov_ba: [9.0e-6, 0, 0, 0, 9.0e-6, 0, 0, 0, 9.0e-6]
cam0:
  resolution: [640, 480]
  camera_model: pinhole
  distortion_model: radtan
  intrinsics: [524.7, 524.6, 322.5, 235.2]
  camera_distortion_flag: 1
  distortion: [0.1, -0.2, 0.001, 0.002]
  time_offset: 0.01
  extrinsic:
    q_bc: [0.0, 0.0, 0.7071067811865476, 0.7071067811865476]
    p_bc: [0.02, 0.07, 0.5]
  noise: [0.5, 0.0, 0.0, 0.5]
";

    #[test]
    fn the_matrices_count_and_not_what_stands_above_them() {
        let path = Path::new("device.yaml");
        let read = super::super::parse(DEVICE.as_bytes(), path, None, &Given::default()).unwrap();
        let gyro = read.figures.density(Figure::GyroWhite).unwrap();
        assert!(
            matches!(gyro, Axes::Each([x, _, z]) if (x - 2e-4).abs() < 1e-12 && (z - 3e-4).abs() < 1e-12),
            "{gyro:?}"
        );
        let walk = read.figures.density(Figure::AccelWalk).unwrap();
        assert!((walk.largest() - 3e-3).abs() < 1e-12, "{walk:?}");
        assert!(read.remarks.iter().any(|remark| remark.0.contains("passes over")));
    }
}
