//! DSO's and DM-VIO's `camera.txt`: a lens without a place on the IMU.
//!
//! Line 1: `RadTan fx fy cx cy k1 k2 r1 r2`, `Pinhole fx fy cx cy 0`, `FOV fx fy cx cy omega`, `EquiDistant` or `KannalaBrandt fx fy cx cy k1 k2 k3 k4`; without a
//! name by the number of numbers, `fx fy cx cy omega` or `fx fy cx cy k1 k2 r1 r2`. Line 2: width and height of the images. What follows is of the rectified
//! image and passed over. Numbers that are shares of the image's size have a centre half a pixel off. Source: DSO's README.
//!
//! Where the camera sits stands in Kalibr's `camchain.yaml`, beside it or in the folder above; that one may hold the extrinsics alone.

use super::CalibrationError;
use super::keys::Place;
use crate::small::read_config;
use dpn_core::camera::Distortion;
use std::path::{Path, PathBuf};

/// Names of lenses, how many coefficients follow, and the lens.
const LENSES: [(&str, usize, Distortion); 5] = [
    ("Pinhole", 1, Distortion::None),
    ("FOV", 1, Distortion::Fov),
    ("RadTan", 4, Distortion::RadialTangential),
    ("EquiDistant", 4, Distortion::Equidistant),
    ("KannalaBrandt", 4, Distortion::Equidistant),
];

/// What the file says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lens {
    pub(super) size: [u32; 2],
    pub(super) intrinsics: [f64; 4],
    pub(super) lens: Distortion,
    pub(super) coefficients: Vec<f64>,
}

/// Reads it; none where it is no such file.
pub(super) fn parse(bytes: &[u8]) -> Option<Lens> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut lines =
        text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>()).filter(|l| !l.is_empty());
    let first = lines.next()?;
    let numbers =
        |fields: &[&str]| fields.iter().map(|f| f.parse::<f64>().ok()).collect::<Option<Vec<f64>>>();
    let named = LENSES.iter().find(|(name, ..)| name.eq_ignore_ascii_case(first[0]));
    let values = numbers(&first[usize::from(named.is_some())..])?;
    let lens = match named {
        Some((.., count, lens)) => (values.len() == 4 + count).then_some(*lens)?,
        None if values.len() == 5 => Distortion::Fov,
        None if values.len() == 8 => Distortion::RadialTangential,
        None => return None,
    };
    let size = match numbers(&lines.next()?)?[..] {
        [width, height]
            if [width, height].iter().all(|v| (1.0..65_536.0).contains(v) && v.fract() == 0.0) =>
        {
            [width as u32, height as u32]
        }
        _ => return None,
    };
    let mut intrinsics = [values[0], values[1], values[2], values[3]];
    if values[2] < 1.0 && values[3] < 1.0 {
        let [width, height] = size.map(f64::from);
        intrinsics =
            [values[0] * width, values[1] * height, values[2] * width - 0.5, values[3] * height - 0.5];
    }
    let mut coefficients = values[4..].to_vec();
    let lens = match lens {
        Distortion::Fov if coefficients == [0.0] => Distortion::None,
        lens => lens,
    };
    if lens == Distortion::None {
        coefficients.clear();
    }
    Some(Lens { size, intrinsics, lens, coefficients })
}

/// The same of the file at `path`, and where it stands.
pub(super) fn lens_at(bytes: &[u8], path: &Path) -> Option<(Lens, Place)> {
    Some((parse(bytes)?, Place::new(path, 1, "the lens")))
}

/// The `camera.txt` beside the file at `path`, or in the folder `cam0` there.
pub(super) fn beside(path: &Path) -> Result<Option<(Lens, Place)>, CalibrationError> {
    let files = ["camera.txt", "cam0/camera.txt"].map(|name| path.with_file_name(name));
    for file in files.into_iter().filter(|file| file.is_file()) {
        if let Some(found) = lens_at(&read_config(&file)?, &file) {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// Kalibr's file beside the `camera.txt` at `path`, or above it.
pub(super) fn chain(path: &Path) -> Option<PathBuf> {
    let own = path.parent().unwrap_or(Path::new(""));
    let above = own.join("..");
    let names = ["camchain.yaml", "camchain-imucam.yaml"];
    [own, &above].into_iter().flat_map(|dir| names.map(|name| dir.join(name))).find(|file| file.is_file())
}
