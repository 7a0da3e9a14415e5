//! The sliding window on a simulated flight: one solve, one slide, one factorisation of its normal equations, one whole frame; one thread.

use dpn_bench::{iterations, time};
use dpn_core::camera::CameraModel;
use dpn_core::{ImuNoise, SampleRate};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, simulate};
use dpn_vio::preint::NoisySample;
use dpn_vio::window::normal::{Factor, Normal};
use dpn_vio::window::{Leaving, Window};
use dpn_vio::{Estimator, EstimatorConfig};
use std::hint::black_box;

fn main() {
    let flight = simulate(Flight::RoomMedium, 1, &FlightConfig::default()).expect("a flight of the program");
    let path = AnalyticPath::of(&flight);
    let stamps = camera_stamps(&path, SampleRate::from_hz(20.0).expect("positive"));
    let frames =
        simulate_tracks(&TracksConfig::default(), &path, &stamps, 1).expect("the defaults are valid");
    let body_from_cam = CameraSettings::default().body_from_cam().expect("the default is a rotation");
    let config = EstimatorConfig::default();
    let mut estimator =
        Estimator::new(config, CameraModel::euroc_cam0(), body_from_cam, 1).expect("the defaults are valid");
    for sample in flight.recording.samples() {
        let noise = ImuNoise::baseline();
        estimator.feed_imu(NoisySample { sample: *sample, noise }).expect("in order");
    }
    let mut seconds = Vec::new();
    let mut full: Option<Window> = None;
    for frame in frames {
        estimator.feed_frame(frame).expect("in order");
        while let Some(update) = estimator.next_update() {
            if update.iterations > 0 {
                seconds.push(update.seconds * 1e3);
            }
        }
        // The window after a slide; its frames hold what one solve and one slide work on.
        if seconds.len() == 200 {
            full = Some(estimator.window().clone());
        }
    }
    seconds.sort_by(f64::total_cmp);
    let at = |share: f64| seconds.get((seconds.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN);
    dpn_bench::keep("window, a frame", at(0.5));
    println!(
        "one frame, all of it: median {:.2} ms, 95 % {:.2} ms of {} frames",
        at(0.5),
        at(0.95),
        seconds.len()
    );

    if let Some(window) = full {
        report("solve, from the solution", || {
            black_box(window.clone().optimise());
        });
        report("marginalise and slide", || {
            black_box(window.clone().slide(Leaving::Oldest));
        });
        report("copy of the window (in both above)", || {
            black_box(window.clone());
        });
    }
    let normal = envelope(11);
    let mut factor = Factor::default();
    report("factor and solve 165 unknowns", || {
        normal.factor(|_| 0.0, &mut factor).expect("positive definite");
        let mut step = normal.gradient().to_vec();
        factor.solve_negated(&mut step);
        black_box(step);
    });
}

/// A positive definite system of the window's shape: motion blocks tied to neighbours and poses, poses all tied.
fn envelope(frames: usize) -> Normal {
    let layout = dpn_vio::window::layout::Layout { frames, extrinsics: false, time_offset: false };
    let mut normal = Normal::zeros(layout.dim());
    for j in 0..frames {
        for i in j.saturating_sub(1)..=j {
            for r in layout.frame_places(j) {
                for c in layout.frame_places(i).filter(|c| *c < r) {
                    normal.add(r, c, 0.01 / (1.0 + (r + c) as f64));
                }
            }
        }
        for r in layout.pose(j)..layout.pose(j) + 6 {
            for c in layout.pose(0)..r {
                normal.add(r, c, 0.01 / (2.0 + (r - c) as f64));
            }
        }
        for r in layout.frame_places(j) {
            normal.add(r, r, 1.0);
            normal.gradient_mut()[r] = 1.0 / (1.0 + r as f64);
        }
    }
    normal
}

fn report(what: &str, work: impl FnMut()) {
    let timing = time(iterations(300), work);
    dpn_bench::keep(&format!("window, {what}"), timing.wall_ms);
    println!("{what}: median {:.1} us, CPU {:.1} us", timing.wall_ms * 1e3, timing.cpu_ms * 1e3);
}
