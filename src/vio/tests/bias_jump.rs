//! Biases that jump in flight, at a known time, by a known change: found within a second, no run lost, poses as good as before.

use dpn_core::camera::CameraModel;
use dpn_core::{ImuNoise, ImuSample, SampleRate, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_vio::components::ComponentsConfig;
use dpn_vio::estimator::{Phase, Update};
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use std::sync::OnceLock;

struct Case {
    flight: SimulatedFlight,
    frames: Vec<TrackFrame>,
}

fn make(kind: Flight, seed: u64, vibration: f64) -> Case {
    let mut config = FlightConfig::default();
    config.vibration.scale = vibration;
    let flight = simulate(kind, seed, &config).unwrap();
    let path = AnalyticPath::of(&flight);
    let stamps = camera_stamps(&path, SampleRate::from_hz(10.0).unwrap());
    let mut frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, seed).unwrap();
    let end = frames[0].t.plus_seconds(45.0);
    frames.retain(|f| f.t <= end);
    Case { flight, frames }
}

fn calm() -> &'static Case {
    static CASE: OnceLock<Case> = OnceLock::new();
    CASE.get_or_init(|| make(Flight::RoomMedium, 3, 0.0))
}

/// Seconds after the first frame.
const JUMP: f64 = 25.0;

fn run(case: &Case, noise: [f64; 2], learn: bool, accel: f64, gyro: f64) -> Vec<Update> {
    let config = EstimatorConfig { components: learn.then(ComponentsConfig::default), ..Default::default() };
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    let mut estimator =
        Estimator::new(config, CameraModel::euroc_cam0(), body_from_cam, "flight", 1).unwrap();
    let noise = ImuNoise::from_values([noise[0]; 3], [noise[1]; 3]).unwrap();
    let mut left = case.flight.recording.samples().iter().peekable();
    let start = case.frames[0].t;
    let mut updates = Vec::new();
    for frame in &case.frames {
        while let Some(sample) = left.next_if(|s| s.t <= frame.t.plus_seconds(0.006)) {
            let mut sample: ImuSample = *sample;
            if sample.t.seconds_since(start) > JUMP {
                sample.accel = sample.accel.map(|a| a + accel);
                sample.gyro = sample.gyro.map(|w| w + gyro);
            }
            estimator.feed_imu(NoisySample { sample, noise }).unwrap();
        }
        estimator.feed_frame(frame.clone()).unwrap();
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    updates
}

#[test]
#[ignore = "looks on"]
fn look_on() {
    for vibration in [0.0, 1.0] {
        let case = make(Flight::RoomMedium, 3, vibration);
        let start = case.frames[0].t;
        for (name, noise, learn) in [("x1", [0.08, 0.004], false), ("x4", [0.32, 0.016], false), ("self", [0.08, 0.004], true)] {
            for (a, g) in [(0.0, 0.0), (0.2, 0.02), (0.5, 0.05), (1.0, 0.1), (2.0, 0.1), (2.0, 0.0), (0.0, 0.1), (0.2, 0.0), (0.0, 0.02)] {
                eprintln!("== vibration {vibration} {name} {a} {g}");
                let updates = run(&case, noise, learn, a, g);
                for u in &updates {
                    if let Phase::Restarted(reason) = u.phase {
                        eprintln!("restart {:.2} {reason}", u.t.seconds_since(start));
                    }
                    if let Some(jump) = u.jump {
                        eprintln!("jump at {:.2} {:?} a {:.3?} g {:.4?}", u.t.seconds_since(start), jump.between.map(|t| t.seconds_since(start)), jump.accel, jump.gyro);
                    }
                }
                let last = updates.last().unwrap();
                if let Some(state) = last.state {
                    eprintln!("end a {:.3?} g {:.4?} levels {:.2?}", state.bias.accel.as_slice(), state.bias.gyro.as_slice(), last.levels);
                }
            }
        }
    }
}
