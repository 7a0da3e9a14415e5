//! Pinhole projection with radial-tangential distortion.
//!
//! ```text
//! x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)      r2 = x^2 + y^2
//! y' = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 y^2) + 2 p2 x y
//! u  = fx x' + cx,  v = fy y' + cy
//! ```
//!
//! Source: Brown 1966; Heikkila and Silven 1997, eq. 5 to 7; the same as OpenCV with five coefficients.

use super::{CameraConfig, Distortion};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use thiserror::Error;

/// Newton steps of the undistortion; inside an image of a usable lens three suffice.
const NEWTON_STEPS: usize = 12;

/// Residual in normalised coordinates below which undistortion has arrived: 1e-12 is under a billionth of a pixel.
const NEWTON_TOLERANCE: f64 = 1e-12;

/// A calibration that describes no camera.
#[derive(Debug, Error, PartialEq)]
pub enum BadCamera {
    /// A focal length that is not positive, or a value that is not finite.
    #[error(
        "camera intrinsics fx {fx}, fy {fy}, cx {cx}, cy {cy}: focal lengths must be positive, all values finite"
    )]
    Intrinsics {
        /// Focal length in u \[px\].
        fx: f64,
        /// Focal length in v \[px\].
        fy: f64,
        /// Principal point, u \[px\].
        cx: f64,
        /// Principal point, v \[px\].
        cy: f64,
    },
    /// An image without pixels.
    #[error("an image of {width} x {height} px")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Another lens model than this one.
    #[error(
        "the camera's distortion is equidistant; the estimator knows radial-tangential: calibrate the camera for that model"
    )]
    Model,
}

/// Intrinsics of one camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinholeRadtan {
    focal: Vector2<f64>,
    principal: Vector2<f64>,
    distortion: [f64; 5],
    size: [u32; 2],
}

impl PinholeRadtan {
    /// A camera of `size` \[width, height\] with `intrinsics` \[fx, fy, cx, cy\] and `distortion` \[k1, k2, p1, p2, k3\].
    ///
    /// # Errors
    /// Focal lengths that are not positive, values that are not finite, an empty image.
    pub fn new(size: [u32; 2], intrinsics: [f64; 4], distortion: [f64; 5]) -> Result<Self, BadCamera> {
        let [fx, fy, cx, cy] = intrinsics;
        let finite = intrinsics.iter().chain(&distortion).all(|v| v.is_finite());
        if !finite || fx <= 0.0 || fy <= 0.0 {
            return Err(BadCamera::Intrinsics { fx, fy, cx, cy });
        }
        if size.contains(&0) {
            return Err(BadCamera::Size { width: size[0], height: size[1] });
        }
        Ok(Self { focal: Vector2::new(fx, fy), principal: Vector2::new(cx, cy), distortion, size })
    }

    /// EuRoC's cam0 (752 x 480), the camera of the simulated flights.
    pub fn euroc_cam0() -> Self {
        Self {
            focal: Vector2::new(458.654, 457.296),
            principal: Vector2::new(367.215, 248.375),
            distortion: [-0.283_408_11, 0.073_959_07, 0.000_193_59, 1.761_871_14e-5, 0.0],
            size: [752, 480],
        }
    }

    /// Focal lengths in u and v \[px\].
    pub fn focal(&self) -> Vector2<f64> {
        self.focal
    }

    /// The principal point \[px\].
    pub fn principal(&self) -> Vector2<f64> {
        self.principal
    }

    /// k1, k2, p1, p2, k3.
    pub fn distortion(&self) -> [f64; 5] {
        self.distortion
    }

    /// Width and height \[px\].
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether a pixel lies inside the image, at least `margin` \[px\] from its border.
    pub fn contains(&self, px: &Vector2<f64>, margin: f64) -> bool {
        px.x >= margin
            && px.y >= margin
            && px.x <= f64::from(self.size[0]) - 1.0 - margin
            && px.y <= f64::from(self.size[1]) - 1.0 - margin
    }

    /// Distorted normalised coordinates of normalised ones, and the derivative.
    fn distort(&self, n: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (x, y) = (n.x, n.y);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let d_radial = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2); // with respect to r2
        let distorted = Vector2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let cross = 2.0 * x * y * d_radial + 2.0 * p1 * x + 2.0 * p2 * y;
        let d = Matrix2::new(
            radial + 2.0 * x * x * d_radial + 2.0 * p1 * y + 6.0 * p2 * x,
            cross,
            cross,
            radial + 2.0 * y * y * d_radial + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        (distorted, d)
    }

    /// The pixel of a point in the camera's frame \[m, or any scale\]; `None` at or behind the camera's plane.
    ///
    /// The pixel may lie outside the image: see [`Self::contains`]. Far outside it the distortion's polynomial folds back, so a
    /// caller who needs visibility also limits the angle.
    pub fn project(&self, point_in_cam: &Vector3<f64>) -> Option<Vector2<f64>> {
        if point_in_cam.z <= 0.0 {
            return None;
        }
        Some(self.pixel_of(&(point_in_cam.xy() / point_in_cam.z)))
    }

