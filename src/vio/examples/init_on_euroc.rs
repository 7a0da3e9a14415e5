//! How soon and how well EuRoC's flights are initialised, from many moments of each: the hybrid benchmark's tracks, the real IMU.
//!
//! ```text
//! cargo run --release -p dpn-vio --example init_on_euroc -- [--noise 1,4] [--every 5] [--sequences MH_01,V1_02] [--tracks DIR] [--config JSON] [--list]
//! ```
//! Data: `$DPN_DATA` or `data/`. `--noise` multiplies .08 m/s^2 and .004 rad/s; `--config` takes keys of [`InitConfig`]; `--list` prints
//! every start.

use dpn_core::camera::CameraModel;
use dpn_core::geometry::so3;
use dpn_core::random::Stream;
use dpn_core::truth::GroundTruth;
use dpn_core::{ImuNoise, ImuRecording, Stamp, TrackFrame};
use dpn_io::asl;
use dpn_io::read_tracks;
use dpn_vio::ImuBias;
use dpn_vio::init::{InitConfig, InitFrame, InitOutcome, Initialised, Initialiser, WaitReason};
use dpn_vio::preint::{NoisySample, Preintegration, PreintegrationConfig};
use nalgebra::{Isometry3, Vector3};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the paper trains on; settings were chosen on these alone.
const TRAIN: [&str; 6] = ["MH_01", "MH_03", "MH_05", "V1_02", "V2_01", "V2_03"];
/// A start without an answer by then has none \[s\].
const PATIENCE_S: f64 = 30.0;

struct Flight {
    name: String,
    imu: ImuRecording,
    frames: Vec<TrackFrame>,
    truth: GroundTruth,
    camera: CameraModel,
    body_from_cam: Isometry3<f64>,
}

struct Run {
    start: f64,
    /// Since the start \[s\].
    waited: f64,
    /// Since the first motion after the start \[s\].
    waited_in_motion: f64,
    scale: f64,
    tilt_deg: f64,
    velocity: f64,
    speed: f64,
    spread: f64,
    found: Initialised,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let value = |flag: &str| args.iter().position(|a| a == flag).and_then(|at| args.get(at + 1)).cloned();
    let root = std::env::var("DPN_DATA").map_or_else(|_| PathBuf::from("data"), PathBuf::from);
    let every: f64 = value("--every").map_or(Ok(5.0), |v| v.parse())?;
    let tracks = value("--tracks").map_or_else(|| root.join("tracks"), PathBuf::from);
    let noises: Vec<f64> = value("--noise")
        .unwrap_or_else(|| "1,4".into())
        .split(',')
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let only: Option<Vec<String>> = value("--sequences").map(|v| v.split(',').map(String::from).collect());
    let config: InitConfig =
        value("--config").map_or_else(|| Ok(InitConfig::default()), |v| serde_json::from_str(&v))?;
    for noise in noises {
        println!("noise x{noise}");
        println!(
            "{:<6} {:>5} {:>5} | {:>5} {:>5} {:>5} | {:>6} {:>6} {:>6} | {:>5} {:>5} | {:>5} {:>5} {:>6}",
            "",
            "runs",
            "none",
            "wait",
            "p90",
            "max",
            "scale%",
            "p90",
            "max",
            ">10%",
            ">30%",
            "tilt",
            "vel",
            "ms/try"
        );
        let mut all = (Vec::new(), 0);
        for sequence in asl::discover(&root.join("euroc"))? {
            let name = short(&sequence);
            if only.as_ref().is_some_and(|o| !o.contains(&name)) {
                continue;
            }
            let flight = load(&sequence, &tracks)?;
            let mut runs = Vec::new();
            let (mut none, mut seconds, mut tries) = (0, 0.0, 0);
            let last = flight.frames[flight.frames.len() - 1].t;
            let mut start = 0.0;
            while last.seconds_since(flight.frames[0].t) - start > 10.0 {
                let clock = Instant::now();
                let mut reasons = BTreeMap::new();
                let (run, count) = run(&flight, start, noise, &config, &mut reasons)?;
                seconds += clock.elapsed().as_secs_f64();
                tries += count;
                if args.iter().any(|a| a == "--list") {
                    list(&flight, start, run.as_ref(), &reasons);
                }
                match run {
                    Some(run) => runs.push(run),
                    None => none += 1,
                }
                start += every;
            }
            let mark = if TRAIN.contains(&name.as_str()) { "" } else { "*" };
            summary(&format!("{name}{mark}"), &runs, none, 1e3 * seconds / f64::from(tries.max(1)));
            all.0.extend(runs);
            all.1 += none;
        }
        summary("all", &all.0, all.1, f64::NAN);
        honesty(&all.0);
    }
    println!("* not trained on");
    Ok(())
}

