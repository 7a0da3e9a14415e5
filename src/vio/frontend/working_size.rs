//! How large an image is best for following points.
//!
//! A pixel of a camera with many is small and noisy, a hand's motion is blurred over several of them, and a window of the same number of pixels sees less of the
//! world: tracks of a hand-held 1280 x 720 lived 2.6 frames, of the same images at half that size 5.9.

use dpn_core::GrayImage;
use dpn_core::camera::CameraModel;

/// The longer side has at least so many pixels, and less than twice as many, where the camera has them.
const FEWEST: usize = 640;

fn reduction(size: [usize; 2]) -> usize {
    (size[0].max(size[1]) / FEWEST).max(1)
}

/// The camera of its images as large as points are followed in.
pub fn camera_at_working_size(camera: &CameraModel) -> CameraModel {
    camera.reduced(reduction(camera.size().map(|side| side as usize)))
}

/// A camera's image as large as points are followed in.
pub fn image_at_working_size(image: GrayImage) -> GrayImage {
    let times = reduction([image.width(), image.height()]);
    image.reduced(times)
}
