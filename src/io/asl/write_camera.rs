//! Writes `cam0`: its calibration, the list of its images, the images.

use super::camera::CameraFrame;
use super::sequence::{CAMERA_DATA, CAMERA_SENSOR};
use super::write::{matrix, yaml_number};
use crate::kalibr_cameras::KalibrCamera;
use crate::{IoError, ResultPath, atomic_write};
use dpn_core::camera::CameraConfig;
use dpn_core::image::GrayView;
use png::{BitDepth, ColorType, Compression, Encoder};
use std::io;
use std::path::Path;

/// Writes `dir/mav0/cam0/sensor.yaml`.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_camera_config(dir: impl Into<ResultPath>, config: &CameraConfig) -> Result<(), IoError> {
    let list = |values: &[f64]| values.iter().map(|v| yaml_number(*v)).collect::<Vec<_>>().join(", ");
    let [width, height] = config.resolution;
    let camera = KalibrCamera::of(config.distortion);
    let model = camera.distortion.unwrap_or(config.distortion);
    let leading = camera.leading.len().min(config.coefficients.len());
    let (before, coefficients) = config.coefficients.split_at(leading);
    let names = [camera.leading, &["fu", "fv", "cu", "cv"]].concat().join(", ");
    let intrinsics = [before, &config.intrinsics].concat();
    atomic_write(dir.into().join("mav0").join(CAMERA_SENSOR), |out| {
        writeln!(out, "sensor_type: camera")?;
        matrix(out, &config.body_from_cam)?;
        writeln!(out, "rate_hz: {}", yaml_number(config.rate.hz()))?;
        writeln!(out, "resolution: [{width}, {height}]")?;
        writeln!(out, "camera_model: {}", camera.name)?;
        writeln!(out, "intrinsics: [{}] # {names}", list(&intrinsics))?;
        writeln!(out, "distortion_model: {model}")?;
        writeln!(out, "distortion_coefficients: [{}]", list(coefficients))
    })
}

/// Writes `dir/mav0/cam0/data.csv`.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_camera_frames(dir: impl Into<ResultPath>, frames: &[CameraFrame]) -> Result<(), IoError> {
    atomic_write(dir.into().join("mav0").join(CAMERA_DATA), |out| {
        writeln!(out, "#timestamp [ns],filename")?;
        frames.iter().try_for_each(|frame| writeln!(out, "{},{}", frame.t.ns(), frame.file))
    })
}

/// Where the image of a frame of the sequence in `dir` belongs.
pub fn image_place(dir: impl Into<ResultPath>, frame: &CameraFrame) -> ResultPath {
    dir.into().join("mav0").join(Path::new(CAMERA_DATA).with_file_name("data")).join(&frame.file)
}

/// Writes a grey PNG of 8 bits a pixel.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_png(path: impl Into<ResultPath>, image: GrayView<'_>) -> Result<(), IoError> {
    atomic_write(path, |out| out.write_all(&png(image)?))
}

/// A grey PNG of 8 bits a pixel.
///
/// # Errors
/// Sides beyond what the format holds.
pub fn png(image: GrayView<'_>) -> io::Result<Vec<u8>> {
    let whole = image.to_image();
    let side = |side: usize| u32::try_from(side).map_err(io::Error::other);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(image.width())?, side(image.height())?);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Eight);
    // Noise does not compress: more work would save little.
    encoder.set_compression(Compression::Fast);
    encoder.write_header()?.write_image_data(whole.pixels())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asl::Sequence;
    use crate::{ImageFolder, image_file::read_image};
    use dpn_core::camera::Distortion;
    use dpn_core::image::GrayImage;
    use dpn_core::time::{SampleRate, Stamp};
    use nalgebra::{Isometry3, Vector3};

    #[test]
    fn a_camera_of_every_lens_is_read_back_to_the_bit() {
        for (distortion, coefficients) in [
            (Distortion::None, vec![]),
            (Distortion::RadialTangential, vec![-0.3, 1e-5, 0.0, 0.1 + 0.2]),
            (Distortion::RadialTangential, vec![-0.3, 1e-5, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5]),
            (Distortion::Equidistant, vec![-0.3, 1e-5, 0.0, 0.1]),
            (Distortion::Omni, vec![1.1, -0.3, 1e-5, 0.0, 0.1]),
            (Distortion::DoubleSphere, vec![-0.3, 0.6]),
            (Distortion::EnhancedUnified, vec![0.6, 1.1]),
            (Distortion::Fov, vec![0.9]),
        ] {
            read_back(distortion, coefficients);
        }
    }

    fn read_back(distortion: Distortion, coefficients: Vec<f64>) {
        let dir = tempfile::tempdir().unwrap();
        let imu = dir.path().join("mav0/imu0/data.csv");
        std::fs::create_dir_all(imu.parent().unwrap()).unwrap();
        std::fs::write(imu, "").unwrap();
        let config = CameraConfig {
            rate: SampleRate::from_hz(20.0).unwrap(),
            resolution: [5, 3],
            intrinsics: [4.1, 4.2, 2.3, 1.4],
            distortion,
            coefficients,
            body_from_cam: Isometry3::new(Vector3::new(0.1, -0.2, 1e-3), Vector3::new(0.4, 2.0, -0.1)),
        };
        write_camera_config(dir.path(), &config).unwrap();
        let frames: Vec<CameraFrame> = [3_i64, 50_000_003]
            .map(|t| CameraFrame { t: Stamp::from_ns(t), file: format!("{t}.png") })
            .into();
        write_camera_frames(dir.path(), &frames).unwrap();
        let image = GrayImage::from_fn(5, 3, |x, y| (40 * x + 7 * y) as u8).unwrap();
        for frame in &frames {
            write_png(image_place(dir.path(), frame), image.view()).unwrap();
        }
        let sequence = Sequence::open(dir.path()).unwrap();
        let read = sequence.camera_config().unwrap().unwrap();
        assert!((read.body_from_cam.to_matrix() - config.body_from_cam.to_matrix()).norm() < 1e-15);
        assert_eq!(CameraConfig { body_from_cam: config.body_from_cam, ..read }, config);
        assert_eq!(sequence.camera_frames().unwrap(), frames);
        assert!(ImageFolder::open(&sequence).unwrap().coverage().is_complete());
        assert_eq!(read_image(&sequence.image_path(&frames[1]), [5, 3]).unwrap(), image);
    }
}
