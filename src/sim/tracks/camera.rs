//! The camera that tracks are made with: its lens and where it sits on the body, as a table of a configuration.

use super::coefficients::Coefficients;
use dpn_core::camera::{BadCamera, CameraConfig, CameraModel, Distortion, Lens};
use dpn_core::config::ConfigFaults;
use dpn_core::geometry::rigid::{NotRigid, rigid};
use nalgebra::{Isometry3, Matrix3, Vector3};
use thiserror::Error;

/// Pixels of the largest camera that is simulated: ray and light of every one are held at a time.
const MOST_PIXELS: u64 = 1 << 23;

dpn_core::settings!(
    /// A camera as numbers, in the order of an ASL `sensor.yaml`. Default: EuRoC's cam0.
    #[derive(Copy)]
    pub struct CameraSettings {
        /// Width and height \[px\].
        pub resolution: [u32; 2] = [752, 480],
        /// fx, fy, cx, cy \[px\].
        pub intrinsics: [f64; 4] = [458.654, 457.296, 367.215, 248.375],
        /// The lens: none, radial-tangential, equidistant, omni, enhanced-unified, double-sphere, fov.
        #[serde(skip_serializing_if = "is_default")]
        pub lens: Distortion = Distortion::RadialTangential,
        /// Its coefficients: k1, k2, p1, p2 (and k3; and k4, k5, k6), or k1 to k4, or xi, k1, k2, p1, p2, or xi, alpha, or w.
        pub distortion: Coefficients = [-0.283_408_11, 0.073_959_07, 0.000_193_59, 1.761_871_14e-5, 0.0].into(),
        /// `T_BS`, its first three rows: points in the camera's frame to the body's, lengths in m.
        pub body_from_cam: [[f64; 4]; 3] = [
                [0.014_865_542_981_8, -0.999_880_929_698, 0.004_140_296_794_22, -0.021_640_145_497_5],
                [0.999_557_249_008, 0.014_967_213_324_7, 0.025_715_529_948, -0.064_676_986_768],
                [-0.025_774_436_697_4, 0.003_756_188_357_97, 0.999_660_727_178, 0.009_810_730_589_49],
            ],
    }
);

fn is_default(lens: &Distortion) -> bool {
    *lens == Distortion::default()
}

/// Settings that describe no camera.
#[derive(Debug, PartialEq, Error)]
pub enum BadCameraSettings {
    /// A lens that is none.
    #[error(transparent)]
    Lens(#[from] BadCamera),
    /// More pixels than are simulated.
    #[error("a camera of {} x {} px is too large to simulate; at most {MOST_PIXELS} pixels are", size[0], size[1])]
    TooLarge {
        /// Width and height \[px\].
        size: [u32; 2],
    },
    /// A matrix without a rotation.
    #[error("the camera's `body_from_cam` {0}")]
    Pose(NotRigid),
}

impl CameraSettings {
    /// The settings of a camera and its place on the body.
    pub fn new(model: &CameraModel, body_from_cam: &Isometry3<f64>) -> Self {
        let (focal, principal) = (model.focal(), model.principal());
        let matrix = body_from_cam.to_matrix();
        Self {
            resolution: model.size(),
            intrinsics: [focal.x, focal.y, principal.x, principal.y],
            lens: model.lens().model(),
            distortion: Coefficients::of(&model.lens()),
            body_from_cam: std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)])),
        }
    }

    /// The lens.
    ///
    /// # Errors
    /// Focal lengths that are not positive, values that are not finite, an empty image or one of more than 8 million pixels.
    pub fn model(&self) -> Result<CameraModel, BadCameraSettings> {
        let [width, height] = self.resolution.map(u64::from);
        if width * height > MOST_PIXELS {
            return Err(BadCameraSettings::TooLarge { size: self.resolution });
        }
        let lens = Lens::new(self.lens, &self.distortion)?;
        Ok(CameraModel::new(self.resolution, self.intrinsics, lens)?)
    }

    /// Points in the camera's frame to the body's.
    ///
    /// # Errors
    /// A matrix whose first three columns are no rotation; values that are not finite.
    pub fn body_from_cam(&self) -> Result<Isometry3<f64>, BadCameraSettings> {
        let rows = self.body_from_cam;
        let matrix = Matrix3::from_fn(|row, column| rows[row][column]);
        let offset = Vector3::from_fn(|row, _| rows[row][3]);
        rigid(&matrix, offset).map_err(BadCameraSettings::Pose)
    }

    /// Adds what is wrong with it to `faults`, under the key `camera`.
    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        if let Err(error @ BadCamera::Coefficients { .. }) = Lens::new(self.lens, &self.distortion) {
            faults.check(false, "camera.distortion", error, "coefficients that the lens has");
        } else if self.model().is_err() {
            let value = format!("{:?} with intrinsics {:?}", self.resolution, self.intrinsics);
            let bound =
                format!("finite, with positive focal lengths and an image of 1 to {MOST_PIXELS} pixels");
            faults.check(false, "camera.intrinsics", value, bound);
        }
        if let Err(error) = self.body_from_cam() {
            faults.check(false, "camera.body_from_cam", error, "three rows [R | t], R a rotation");
        }
    }
}

impl TryFrom<&CameraConfig> for CameraSettings {
    type Error = BadCamera;

    /// The camera of a sequence.
    fn try_from(config: &CameraConfig) -> Result<Self, BadCamera> {
        Ok(Self::new(&CameraModel::try_from(config)?, &config.body_from_cam))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_eurocs_camera() {
        let settings = CameraSettings::default();
        assert_eq!(settings.model().unwrap(), CameraModel::euroc_cam0());
        // A point on the optical axis, by hand.
        let ahead = settings.body_from_cam().unwrap() * nalgebra::Point3::new(0.0, 0.0, 2.0);
        let expected = Vector3::new(
            2.0 * 0.00414029679422 - 0.0216401454975,
            2.0 * 0.025715529948 - 0.064676986768,
            2.0 * 0.999660727178 + 0.00981073058949,
        );
        assert!((ahead.coords - expected).norm() < 1e-9);
    }

    #[test]
    fn settings_made_from_parts_give_the_parts_back() {
        let pose = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(1.0, 2.0, -0.5));
        let settings = CameraSettings::new(&CameraModel::euroc_cam0(), &pose);
        let back = settings.body_from_cam().unwrap();
        assert!((back.to_matrix() - pose.to_matrix()).norm() < 1e-14);
    }

    #[test]
    fn a_matrix_that_is_no_rotation_is_refused_with_what_is_off() {
        let mut settings = CameraSettings::default();
        settings.body_from_cam[0] = settings.body_from_cam[1];
        let error = settings.body_from_cam().unwrap_err().to_string();
        assert!(error.starts_with("the camera's `body_from_cam` holds no rotation"), "{error}");
        settings.body_from_cam = [[f64::NAN; 4]; 3];
        assert!(settings.body_from_cam().is_err());
    }
}
