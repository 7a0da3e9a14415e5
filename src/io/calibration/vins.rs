//! VINS-Mono's and VINS-Fusion's configuration.
//!
//! `extrinsicRotation` and `extrinsicTranslation` (VINS-Mono), `body_T_cam0` (VINS-Fusion) map camera to IMU. VINS-Fusion keeps the lens in the
//! file that `cam0_calib` names. `td` is added to the image's clock. Lenses are camodocal's: PINHOLE, KANNALA_BRANDT (k2 to k5, mu, mv, u0,
//! v0), MEI (`mirror_parameters`).

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;
use crate::noise_formats::tree::Tree;
use crate::small::read_config;
use dpn_core::camera::Distortion;
use nalgebra::{Matrix3, Vector3};

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let mut found = if keys.has("model_type") || !keys.has("cam0_calib") {
        lens(keys)?
    } else {
        let path = keys.beside("cam0_calib")?;
        let tree = Tree::parse(&read_config(&path)?, &path)?;
        lens(&Keys::new(&path, &tree))?
    };
    if keys.has("body_T_cam0") {
        found.pose = keys.pose("body_T_cam0", "")?;
        found.extrinsics = Extrinsics::CamToImu("body_T_cam0");
    } else {
        let rotation = Matrix3::from_row_slice(&keys.numbers::<9>("extrinsicRotation")?);
        let offset = Vector3::from(keys.numbers::<3>("extrinsicTranslation")?);
        found.pose = keys.rigid("extrinsicRotation", &rotation, offset)?;
    }
    found.offset_s = keys.optional("td")?.unwrap_or(0.0);
    Ok(found)
}

/// The lens; where it sits comes after.
fn lens(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let lens = keys.lens("model_type")?;
    let projection = keys.block("projection_parameters")?;
    let plain = |keys: &Keys<'_>| keys.block("distortion_parameters")?.each(["k1", "k2", "p1", "p2"]);
    let (intrinsics, coefficients) = match lens {
        Distortion::Equidistant => {
            (projection.each(["mu", "mv", "u0", "v0"])?, projection.each(["k2", "k3", "k4", "k5"])?.to_vec())
        }
        Distortion::Omni => {
            let xi = keys.block("mirror_parameters")?.number("xi")?;
            (projection.each(["gamma1", "gamma2", "u0", "v0"])?, [&[xi], &plain(keys)?[..]].concat())
        }
        Distortion::RadialTangential => (projection.each(["fx", "fy", "cx", "cy"])?, plain(keys)?.to_vec()),
        other => {
            let known = "known are PINHOLE, KANNALA_BRANDT, MEI";
            return Err(keys.bad("model_type", format!("is {other}; {known}")));
        }
    };
    Ok(Found {
        size: keys.size(&["image_width", "image_height"])?,
        intrinsics,
        lens,
        coefficients,
        at: keys.place("projection_parameters"),
        pose: nalgebra::Isometry3::identity(),
        extrinsics: Extrinsics::CamToImu("extrinsicRotation"),
        offset_s: 0.0,
        rate: None,
    })
}