    /// The pixel of normalised coordinates.
    pub fn pixel_of(&self, normalised: &Vector2<f64>) -> Vector2<f64> {
        self.distort(normalised).0.component_mul(&self.focal) + self.principal
    }

    /// As [`Self::project`], with the derivative of the pixel by the point.
    pub fn project_with_jacobian(
        &self,
        point_in_cam: &Vector3<f64>,
    ) -> Option<(Vector2<f64>, Matrix2x3<f64>)> {
        if point_in_cam.z <= 0.0 {
            return None;
        }
        let inverse_z = 1.0 / point_in_cam.z;
        let normalised = point_in_cam.xy() * inverse_z;
        let d_normalised = Matrix2x3::new(
            inverse_z,
            0.0,
            -normalised.x * inverse_z,
            0.0,
            inverse_z,
            -normalised.y * inverse_z,
        );
        let (distorted, d_distorted) = self.distort(&normalised);
        let pixel = distorted.component_mul(&self.focal) + self.principal;
        Some((pixel, Matrix2::from_diagonal(&self.focal) * d_distorted * d_normalised))
    }

    /// Normalised coordinates of a pixel; `None` where the lens model has no inverse (far outside the image).
    pub fn normalise(&self, px: &Vector2<f64>) -> Option<Vector2<f64>> {
        let target = (px - self.principal).component_div(&self.focal);
        let mut n = target;
        for _ in 0..NEWTON_STEPS {
            let (distorted, d) = self.distort(&n);
            let error = target - distorted;
            if error.norm_squared() < NEWTON_TOLERANCE * NEWTON_TOLERANCE {
                return Some(n);
            }
            n += d.try_inverse()? * error;
        }
        let (distorted, d) = self.distort(&n);
        // Past the fold the polynomial has other roots; there the determinant is negative.
        ((target - distorted).norm() < 1e-9 && d.determinant() > 0.0).then_some(n)
    }

    /// The unit vector in the camera's frame that a pixel sees; `None` as [`Self::normalise`].
    pub fn bearing(&self, px: &Vector2<f64>) -> Option<Vector3<f64>> {
        self.normalise(px).map(|n| Vector3::new(n.x, n.y, 1.0).normalize())
    }
}

impl TryFrom<&CameraConfig> for PinholeRadtan {
    type Error = BadCamera;

    fn try_from(config: &CameraConfig) -> Result<Self, BadCamera> {
        let mut distortion = [0.0; 5];
        match config.distortion {
            Distortion::None => {}
            Distortion::RadialTangential => {
                distortion.iter_mut().zip(&config.coefficients).for_each(|(to, from)| *to = *from);
            }
            Distortion::Equidistant => return Err(BadCamera::Model),
        }
        Self::new(config.resolution, config.intrinsics, distortion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_testing::check_jacobian;
    use nalgebra::DVector;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn normalise_undoes_projection_inside_the_image(u in 0.0..751.0f64, v in 0.0..479.0f64) {
            let camera = PinholeRadtan::euroc_cam0();
            let px = Vector2::new(u, v);
            let bearing = camera.bearing(&px).unwrap();
            prop_assert!((bearing.norm() - 1.0).abs() < 1e-14);
            prop_assert!((camera.project(&(bearing * 3.7)).unwrap() - px).norm() < 1e-8);
        }

        #[test]
        fn the_projection_jacobian_is_its_derivative(x in -1.0..1.0f64, y in -0.7..0.7f64, z in 0.3..20.0f64) {
            let camera = PinholeRadtan::euroc_cam0();
            let point = Vector3::new(x * z, y * z, z);
            let (_, jacobian) = camera.project_with_jacobian(&point).unwrap();
            check_jacobian("d_px_d_point", &jacobian, 1e-6, |d| {
                let moved = point + Vector3::from_column_slice(d.as_slice());
                DVector::from_column_slice(camera.project(&moved).unwrap().as_slice())
            });
        }
    }

    #[test]
    fn behind_the_camera_there_is_no_pixel() {
        let camera = PinholeRadtan::euroc_cam0();
        assert!(camera.project(&Vector3::new(0.1, 0.1, 0.0)).is_none());
        assert!(camera.project(&Vector3::new(0.1, 0.1, -1.0)).is_none());
    }

    #[test]
    fn a_camera_without_focal_length_is_refused() {
        let error = PinholeRadtan::new([752, 480], [0.0, 400.0, 1.0, 1.0], [0.0; 5]).unwrap_err();
        assert_eq!(error, BadCamera::Intrinsics { fx: 0.0, fy: 400.0, cx: 1.0, cy: 1.0 });
    }
}
