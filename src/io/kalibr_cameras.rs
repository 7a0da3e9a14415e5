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
    pub(crate) fn named(name: &str) -> Result<&'static Self, String> {
        ALL.iter().find(|camera| camera.name == name).ok_or_else(|| {
            let known = ALL.each_ref().map(|camera| format!("\"{}\"", camera.name)).join(", ");
            format!("is \"{}\"; known are {known}", printable(name))
        })
    }

    /// The one that has this lens.
    pub(crate) fn of(lens: Distortion) -> &'static Self {
        ALL.iter().find(|camera| camera.lens == Some(lens)).unwrap_or(&ALL[0])
    }
}