/// `MH_01` of `MH_01_easy`.
fn short(sequence: &asl::Sequence) -> String {
    sequence.name().chars().take(5).collect()
}

fn load(sequence: &asl::Sequence, tracks: &Path) -> Result<Flight, Box<dyn Error>> {
    let config = sequence.camera_config()?.ok_or("no camera configuration")?;
    let file = tracks.join(format!("{}.txt", sequence.name()));
    Ok(Flight {
        name: short(sequence),
        imu: sequence.imu()?,
        frames: read_tracks(&file)?,
        truth: sequence.ground_truth()?,
        camera: CameraModel::try_from(&config)?,
        body_from_cam: config.body_from_cam,
    })
}

/// Feeds the flight from `start` on until an answer comes; also the number of frames that were looked at.
fn run(
    flight: &Flight,
    start: f64,
    factor: f64,
    config: &InitConfig,
    reasons: &mut BTreeMap<&'static str, usize>,
) -> Result<(Option<Run>, u32), Box<dyn Error>> {
    let noise = ImuNoise::from_values([0.08 * factor; 3], [0.004 * factor; 3])?;
    let begin = flight.frames[0].t.plus_seconds(start);
    let mut init = Initialiser::new(config.clone(), flight.body_from_cam, Stream::new(1))
        .map_err(|faults| format!("{faults:?}"))?;
    let mut previous: Option<Stamp> = None;
    let mut first = None;
    let mut tries = 0;
    for frame in flight.frames.iter().filter(|f| f.t >= begin) {
        let first = *first.get_or_insert(frame.t);
        if frame.t.seconds_since(first) > PATIENCE_S {
            break;
        }
        let bearings = frame.tracks.iter().filter_map(|t| Some((t.id, flight.camera.bearing(&t.px)?)));
        let preint = previous.and_then(|from| between(&flight.imu, from, frame.t, noise));
        previous = Some(frame.t);
        tries += 1;
        match init.push_frame(InitFrame::new(frame.t, bearings.collect()), preint) {
            InitOutcome::Wait(reason) => {
                *reasons.entry(reason.name()).or_default() += 1;
                if let (true, WaitReason::Implausible { .. }) = (std::env::var("VERBOSE").is_ok(), &reason) {
                    println!("      {reason}");
                }
            }
            InitOutcome::Ready(found) => {
                let moved = first_motion(&flight.truth, first);
                return Ok((Some(judge(flight, start, first, moved, *found)), tries));
            }
        }
    }
    Ok((None, tries))
}

/// The samples from one frame to the next.
fn between(imu: &ImuRecording, from: Stamp, to: Stamp, noise: ImuNoise) -> Option<Preintegration> {
    let samples = imu.samples();
    let begin = samples.partition_point(|s| s.t < from);
    let mut inside = samples[begin..].iter().take_while(|s| s.t <= to);
    let first = NoisySample { sample: *inside.next()?, noise };
    let mut preint = Preintegration::new(PreintegrationConfig::default(), ImuBias::zero(), first);
    inside.for_each(|sample| preint.push(NoisySample { sample: *sample, noise }));
    Some(preint)
}

/// The true pose at an instant, between two states of the ground truth.
fn true_pose(truth: &GroundTruth, t: Stamp) -> Isometry3<f64> {
    let states = truth.states();
    let after = states.partition_point(|s| s.t < t).clamp(1, states.len() - 1);
    let (a, b) = (&states[after - 1], &states[after]);
    let share = (t.seconds_since(a.t) / b.t.seconds_since(a.t)).clamp(0.0, 1.0);
    let (pose_a, pose_b) = (a.world_from_body, b.world_from_body);
    let turn = so3::log(&(pose_a.rotation.inverse() * pose_b.rotation));
    Isometry3::from_parts(
        (pose_a.translation.vector * (1.0 - share) + pose_b.translation.vector * share).into(),
        pose_a.rotation * so3::exp(&(turn * share)),
    )
}

/// The first instant after `from` at which the body is 2 cm or 1 degree off.
fn first_motion(truth: &GroundTruth, from: Stamp) -> Stamp {
    let origin = true_pose(truth, from);
    truth
        .states()
        .iter()
        .find(|s| {
            s.t > from
                && ((s.world_from_body.translation.vector - origin.translation.vector).norm() > 0.02
                    || s.world_from_body.rotation.angle_to(&origin.rotation) > 0.0175)
        })
        .map_or(from, |s| s.t)
}

