//! `cam0`: the stamps of its images and its calibration.

use super::yaml::{self, Matrix};
use crate::IoError;
use crate::decimal::TimeUnit;
use crate::kalibr_cameras::KalibrCamera;
use crate::printable;
use crate::row_fault::RowFault;
use crate::rows::Rows;
use dpn_core::camera::{CameraConfig, Distortion, Lens, UnknownLens};
use dpn_core::time::Stamp;
use serde::Deserialize;
use std::path::{Component, Path};

/// One image: when it was taken and the file that holds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraFrame {
    /// When it was taken.
    pub t: Stamp,
    /// File name inside `cam0/data`.
    pub file: String,
}

#[derive(Deserialize)]
struct Raw {
    rate_hz: f64,
    resolution: [u32; 2],
    camera_model: Option<String>,
    intrinsics: Vec<f64>,
    distortion_model: Option<String>,
    #[serde(default)]
    distortion_coefficients: Vec<f64>,
    #[serde(rename = "T_BS")]
    t_bs: Matrix,
}

/// Reads a camera's calibration as ASL has it in `cam0/sensor.yaml`. Keys it does not know are passed over.
///
/// # Errors
/// A file that cannot be read, lacks a key or holds a value that cannot be.
pub fn read_config(path: &Path) -> Result<CameraConfig, IoError> {
    parse_config(&crate::small::read_config(path)?, path)
}

/// Reads a `cam0/sensor.yaml` from bytes at hand; `path` is for messages. Keys it does not know are passed over.
pub(crate) fn parse_config(bytes: &[u8], path: &Path) -> Result<CameraConfig, IoError> {
    let raw: Raw = yaml::parse(bytes, path)?;
    let bad = |key, problem| IoError::BadKey { path: path.to_path_buf(), key, problem };
    let named = raw.distortion_model.as_deref().unwrap_or("none").parse::<Distortion>();
    let unknown = |unknown: UnknownLens| format!("is \"{}\"; {unknown}", printable(&unknown.0));
    let named = named.map_err(|lens| bad("distortion_model", unknown(lens)))?;
    let camera = raw.camera_model.as_deref().unwrap_or("pinhole");
    let lens = KalibrCamera::lens(camera, named, &raw.intrinsics, &raw.distortion_coefficients);
    let (distortion, intrinsics, coefficients) = lens.map_err(|(key, problem)| bad(key, problem))?;
    if let Err(problem) = Lens::new(distortion, &coefficients) {
        return Err(bad("distortion_coefficients", format!("make {problem}")));
    }
    let [fu, fv, cu, cv] = intrinsics;
    if !(fu > 0.0 && fv > 0.0 && [fu, fv, cu, cv].iter().all(|v| v.is_finite())) {
        return Err(bad(
            "intrinsics",
            format!("is {:?}; fu and fv must be positive, all four finite", raw.intrinsics),
        ));
    }
    if raw.resolution.contains(&0) {
        return Err(bad("resolution", format!("is {:?}", raw.resolution)));
    }
    Ok(CameraConfig {
        rate: yaml::rate(raw.rate_hz, path)?,
        resolution: raw.resolution,
        intrinsics,
        distortion,
        coefficients,
        body_from_cam: yaml::body_from_sensor(&raw.t_bs, path)?,
    })
}

pub(super) fn read_frames(path: &Path) -> Result<Vec<CameraFrame>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse_frames(&bytes, path)
}

/// Whether a name joined to a folder names something in it, and can be shown.
pub(crate) fn stays_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let is_plain = |part| matches!(part, Component::Normal(_));
    !name.is_empty() && parts.all(is_plain) && !name.contains('\\') && printable(name) == name
}

