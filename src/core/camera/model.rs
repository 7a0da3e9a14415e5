//! A lens with focal lengths and a principal point: pixels.
//!
//! ```text
//! u = fx x' + cx,  v = fy y' + cy      (x', y') the lens' image in a plane of unit focal length
//! ```

use super::lens_model::LensModel;
use super::{BadCamera, CameraConfig, Distortion, Equidistant, Lens};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// How far off the axis a point is of use \[rad\]: 80 degrees. Landmarks hang on rays `(x, y, 1)`, whose deviation at 80 degrees is 33
/// times that on the axis and has no end at 90.
pub const WIDEST_RAD: f64 = 80.0 / 180.0 * std::f64::consts::PI;

/// Its tangent, squared.
const WIDEST_TAN2: f64 = 32.163_437_477_526_32;

/// Intrinsics of one camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraModel {
    focal: Vector2<f64>,
    principal: Vector2<f64>,
    lens: Lens,
    size: [u32; 2],
}

impl CameraModel {
    /// A camera of `size` \[width, height\] with `intrinsics` \[fx, fy, cx, cy\].
    ///
    /// # Errors
    /// Focal lengths that are not positive, values that are not finite, an empty image.
    pub fn new(size: [u32; 2], intrinsics: [f64; 4], lens: Lens) -> Result<Self, BadCamera> {
        let [fx, fy, cx, cy] = intrinsics;
        if !intrinsics.iter().all(|v| v.is_finite()) || fx <= 0.0 || fy <= 0.0 {
            return Err(BadCamera::Intrinsics { fx, fy, cx, cy });
        }
        if size.contains(&0) {
            return Err(BadCamera::Size { width: size[0], height: size[1] });
        }
        Ok(Self { focal: Vector2::new(fx, fy), principal: Vector2::new(cx, cy), lens, size })
    }

    /// A pinhole with `distortion` \[k1, k2, p1, p2, k3\].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn radtan(size: [u32; 2], intrinsics: [f64; 4], distortion: [f64; 5]) -> Result<Self, BadCamera> {
        if distortion.iter().any(|v| !v.is_finite()) {
            let (model, found) = (Distortion::RadialTangential, distortion.to_vec());
            return Err(BadCamera::Coefficients { model, found });
        }
        Self::new(size, intrinsics, Lens::radtan(distortion))
    }

    /// EuRoC's cam0 (752 x 480), the camera of the simulated flights.
    pub fn euroc_cam0() -> Self {
        Self {
            focal: Vector2::new(458.654, 457.296),
            principal: Vector2::new(367.215, 248.375),
            lens: Lens::radtan([-0.283_408_11, 0.073_959_07, 0.000_193_59, 1.761_871_14e-5, 0.0]),
            size: [752, 480],
        }
    }

    /// A fish-eye as TUM-VI's cam0 (512 x 512), from its published calibration.
    pub fn tumvi_cam0() -> Self {
        let k = [
            0.003_482_389_402_249_343_4,
            0.000_715_034_845_216_225_7,
            -0.002_053_236_141_870_620_2,
            0.000_202_936_735_918_111_82,
        ];
        Self {
            focal: Vector2::new(190.978_477_151_287_17, 190.973_307_052_122_6),
            principal: Vector2::new(254.931_706_059_354_75, 256.897_442_899_650_4),
            lens: Lens::Equidistant(Equidistant::new(k)),
            size: [512, 512],
        }
    }

    /// The camera of [reduced](crate::GrayImage::reduced) images.
    ///
    /// # Panics
    /// An image smaller than one pixel of the reduced one.
    #[must_use]
    pub fn reduced(&self, times: usize) -> Self {
        let by = times as f64;
        let size = self.size.map(|side| side / times as u32);
        assert!(!size.contains(&0), "an image smaller than {times} pixels");
        Self {
            focal: self.focal / by,
            // Pixels' centres have whole numbers.
            principal: self.principal.map(|c| (c + 0.5) / by - 0.5),
            size,
            ..*self
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

    /// The lens.
    pub fn lens(&self) -> Lens {
        self.lens
    }

    /// Pixels a radian at the image's centre, the mean of both directions: what turns an error in pixels into an angle. The focal length of a
    /// pinhole and of an equidistant lens; others begin with another slope.
    pub fn px_per_rad(&self) -> f64 {
        self.focal.mean() * self.lens.slope()
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

    /// The pixel of a point in the camera's frame \[m, or any scale\]; `None` where the lens does not see it: behind a pinhole's plane, past the
    /// angle at which the distortion folds back.
    ///
    /// The pixel may lie outside the image: see [`Self::contains`].
    pub fn project(&self, point_in_cam: &Vector3<f64>) -> Option<Vector2<f64>> {
        Some(self.lens.project(point_in_cam)?.component_mul(&self.focal) + self.principal)
    }

    /// As [`Self::project`], with the derivative of the pixel by the point.
    pub fn project_with_jacobian(
        &self,
        point_in_cam: &Vector3<f64>,
    ) -> Option<(Vector2<f64>, Matrix2x3<f64>)> {
        let at = self.lens.project_with_jacobian(point_in_cam)?;
        let pixel = at.place.component_mul(&self.focal) + self.principal;
        Some((pixel, Matrix2::from_diagonal(&self.focal) * at.d_place * at.d_inner))
    }

    /// The unit vector in the camera's frame that a pixel sees; `None` where the lens has no inverse (far outside the image).
    pub fn bearing(&self, px: &Vector2<f64>) -> Option<Vector3<f64>> {
        let place = (px - self.principal).component_div(&self.focal);
        self.lens.unproject(&place).map(|direction| direction.normalize())
    }

    /// Normalised coordinates of a pixel; `None` as [`Self::bearing`], and where they are more than [`WIDEST_RAD`] off the axis.
    pub fn normalise(&self, px: &Vector2<f64>) -> Option<Vector2<f64>> {
        let place = (px - self.principal).component_div(&self.focal);
        let direction = self.lens.unproject(&place).filter(is_of_use)?;
        Some(direction.xy() / direction.z)
    }

    /// The bearing of a pixel that is of use to an odometry: at most [`WIDEST_RAD`] off the axis.
    pub fn sight(&self, px: &Vector2<f64>) -> Option<Vector3<f64>> {
        self.bearing(px).filter(is_of_use)
    }

    /// Whether every pixel of the image has a [`Self::sight`]; its border tells, for the angle grows outwards.
    pub fn sees_all(&self) -> bool {
        let [width, height] = self.size.map(|side| f64::from(side) - 1.0);
        let corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)];
        corners.iter().all(|(u, v)| self.sight(&Vector2::new(*u, *v)).is_some())
    }
}

