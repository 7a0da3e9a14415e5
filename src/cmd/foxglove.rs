//! `dpn run --mcap`: the run as a log that Foxglove shows without a plugin: its own schemas, in JSON.
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransform` | `world` to `body` at every frame; `truth` to `world`, yaw and position aligned, once |
//! | `/estimate`, `/truth` | `foxglove.PoseInFrame` | poses |
//! | `/estimate/path`, `/truth/path` | `foxglove.PosesInFrame` | all of them, in the first message |
//! | `/sigma` | `dpn.Sigma` | noise in force \[m/s^2, rad/s\] |
//! | `/state` | `dpn.State` | velocity, biases, believed deviations of the pose, levels |

use anyhow::Result;
use dpn_core::trajectory::StampedPose;
use dpn_core::{NoiseTrack, Sensor, Stamp};
use dpn_eval::closed_loop::{JudgedRun, Recording};
use dpn_io::atomic_write;
use dpn_logs::McapLog;
use dpn_vio::estimator::Update;
use nalgebra::{Isometry3, Vector3};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;

/// Noise goes into the log so often \[s\].
const SIGMA_EVERY_S: f64 = 0.05;

/// Writes the log; `truth_from_world` is where the estimate's world lies in the truth's.
pub(super) fn write(
    path: &Path,
    recording: &Recording,
    done: &JudgedRun,
    truth_from_world: Option<&Isometry3<f64>>,
) -> Result<()> {
    atomic_write(path, |out| log(out, recording, done, truth_from_world))?;
    Ok(())
}

fn log(
    out: &mut dyn Write,
    recording: &Recording,
    done: &JudgedRun,
    truth_from_world: Option<&Isometry3<f64>>,
) -> io::Result<()> {
    let mut log = McapLog::new(out, "")?;
    let poses = done.output.poses();
    let tf = channel(&mut log, "/tf", "foxglove.FrameTransform")?;
    let (Some(first), Some(last)) = (done.output.frames.first(), done.output.frames.last()) else {
        return log.finish();
    };
    if let Some(pose) = truth_from_world {
        put(&mut log, tf, *first, &transform(*first, "truth", "world", pose))?;
    }
    let truth: Vec<StampedPose> = recording.truth.iter().flatten().copied().collect();
    let under: Vec<StampedPose> =
        truth.into_iter().filter(|pose| (*first..=*last).contains(&pose.t)).collect();
    for (topic, frame, poses) in [("/estimate", "world", &poses), ("/truth", "truth", &under)] {
        let Some(first) = poses.first() else { continue };
        let path = channel(&mut log, &format!("{topic}/path"), "foxglove.PosesInFrame")?;
        let all: Vec<Value> = poses.iter().map(|pose| pose_json(&pose.world_from_body)).collect();
        put(
            &mut log,
            path,
            first.t,
            &json!({ "timestamp": time(first.t), "frame_id": frame, "poses": all }),
        )?;
        let one = channel(&mut log, topic, "foxglove.PoseInFrame")?;
        for pose in poses {
            let value = pose_json(&pose.world_from_body);
            put(
                &mut log,
                one,
                pose.t,
                &json!({ "timestamp": time(pose.t), "frame_id": frame, "pose": value }),
            )?;
        }
    }
    for pose in &poses {
        put(&mut log, tf, pose.t, &transform(pose.t, "world", "body", &pose.world_from_body))?;
    }
    let state = channel(&mut log, "/state", "dpn.State")?;
    for update in &done.output.updates {
        put(&mut log, state, update.t, &state_json(update))?;
    }
    sigmas(&mut log, &done.noise, *first..=*last)?;
    log.finish()
}

fn sigmas(
    log: &mut McapLog<&mut dyn Write>,
    noise: &NoiseTrack,
    span: std::ops::RangeInclusive<Stamp>,
) -> io::Result<()> {
    let channel = channel(log, "/sigma", "dpn.Sigma")?;
    let mut last: Option<Stamp> = None;
    for (t, noise) in noise.stamps().iter().zip(noise.noises()) {
        let due = last.is_none_or(|last| t.seconds_since(last) >= SIGMA_EVERY_S);
        if span.contains(t) && due {
            let [accel, gyro] = [Sensor::Accel, Sensor::Gyro].map(|sensor| vector(&noise.of(sensor).into()));
            put(log, channel, *t, &json!({ "timestamp": time(*t), "accel": accel, "gyro": gyro }))?;
            last = Some(*t);
        }
    }
    Ok(())
}

fn put(log: &mut McapLog<&mut dyn Write>, channel: u16, t: Stamp, value: &Value) -> io::Result<()> {
    log.message(channel, t, value.to_string().as_bytes())
}

fn time(t: Stamp) -> Value {
    json!({ "sec": t.ns().div_euclid(1_000_000_000), "nsec": t.ns().rem_euclid(1_000_000_000) })
}

fn vector(v: &Vector3<f64>) -> Value {
    json!({ "x": v.x, "y": v.y, "z": v.z })
}

fn rotation_json(pose: &Isometry3<f64>) -> Value {
    let q = pose.rotation.coords;
    json!({ "x": q.x, "y": q.y, "z": q.z, "w": q.w })
}

fn pose_json(pose: &Isometry3<f64>) -> Value {
    json!({ "position": vector(&pose.translation.vector), "orientation": rotation_json(pose) })
}

fn transform(t: Stamp, parent: &str, child: &str, pose: &Isometry3<f64>) -> Value {
    json!({
        "timestamp": time(t), "parent_frame_id": parent, "child_frame_id": child,
        "translation": vector(&pose.translation.vector), "rotation": rotation_json(pose),
    })
}

fn state_json(update: &Update) -> Value {
    let mut value = json!({
        "timestamp": time(update.t), "tracked": update.tracked, "landmarks": update.landmarks, "outliers": update.outliers,
    });
    if let Some(state) = &update.state {
        value["velocity"] = vector(&state.vel_in_world);
        value["accel_bias"] = vector(&state.bias.accel);
        value["gyro_bias"] = vector(&state.bias.gyro);
    }
    if let Some(covariance) = &update.covariance {
        let std = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        value["position_std"] = vector(&std.fixed_rows::<3>(0).into_owned());
        value["rotation_std"] = vector(&std.fixed_rows::<3>(3).into_owned());
    }
    if let Some(levels) = &update.levels {
        value["levels"] = json!({ "inertial": levels.inertial.0, "pixel": levels.pixel });
    }
    value
}

/// A channel of JSON in one of the schemas beside this file.
fn channel(log: &mut McapLog<&mut dyn Write>, topic: &str, schema: &str) -> io::Result<u16> {
    let all: Value = serde_json::from_str(include_str!("foxglove_schemas.json")).expect("it is JSON");
    log.json_channel(topic, schema, &all[schema].to_string())
}