/// Reads a `cam0/data.csv` from bytes at hand; `path` is for messages. Without a second column the file is `STAMP.png`.
pub(crate) fn parse_frames(bytes: &[u8], path: &Path) -> Result<Vec<CameraFrame>, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    let mut frames: Vec<CameraFrame> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let t = rows.stamp_after(frames.last().map(|f| f.t), 0, TimeUnit::Nanos)?;
        let file = if rows.width() > 1 { rows.text(1)?.to_owned() } else { format!("{}.png", t.ns()) };
        if !stays_inside(&file) {
            let name = printable(&file.chars().take(80).collect::<String>());
            return Err(rows.fault(RowFault::BadName { name }));
        }
        frames.push(CameraFrame { t, file });
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    const GOOD: &str = "rate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n\
        intrinsics: [458.654, 457.296, 367.215, 248.375] # fu, fv, cu, cv\ndistortion_model: radial-tangential\n\
        distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\nT_BS:\n  cols: 4\n  rows: 4\n\
        \x20 data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,\n\
        \x20        0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,\n\
        \x20       -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,\n\
        \x20        0.0, 0.0, 0.0, 1.0]\n";

    fn parse(text: &str) -> Result<CameraConfig, IoError> {
        parse_config(text.as_bytes(), Path::new("sensor.yaml"))
    }

    #[test]
    fn the_euroc_camera_looks_where_its_matrix_says() {
        let config = parse(GOOD).unwrap();
        assert_eq!(config.resolution, [752, 480]);
        assert_eq!(config.coefficients.len(), 4);
        // As Kimera and OpenCV begin their files.
        assert_eq!(parse(&format!("%YAML:1.0\ncamera_id: left_cam\n{GOOD}")).unwrap(), config);
        // The matrix times (1, 2, 3, 1), by hand.
        let point = config.body_from_cam * Point3::new(1.0, 2.0, 3.0);
        let expected = Vector3::new(
            0.0148655429818 - 2.0 * 0.999880929698 + 3.0 * 0.00414029679422 - 0.0216401454975,
            0.999557249008 + 2.0 * 0.0149672133247 + 3.0 * 0.025715529948 - 0.064676986768,
            -0.0257744366974 + 2.0 * 0.00375618835797 + 3.0 * 0.999660727178 + 0.00981073058949,
        );
        assert!((point.coords - expected).norm() < 1e-9);
    }

    #[test]
    fn values_that_cannot_be_are_refused_with_their_key() {
        let error = |from: &str, to: &str| parse(&GOOD.replace(from, to)).unwrap_err().to_string();
        assert!(error("pinhole", "cylinder").contains("`camera_model` is \"cylinder\""));
        assert!(error("pinhole", "omni").contains("this camera has 5 numbers"));
        assert!(error("radial-tangential", "lens").contains("`distortion_model` is \"lens\""));
        assert!(
            error(", 1.76187114e-05", "")
                .contains("`distortion_coefficients` make a lens that is radial-tangential with")
        );
        assert!(error("458.654", "-1").contains("`intrinsics` is"));
        assert!(error("0.999660727178", "1.1").contains("`T_BS` holds no rotation"));
        assert!(error("0.0, 0.0, 0.0, 1.0", "0.0, 0.0, 0.0, 2.0").contains("`T_BS` ends with the row"));
    }

    #[test]
    fn frames_have_names_and_increase() {
        let parse = |text: &str| parse_frames(text.as_bytes(), Path::new("data.csv"));
        let frames = parse("#timestamp [ns],filename\r\n10,a.png\r\n20,b.png\r\n").unwrap();
        assert_eq!((frames[1].t.ns(), frames[1].file.as_str()), (20, "b.png"));
        assert_eq!(parse("10\n20\n").unwrap()[0].file, "10.png");
        assert_eq!(parse("10,left/10.png\n").unwrap()[0].file, "left/10.png");
        for out in ["../../../etc/passwd", "/etc/passwd", "a/../../b.png", "..\\b.png", "a\u{1b}[2J.png"] {
            let error = parse(&format!("10,a.png\n20,{out}\n")).unwrap_err().to_string();
            let said =
                format!("data.csv:2: the image `{}` is no file in the camera's folder", printable(out));
            assert_eq!(error, said);
        }
        assert_eq!(
            parse("10,a\n10,b\n").unwrap_err().to_string(),
            "data.csv:2: time goes from 10 to 10 ns; stamps must increase"
        );
    }
}
