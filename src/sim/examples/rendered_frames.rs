//! Renders a few frames of a sequence into a folder, to look at, and says how long one takes.
//!
//! `cargo run --release -p dpn-sim --example rendered_frames -- SEQUENCE OUT [FRAMES]`
#![allow(clippy::unwrap_used)]

use cpu_time::ThreadTime;
use dpn_io::asl::{Sequence, write_png};
use dpn_sim::RenderedCamera;
use dpn_sim::render::RenderConfig;
use dpn_sim::tracks::{CameraSettings, PathConfig, RecordedPath};
use std::path::Path;
use std::sync::Arc;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let sequence = Sequence::open(Path::new(&args[1])).unwrap();
    let out = Path::new(&args[2]);
    let count: usize = args.get(3).map_or(6, |n| n.parse().unwrap());
    let path = RecordedPath::new(&sequence.ground_truth().unwrap(), &PathConfig::default()).unwrap();
    let camera = sequence.camera_config().unwrap().map(|own| CameraSettings::try_from(&own).unwrap());
    let config = RenderConfig { camera, ..RenderConfig::default() };
    let start = ThreadTime::now();
    let mut camera = RenderedCamera::new(&config, Arc::new(path), 1).unwrap();
    println!("{camera:?} in {:.2} s", start.elapsed().as_secs_f64());
    let stamps: Vec<_> = sequence.camera_frames().unwrap().iter().map(|frame| frame.t).collect();
    let stamps: Vec<_> = stamps.into_iter().filter(|t| camera.takes(*t)).collect();
    for i in 0..count {
        let t = stamps[i * (stamps.len() - 1) / count.max(2).saturating_sub(1)];
        let image = camera.image(t).unwrap();
        // The second time the exposure is known and the memory there, as from frame to frame.
        let best = (0..5).map(|_| {
            let start = ThreadTime::now();
            camera.image(t).unwrap();
            start.elapsed().as_secs_f64()
        });
        println!("frame {i} at {} ns: {:.1} ms", t.ns(), 1e3 * best.fold(f64::MAX, f64::min));
        write_png(&out.join(format!("{i}.png")), image.view()).unwrap();
    }
}
