//! The rendered camera at 752 x 480 on one core: an image along a flight through a room and through a hall, and the world it needs once.

use dpn_bench::{iterations, time};
use dpn_core::Stamp;
use dpn_sim::flight::FlightPlan;
use dpn_sim::render::{MotionBlurConfig, SharedPath};
use dpn_sim::tracks::AnalyticPath;
use dpn_sim::{Flight, RenderConfig, RenderedCamera};
use std::sync::Arc;

fn main() {
    let runs = iterations(100);
    let plain = RenderConfig::default();
    let blurred = RenderConfig {
        motion_blur: MotionBlurConfig { exposure_s: 0.005, ..MotionBlurConfig::default() },
        ..RenderConfig::default()
    };
    for (flight, name, config) in [
        (Flight::RoomMedium, "room", &plain),
        (Flight::HallLoops, "hall", &plain),
        (Flight::RoomMedium, "room, 5 ms of motion", &blurred),
    ] {
        let plan = FlightPlan::new(flight, 1);
        let path: SharedPath = Arc::new(AnalyticPath::new(plan.trajectory, Stamp::from_ns(0)));
        let Ok(mut camera) = RenderedCamera::new(config, path.clone(), 1) else { continue };
        // The camera's own rate, in flight.
        let mut frame = 0_i64;
        let timing = time(runs, || {
            let t = Stamp::from_ns(15_000_000_000 + 50_000_000 * frame);
            frame = (frame + 7) % 1000;
            std::hint::black_box(camera.image(t));
        });
        println!("render {name}: median {:.1} ms an image, cpu {:.1} ms", timing.wall_ms, timing.cpu_ms);
        let timing = time(runs.min(3), || drop(RenderedCamera::new(config, path.clone(), 2)));
        println!("render {name}: median {:.0} ms a world, cpu {:.0} ms", timing.wall_ms, timing.cpu_ms);
    }
}
