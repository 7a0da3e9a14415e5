//! How a camera turns while the lines of an image are read out, and what its pixels see once that is taken out.
//!
//! Line y of h is exposed at `t + readout (y/(h - 1) - 1/2)`, t being the image's stamp. Where the camera turns meanwhile, a pixel does not
//! see what the camera of the stamp would see there: at 1.5 rad/s and 30 ms the first line is 1.3 deg off. So
//! `bearing_in_image = image_from_line(y) bearing_in_line`, from the gyroscope, and everything after the search for pixels has to do with
//! the camera of the stamp alone. How far the camera moved meanwhile is
//! the window's, which knows how far off things are: it asks for [`line_delay`].

use dpn_core::camera::CameraModel;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// Instants of a readout at which the turn is known, its first and its last among them.
pub(super) const KNOTS: usize = 7;

/// Rounds in which the line that sees a direction is found: a pixel moves a tenth of a line while a line is read out.
const ROUNDS: usize = 5;

/// How long after the image's stamp the line of `px` is exposed, where it takes `readout_s` from the first to the last \[s\].
pub(crate) fn line_delay(camera: &CameraModel, px: &Vector2<f64>, readout_s: f64) -> f64 {
    readout_s * (line_share(camera, px) - 0.5)
}

/// How far down the image the line of `px` is: 0 the first, 1 the last.
fn line_share(camera: &CameraModel, px: &Vector2<f64>) -> f64 {
    px.y / (f64::from(camera.size()[1]) - 1.0).max(1.0)
}

/// The camera's turns while an image is read out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineTurns {
    /// The camera's frame at evenly spaced instants of the readout to that at the image's stamp.
    image_from_line: [UnitQuaternion<f64>; KNOTS],
    readout_s: f64,
}

impl LineTurns {
    /// From the turns of the body, `body_at_image_from_body_at_line`.
    pub(crate) fn new(
        body: &[UnitQuaternion<f64>; KNOTS],
        body_from_cam: &UnitQuaternion<f64>,
        readout_s: f64,
    ) -> Self {
        Self { image_from_line: body.map(|turn| body_from_cam.inverse() * turn * body_from_cam), readout_s }
    }

    /// From the first line's exposure to the last's \[s\].
    pub(super) fn readout_s(&self) -> f64 {
        self.readout_s
    }

    /// How long after the image's stamp the lines `share` of the way down are exposed \[s\].
    fn delay(&self, share: f64) -> f64 {
        self.readout_s * (share - 0.5)
    }

    /// The turn of the lines `share` of the way down, the gyroscope's bias in the camera's frame taken out.
    fn at(&self, share: f64, bias: &Vector3<f64>) -> UnitQuaternion<f64> {
        let place = share.clamp(0.0, 1.0) * (KNOTS - 1) as f64;
        let knot = (place as usize).min(KNOTS - 2);
        let turn = self.image_from_line[knot].nlerp(&self.image_from_line[knot + 1], place - knot as f64);
        // From the line to the stamp is the delay backwards; the bias is taken out as from a turn between images.
        UnitQuaternion::from_scaled_axis(-self.delay(share) * bias) * turn
    }

    /// What `px` sees, in the camera's frame at the image's stamp.
    pub(super) fn sight(
        &self,
        camera: &CameraModel,
        px: &Vector2<f64>,
        bias: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        Some(self.at(line_share(camera, px), bias) * camera.sight(px)?)
    }

    /// The pixel that sees `bearing`, which the camera of the stamp would see at `px`; none where it leaves the lens.
    pub(super) fn pixel(
        &self,
        camera: &CameraModel,
        bearing: &Vector3<f64>,
        px: Vector2<f64>,
        bias: &Vector3<f64>,
    ) -> Option<Vector2<f64>> {
        let mut px = px;
        for _ in 0..ROUNDS {
            px = camera.project(&self.at(line_share(camera, &px), bias).inverse_transform_vector(bearing))?;
        }
        Some(px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_s_direction_leads_back_to_it_and_lies_where_the_turn_says() {
        let camera = CameraModel::euroc_cam0();
        let rate = Vector3::new(1.4, -0.8, 2.0);
        let (readout, bias) = (0.03, Vector3::new(0.02, 0.0, -0.01));
        let turns = std::array::from_fn(|k| {
            let delay = readout * (k as f64 / (KNOTS - 1) as f64 - 0.5);
            UnitQuaternion::from_scaled_axis((rate - bias) * delay)
        });
        let lines = LineTurns::new(&turns, &UnitQuaternion::identity(), readout);
        for (u, v) in [(30.0, 12.0), (700.0, 470.0), (376.0, 239.5), (100.0, 300.0)] {
            let px = Vector2::new(u, v);
            // The gyroscope measures w_m; the camera's frame turns as its `corrected` says: Exp(bias dt) after the turn.
            let seen = lines.sight(&camera, &px, &bias).unwrap();
            let delay = readout * (v / 479.0 - 0.5);
            let plain = UnitQuaternion::from_scaled_axis((rate - bias) * delay) * camera.sight(&px).unwrap();
            let expected = UnitQuaternion::from_scaled_axis(-bias * delay) * plain;
            assert!((seen - expected).norm() < 1e-7, "{seen} {expected}");
            let start = camera.project(&seen).unwrap();
            assert!((lines.pixel(&camera, &seen, start, &bias).unwrap() - px).norm() < 1e-3);
        }
    }
}