fn is_of_use(direction: &Vector3<f64>) -> bool {
    direction.z > 0.0 && direction.xy().norm_squared() <= WIDEST_TAN2 * direction.z * direction.z
}

impl TryFrom<&CameraConfig> for CameraModel {
    type Error = BadCamera;

    fn try_from(config: &CameraConfig) -> Result<Self, BadCamera> {
        let lens = Lens::new(config.distortion, &config.coefficients)?;
        Self::new(config.resolution, config.intrinsics, lens)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_testing::check_jacobian;
    use nalgebra::DVector;
    use proptest::prelude::*;

    #[test]
    fn a_reduced_camera_sees_a_point_where_its_reduced_pixel_is() {
        let (camera, point) = (CameraModel::euroc_cam0(), Vector3::new(0.3, -0.2, 1.5));
        let third = camera.reduced(3);
        assert_eq!(third.size(), [250, 160]);
        // The middle pixel of a square of nine is the one pixel that is left.
        let middle = 3.0 * third.project(&point).unwrap() + Vector2::new(1.0, 1.0);
        assert!((middle - camera.project(&point).unwrap()).norm() < 1e-9);
        assert!((third.px_per_rad() - camera.px_per_rad() / 3.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn normalise_undoes_projection_inside_the_image(u in 0.0..751.0f64, v in 0.0..479.0f64) {
            let camera = CameraModel::euroc_cam0();
            let px = Vector2::new(u, v);
            let bearing = camera.bearing(&px).unwrap();
            prop_assert!((bearing.norm() - 1.0).abs() < 1e-14);
            prop_assert!((camera.project(&(bearing * 3.7)).unwrap() - px).norm() < 1e-8);
        }

        #[test]
        fn the_projection_jacobian_is_its_derivative(x in -1.0..1.0f64, y in -0.7..0.7f64, z in 0.3..20.0f64) {
            let camera = CameraModel::euroc_cam0();
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
        let camera = CameraModel::euroc_cam0();
        assert!(camera.project(&Vector3::new(0.1, 0.1, 0.0)).is_none());
        assert!(camera.project(&Vector3::new(0.1, 0.1, -1.0)).is_none());
    }

    #[test]
    fn a_camera_without_focal_length_is_refused() {
        let error = CameraModel::radtan([752, 480], [0.0, 400.0, 1.0, 1.0], [0.0; 5]).unwrap_err();
        assert_eq!(error, BadCamera::Intrinsics { fx: 0.0, fy: 400.0, cx: 1.0, cy: 1.0 });
    }
}
