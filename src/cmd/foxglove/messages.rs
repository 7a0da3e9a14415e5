//! The messages, in Foxglove's own schemas and ours, in JSON; and who shows them while a run goes on.

use data_encoding::BASE64;
use dpn_core::{GrayImage, ImuNoise, Sensor, Stamp, TrackFrame};
use dpn_io::asl::png;
use dpn_vio::estimator::{FrontEndObserver, Update};
use nalgebra::{Isometry3, Vector3};
use serde_json::{Value, json};
use std::io;

/// Who looks on at a live run. Nothing of it makes the run wait.
pub(in crate::cmd) trait Onlooker: FrontEndObserver {
    /// Shows what a frame gave, and the noise in force; `image` is its image's stamp as it was fed, and the time since it came \[s\].
    fn show(&mut self, frame: (Stamp, &Update), noise: Option<ImuNoise>, image: Option<(Stamp, f64)>);

    /// Nothing more comes; how many messages were dropped.
    fn finish(self: Box<Self>) -> u64;
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Topic {
    Tf,
    Estimate,
    EstimatePath,
    Truth,
    TruthPath,
    Image,
    Tracks,
    Sigma,
    State,
}

impl Topic {
    /// The topic's name and its schema's.
    pub(super) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Tf => ("/tf", "foxglove.FrameTransform"),
            Self::Estimate => ("/estimate", "foxglove.PoseInFrame"),
            Self::EstimatePath => ("/estimate/path", "foxglove.PosesInFrame"),
            Self::Truth => ("/truth", "foxglove.PoseInFrame"),
            Self::TruthPath => ("/truth/path", "foxglove.PosesInFrame"),
            Self::Image => ("/camera/image", "foxglove.CompressedImage"),
            Self::Tracks => ("/camera/tracks", "foxglove.ImageAnnotations"),
            Self::Sigma => ("/sigma", "dpn.Sigma"),
            Self::State => ("/state", "dpn.State"),
        }
    }

    /// The schema, one of those beside this file.
    pub(super) fn schema(self) -> String {
        let all: Value = serde_json::from_str(include_str!("schemas.json")).expect("it is JSON");
        all[self.names().1].to_string()
    }
}

/// What a frame gave: pose, transform, state; `latency_s` is the time from its image's arrival.
pub(super) fn of_update(t: Stamp, update: &Update, latency_s: Option<f64>) -> Vec<(Topic, Value)> {
    let mut messages = Vec::new();
    if let Some(state) = &update.state {
        messages.push((Topic::Estimate, pose_in(t, "world", &state.world_from_body)));
        messages.push((Topic::Tf, transform(t, "world", "body", &state.world_from_body)));
    }
    messages.push((Topic::State, state_json(t, update, latency_s)));
    messages
}

pub(super) fn pose_in(t: Stamp, frame: &str, pose: &Isometry3<f64>) -> Value {
    json!({ "timestamp": time(t), "frame_id": frame, "pose": pose_json(pose) })
}

pub(super) fn path<'a>(t: Stamp, frame: &str, poses: impl Iterator<Item = &'a Isometry3<f64>>) -> Value {
    json!({ "timestamp": time(t), "frame_id": frame, "poses": poses.map(pose_json).collect::<Vec<_>>() })
}

pub(super) fn transform(t: Stamp, parent: &str, child: &str, pose: &Isometry3<f64>) -> Value {
    json!({
        "timestamp": time(t), "parent_frame_id": parent, "child_frame_id": child,
        "translation": vector(&pose.translation.vector), "rotation": rotation_json(pose),
    })
}

pub(super) fn image(t: Stamp, image: &GrayImage) -> io::Result<Value> {
    let data = BASE64.encode(&png(image.view())?);
    Ok(json!({ "timestamp": time(t), "frame_id": "camera", "data": data, "format": "png" }))
}

/// The points followed in an image; type 1 of annotations is each point by itself.
pub(super) fn tracks(t: Stamp, frame: &TrackFrame) -> Value {
    let points: Vec<Value> =
        frame.tracks.iter().map(|track| json!({ "x": track.px.x, "y": track.px.y })).collect();
    let green = json!({ "r": 0.2, "g": 1.0, "b": 0.2, "a": 1.0 });
    let all = json!({ "timestamp": time(t), "type": 1, "points": points, "outline_color": green, "thickness": 4.0 });
    json!({ "circles": [], "points": [all], "texts": [] })
}

pub(super) fn sigma(t: Stamp, noise: &ImuNoise) -> Value {
    let [accel, gyro] = [Sensor::Accel, Sensor::Gyro].map(|sensor| vector(&noise.of(sensor).into()));
    json!({ "timestamp": time(t), "accel": accel, "gyro": gyro })
}

fn state_json(t: Stamp, update: &Update, latency_s: Option<f64>) -> Value {
    let mut value = json!({
        "timestamp": time(t), "tracked": update.tracked, "landmarks": update.landmarks, "outliers": update.outliers,
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
    if let Some(std) = update.scale_std {
        value["scale_std"] = std.into();
    }
    if let Some(levels) = &update.levels {
        value["levels"] = json!({ "inertial": levels.inertial.0, "pixel": levels.pixel });
    }
    if let Some(seconds) = latency_s {
        value["latency_ms"] = (1e3 * seconds).into();
    }
    value
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

/// Whether `every_s` have passed since the `last` that was kept, which this one then is.
pub(in crate::cmd) fn is_due(last: &mut Option<Stamp>, t: Stamp, every_s: f64) -> bool {
    // A microsecond for stamps that were rounded.
    let due = last.is_none_or(|last| t.seconds_since(last) >= every_s - 1e-6);
    if due {
        *last = Some(t);
    }
    due
}