fn judge(flight: &Flight, start: f64, first: Stamp, moved: Stamp, found: Initialised) -> Run {
    let truth: Vec<_> = found.frames.iter().map(|f| true_pose(&flight.truth, f.t)).collect();
    let estimate: Vec<_> = found.frames.iter().map(|f| f.state.world_from_body).collect();
    let spread = |poses: &[Isometry3<f64>]| {
        let mean = poses.iter().map(|p| p.translation.vector).sum::<Vector3<f64>>() / poses.len() as f64;
        (poses.iter().map(|p| (p.translation.vector - mean).norm_squared()).sum::<f64>() / poses.len() as f64)
            .sqrt()
    };
    let newest = found.frames[found.frames.len() - 1];
    let (t, pose) = (newest.t, truth[truth.len() - 1]);
    let h = 0.05;
    let velocity = (true_pose(&flight.truth, t.plus_seconds(h)).translation.vector
        - true_pose(&flight.truth, t.plus_seconds(-h)).translation.vector)
        / (2.0 * h);
    let up = |p: &Isometry3<f64>| p.rotation.inverse() * Vector3::z();
    let in_body = newest.state.world_from_body.rotation.inverse() * newest.state.vel_in_world;
    Run {
        start,
        waited: t.seconds_since(first),
        waited_in_motion: t.seconds_since(moved.min(t)),
        scale: spread(&estimate) / spread(&truth),
        tilt_deg: up(&newest.state.world_from_body).angle(&up(&pose)).to_degrees(),
        velocity: (in_body - pose.rotation.inverse() * velocity).norm(),
        speed: velocity.norm(),
        spread: spread(&truth),
        found,
    }
}

fn list(flight: &Flight, start: f64, run: Option<&Run>, reasons: &BTreeMap<&'static str, usize>) {
    let Some(r) = run else {
        println!("  {} from {start:5.1} s: none; {reasons:?}", flight.name);
        return;
    };
    println!(
        "  {} from {:5.1} s: after {:4.1} s ({:4.1} in motion, {:3.1} s long{}), scale {:+6.1} % (says {:4.1} %), tilt {:4.2} deg (says {:.2}), velocity off {:.3} of {:.2} m/s, spread {:.2} m, ba {:.2} bg {:.3}, track {:.2} px, gyro x{:.2}, accel x{:.2}; {reasons:?}",
        flight.name,
        r.start,
        r.waited,
        r.waited_in_motion,
        r.found.frames[r.found.frames.len() - 1].t.seconds_since(r.found.frames[0].t),
        if r.found.from_rest { ", rest" } else { "" },
        100.0 * (r.scale - 1.0),
        100.0 * r.found.scale_std,
        r.tilt_deg,
        r.found.gravity_std.to_degrees(),
        r.velocity,
        r.speed,
        r.spread,
        r.found.bias.accel.norm(),
        r.found.bias.gyro.norm(),
        r.found.fit.track_std_px,
        r.found.fit.gyro_factor,
        r.found.fit.accel_factor,
    );
}

fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
}

fn summary(name: &str, runs: &[Run], none: usize, ms: f64) {
    let of = |f: &dyn Fn(&Run) -> f64, share| quantile(runs.iter().map(f).collect(), share);
    let scale = |r: &Run| 100.0 * r.scale.ln().abs();
    println!(
        "{name:<6} {:>5} {none:>5} | {:>5.1} {:>5.1} {:>5.1} | {:>6.1} {:>6.1} {:>6.1} | {:>5} {:>5} | {:>5.2} {:>5.3} {:>6.1}",
        runs.len(),
        of(&|r| r.waited_in_motion, 0.5),
        of(&|r| r.waited_in_motion, 0.9),
        of(&|r| r.waited_in_motion, 1.0),
        of(&scale, 0.5),
        of(&scale, 0.9),
        of(&scale, 1.0),
        runs.iter().filter(|r| (r.scale - 1.0).abs() > 0.1).count(),
        runs.iter().filter(|r| (r.scale - 1.0).abs() > 0.3).count(),
        of(&|r| r.tilt_deg, 0.5),
        of(&|r| r.velocity, 0.5),
        ms,
    );
}

/// Whether the scale's error is as large as the estimate says.
fn honesty(runs: &[Run]) {
    let squares = runs.iter().map(|r| (r.scale.ln() / r.found.scale_std).powi(2)).collect::<Vec<_>>();
    let tilts =
        runs.iter().map(|r| (r.tilt_deg.to_radians() / r.found.gravity_std).powi(2)).collect::<Vec<_>>();
    println!(
        "       scale error over its deviation: rms {:.2}, median of squares {:.2} (.45 if honest); tilt likewise: median of squares {:.2} (1.4)",
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
        quantile(squares, 0.5),
        quantile(tilts, 0.5),
    );
}
