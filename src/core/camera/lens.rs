//! What a lens does: directions to a plane of unit focal length, and back.

use super::lens_model::{LensModel, Placed};
use super::radial::{Equidistant, Fov};
use super::radtan::Radtan;
use super::sphere::{DoubleSphere, EnhancedUnified, Omni};
use super::{BadCamera, Distortion};
use nalgebra::{Vector2, Vector3};

/// The lenses there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// A pinhole with radial-tangential distortion.
    Radtan(Radtan),
    /// Equidistant (fish-eye, Kannala-Brandt).
    Equidistant(Equidistant),
    /// Unified (MEI, omnidirectional).
    Omni(Omni),
    /// Enhanced unified.
    EnhancedUnified(EnhancedUnified),
    /// Double sphere.
    DoubleSphere(DoubleSphere),
    /// Field of view.
    Fov(Fov),
}

impl Lens {
    /// A pinhole without distortion, or with k1, k2, p1, p2, k3.
    pub fn radtan(distortion: [f64; 5]) -> Self {
        Self::Radtan(Radtan::new(distortion, None))
    }

    /// The lens of a calibration.
    ///
    /// # Errors
    /// Another number of coefficients than the model has, or such as it cannot have.
    pub fn new(model: Distortion, coefficients: &[f64]) -> Result<Self, BadCamera> {
        let bad = || BadCamera::Coefficients { model, found: coefficients.to_vec() };
        if !model.counts().contains(&coefficients.len()) || coefficients.iter().any(|c| !c.is_finite()) {
            return Err(bad());
        }
        let lens = match (model, coefficients) {
            (Distortion::Equidistant, &[k1, k2, k3, k4]) => {
                Some(Self::Equidistant(Equidistant::new([k1, k2, k3, k4])))
            }
            (Distortion::Omni, &[xi, k1, k2, p1, p2]) => Omni::new(xi, [k1, k2, p1, p2]).map(Self::Omni),
            (Distortion::EnhancedUnified, &[alpha, beta]) => {
                EnhancedUnified::new(alpha, beta).map(Self::EnhancedUnified)
            }
            (Distortion::DoubleSphere, &[xi, alpha]) => DoubleSphere::new(xi, alpha).map(Self::DoubleSphere),
            (Distortion::Fov, &[w]) => Fov::new(w).map(Self::Fov),
            (Distortion::RadialTangential, &[k1, k2, p1, p2, k3, k4, k5, k6]) => {
                Some(Self::Radtan(Radtan::new([k1, k2, p1, p2, k3], Some([k4, k5, k6]))))
            }
            (_, plain) => {
                let mut upper = [0.0; 5];
                upper.iter_mut().zip(plain).for_each(|(to, from)| *to = *from);
                Some(Self::radtan(upper))
            }
        };
        lens.ok_or_else(bad)
    }

    /// Its model.
    pub fn model(&self) -> Distortion {
        match self {
            Self::Radtan(_) => Distortion::RadialTangential,
            Self::Equidistant(_) => Distortion::Equidistant,
            Self::Omni(_) => Distortion::Omni,
            Self::EnhancedUnified(_) => Distortion::EnhancedUnified,
            Self::DoubleSphere(_) => Distortion::DoubleSphere,
            Self::Fov(_) => Distortion::Fov,
        }
    }

    /// Its coefficients, in the model's order.
    pub fn coefficients(&self) -> Vec<f64> {
        match self {
            Self::Radtan(lens) => lens.coefficients(),
            Self::Equidistant(lens) => lens.coefficients(),
            Self::Omni(lens) => lens.coefficients(),
            Self::EnhancedUnified(lens) => lens.coefficients(),
            Self::DoubleSphere(lens) => lens.coefficients(),
            Self::Fov(lens) => lens.coefficients(),
        }
    }

    /// How the image grows with the angle at its centre \[1/rad\]; times the focal length, pixels a radian.
    pub(super) fn slope(&self) -> f64 {
        match self {
            Self::Radtan(_) | Self::Equidistant(_) | Self::EnhancedUnified(_) => 1.0,
            Self::Omni(lens) => lens.slope(),
            Self::DoubleSphere(lens) => lens.slope(),
            Self::Fov(lens) => lens.slope(),
        }
    }
}

impl LensModel for Lens {
    #[inline]
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        match self {
            Self::Radtan(lens) => lens.project(point),
            Self::Equidistant(lens) => lens.project(point),
            Self::Omni(lens) => lens.project(point),
            Self::EnhancedUnified(lens) => lens.project(point),
            Self::DoubleSphere(lens) => lens.project(point),
            Self::Fov(lens) => lens.project(point),
        }
    }

    #[inline]
    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        match self {
            Self::Radtan(lens) => lens.project_with_jacobian(point),
            Self::Equidistant(lens) => lens.project_with_jacobian(point),
            Self::Omni(lens) => lens.project_with_jacobian(point),
            Self::EnhancedUnified(lens) => lens.project_with_jacobian(point),
            Self::DoubleSphere(lens) => lens.project_with_jacobian(point),
            Self::Fov(lens) => lens.project_with_jacobian(point),
        }
    }

    #[inline]
    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        match self {
            Self::Radtan(lens) => lens.unproject(place),
            Self::Equidistant(lens) => lens.unproject(place),
            Self::Omni(lens) => lens.unproject(place),
            Self::EnhancedUnified(lens) => lens.unproject(place),
            Self::DoubleSphere(lens) => lens.unproject(place),
            Self::Fov(lens) => lens.unproject(place),
        }
    }
}
