//! 150 corners of a real image of 752 x 480, 30 px apart.

use dpn_bench::frames::rolling;
use dpn_bench::{iterations, time};
use dpn_vio::frontend::corners::{CornerConfig, Detector, Mask};
use dpn_vio::frontend::image::Plane;
use std::hint::black_box;

fn main() {
    let images = rolling(1);
    let [image] = &images[..] else { return };
    let plane = Plane::new(image.view());
    for cells in [0, 8] {
        let mut detector = Detector::new(CornerConfig { cells, ..CornerConfig::default() });
        let mut mask = Mask::default();
        let mut found = 0;
        let timing = time(iterations(200), || {
            mask.reset(image.width(), image.height(), None);
            found = black_box(detector.detect(&plane, &mut mask, &[])).len();
        });
        dpn_bench::keep(&format!("corners, {cells} cells"), timing.wall_ms);
        println!(
            "corners, {cells} cells: {found}, median {:.3} ms, cpu {:.3} ms",
            timing.wall_ms, timing.cpu_ms
        );
    }
}
