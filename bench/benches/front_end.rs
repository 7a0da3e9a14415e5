//! The whole visual front-end at 752 x 480, 150 tracks: CPU seconds for a second of images at 20 Hz. The same images and settings as
//! `golden/opencv_frontend/bench.py`.

use dpn_bench::frames::{COUNT, rolling};
use dpn_bench::{cpu_seconds, iterations};
use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use dpn_vio::frontend::{FrontEnd, FrontEndConfig, StageTimes};
use std::time::Duration;

fn main() {
    let default = FrontEndConfig::default();
    let mut plain = default;
    plain.klt.affine = false;
    plain.klt.back_px = 0.0;
    let mut shifted = default;
    shifted.klt.affine = false;
    let runs = iterations(10);
    let images = rolling(if runs == 1 { 6 } else { COUNT });
    for (name, config) in
        [("default", default), ("shifts only", shifted), ("shifts only, no way back", plain)]
    {
        measure(name, config, &images, runs);
    }
}

fn measure(name: &str, config: FrontEndConfig, images: &[GrayImage], runs: usize) {
    let Ok(mut front_end) = FrontEnd::new(CameraModel::euroc_cam0(), config, &Stream::new(1)) else {
        return;
    };
    let (mut frames, mut tracks, mut walls) = (0u32, 0, Vec::new());
    let mut stages = StageTimes::default();
    let mut feed = |i: usize, image: &GrayImage| {
        let t = Stamp::from_ns(50_000_000 * i as i64);
        front_end.feed(image.view(), t, None).report
    };
    // The first round, with everything new, does not count.
    images.iter().enumerate().for_each(|(i, image)| drop(feed(i, image)));
    let cpu = cpu_seconds();
    for round in 1..=runs {
        for (i, image) in images.iter().enumerate() {
            let report = feed(round * images.len() + i, image);
            frames += 1;
            tracks += report.kept;
            walls.push(report.times.total());
            stages.image += report.times.image;
            stages.track += report.times.track;
            stages.ransac += report.times.ransac;
            stages.corners += report.times.corners;
        }
    }
    let used = cpu.zip(cpu_seconds()).map_or(f64::NAN, |(from, to)| to - from);
    walls.sort();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let mean = |time: Duration| ms(time) / f64::from(frames);
    println!(
        "front_end {name}: median {:.3} ms a frame (image {:.3}, track {:.3}, ransac {:.3}, corners {:.3} in the mean), \
         cpu {:.4} s a second at 20 Hz, {:.0} tracks followed",
        walls.get(walls.len() / 2).map_or(f64::NAN, |wall| ms(*wall)),
        mean(stages.image),
        mean(stages.track),
        mean(stages.ransac),
        mean(stages.corners),
        20.0 * used / f64::from(frames),
        tracks as f64 / f64::from(frames),
    );
}
