//! What Kalibr calls cameras, as ASL's `sensor.yaml` does with its lenses: a lens with a model of its own needs numbers before the focal lengths.

use crate::printable;
use dpn_core::camera::Distortion;

/// A `camera_model`.
#[derive(Debug)]
pub(crate) struct KalibrCamera {
    pub(crate) name: &'static str,
    /// The lens; none where `distortion_model` says it.
    pub(crate) lens: Option<Distortion>,
    /// What `distortion_model` says beside a lens of its own.
    pub(crate) distortion: Option<Distortion>,
    /// What stands before fu, fv, cu, cv.
    pub(crate) leading: &'static [&'static str],
}

/// Model, fu, fv, cu, cv, coefficients.
type Lens = (Distortion, [f64; 4], Vec<f64>);

const ALL: [KalibrCamera; 4] = [
    KalibrCamera { name: "pinhole", lens: None, distortion: None, leading: &[] },
    sphere("omni", Distortion::Omni, Distortion::RadialTangential, &["xi"]),
    sphere("ds", Distortion::DoubleSphere, Distortion::None, &["xi", "alpha"]),
    sphere("eucm", Distortion::EnhancedUnified, Distortion::None, &["alpha", "beta"]),
];

const fn sphere(
    name: &'static str,
    lens: Distortion,
    distortion: Distortion,
    leading: &'static [&'static str],
) -> KalibrCamera {
    KalibrCamera { name, lens: Some(lens), distortion: Some(distortion), leading }
}

impl KalibrCamera {
    /// The one that is called so; else what is wrong with the name.
    fn named(name: &str) -> Result<&'static Self, String> {
        ALL.iter().find(|camera| camera.name == name).ok_or_else(|| {
            let known = ALL.each_ref().map(|camera| format!("\"{}\"", camera.name)).join(", ");
            format!("is \"{}\"; known are {known}", printable(name))
        })
    }

    /// The one that has this lens.
    #[cfg(feature = "images")]
    pub(crate) fn of(lens: Distortion) -> &'static Self {
        ALL.iter().find(|camera| camera.lens == Some(lens)).unwrap_or(&ALL[0])
    }

    /// The lens, fu, fv, cu, cv and all coefficients of a camera that is called so, with what a file says beside; else the key that is wrong, and how.
    pub(crate) fn lens(
        name: &str,
        distortion: Distortion,
        intrinsics: &[f64],
        own: &[f64],
    ) -> Result<Lens, (&'static str, String)> {
        let camera = Self::named(name).map_err(|problem| ("camera_model", problem))?;
        if camera.distortion.is_some_and(|only| distortion != only && distortion != Distortion::None) {
            let problem = format!("is \"{distortion}\"; a camera that is \"{name}\" goes with no such");
            return Err(("distortion_model", problem));
        }
        // What a sphere needs stands before the focal lengths.
        let leading = camera.leading.len();
        let four = intrinsics.get(leading..).and_then(|four| <[f64; 4]>::try_from(four).ok());
        let problem = || format!("is {intrinsics:?}; this camera has {} numbers", 4 + leading);
        let four = four.ok_or_else(|| ("intrinsics", problem()))?;
        let mut coefficients = intrinsics[..leading].to_vec();
        match (camera.lens, distortion) {
            (Some(Distortion::Omni), Distortion::None) => coefficients.extend([0.0; 4]),
            // A sphere without distortion may have zeros in its place.
            (Some(Distortion::DoubleSphere | Distortion::EnhancedUnified), _) | (None, Distortion::None)
                if own.iter().all(|v| *v == 0.0) => {}
            _ => coefficients.extend(own),
        }
        Ok((camera.lens.unwrap_or(distortion), four, coefficients))
    }
}
