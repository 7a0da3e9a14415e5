//! 150 points from one real image of 752 x 480 to the next, 21 x 21 px, four levels, one way; and a pyramid.

use dpn_bench::frames::rolling;
use dpn_bench::{iterations, time};
use dpn_vio::frontend::corners::{CornerConfig, Detector, Mask};
use dpn_vio::frontend::image::{ImageStats, Pyramid};
use dpn_vio::frontend::klt::{Klt, KltConfig, Shift};
use std::hint::black_box;

fn main() {
    let images = rolling(3);
    let [first, second, ..] = &images[..] else { return };
    let pyramids = [first, second].map(|image| Pyramid::new(image.view(), 4));
    let mut mask = Mask::free(first.width(), first.height());
    let config = CornerConfig { cells: 0, ..CornerConfig::default() };
    let corners = Detector::new(config).detect(&pyramids[0].planes()[0], &mut mask, &[]);
    let shifts: Vec<Shift> = corners.iter().map(|c| Shift { from: c.px, guess: c.px }).collect();
    for affine in [false, true] {
        let klt = Klt::new(KltConfig { affine, ..KltConfig::default() });
        let timing = time(iterations(200), || {
            black_box(klt.track(&pyramids[0], &pyramids[1], &shifts, 4));
        });
        dpn_bench::keep(&format!("klt, affine {affine}, a point"), timing.wall_ms / shifts.len() as f64);
        println!(
            "klt, affine {affine}: {} points, median {:.3} ms, cpu {:.3} ms",
            shifts.len(),
            timing.wall_ms,
            timing.cpu_ms
        );
    }
    let timing = time(iterations(200), || {
        black_box(Pyramid::new(first.view(), 4));
    });
    dpn_bench::keep("pyramid of 4 levels", timing.wall_ms);
    println!("pyramid of 4 levels: median {:.3} ms, cpu {:.3} ms", timing.wall_ms, timing.cpu_ms);
    let timing = time(iterations(200), || {
        black_box(ImageStats::of(first.view()));
    });
    println!("figures of an image: median {:.3} ms, cpu {:.3} ms", timing.wall_ms, timing.cpu_ms);
}
