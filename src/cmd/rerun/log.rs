//! A recording as it grows.

use anyhow::Result;
use dpn_core::{GrayImage, Stamp};
use dpn_io::write_file;
use nalgebra::{Isometry3, Point3, Vector2, Vector3};
use re_sdk::sink::MemorySinkStorage;
use re_sdk::{AsComponents, RecordingStream, RecordingStreamBuilder, TimeCell};
use re_sdk_types::archetypes::{Image, LineStrips3D, Points2D, Points3D, Scalars, SeriesLines, Transform3D};
use re_sdk_types::datatypes::Quaternion;
use std::path::Path;

/// Colours of what is true and of what is estimated.
pub(super) const TRUE: [u8; 3] = [120, 120, 120];
pub(super) const ESTIMATED: [u8; 3] = [31, 119, 180];
/// Of x, y and z.
const AXES: [[u8; 3]; 3] = [[214, 39, 40], [44, 160, 44], [31, 119, 180]];
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Held in memory until it is written whole.
pub(super) struct RerunLog {
    stream: RecordingStream,
    storage: MemorySinkStorage,
    first: Stamp,
}

impl RerunLog {
    /// A recording called `name`, whose time is counted from `first`.
    pub(super) fn new(name: &str, first: Stamp) -> Result<Self> {
        let (stream, storage) = RecordingStreamBuilder::new("dpn").recording_name(name).memory()?;
        stream.set_log_time_enabled(false);
        Ok(Self { stream, storage, first })
    }

    /// What follows happens at `t`.
    pub(super) fn at(&self, t: Stamp) {
        let after_ns = t.ns().saturating_sub(self.first.ns());
        self.stream.set_time("time", TimeCell::from_duration_nanos(after_ns));
    }

    pub(super) fn put(&self, entity: &str, what: &impl AsComponents) -> Result<()> {
        Ok(self.stream.log(entity, what)?)
    }

    /// The same for all times.
    pub(super) fn always(&self, entity: &str, what: &impl AsComponents) -> Result<()> {
        Ok(self.stream.log_static(entity, what)?)
    }

    /// A line a name; [`RerunLog::numbers`] feeds them.
    pub(super) fn lines<'a>(&self, entity: &str, names: impl IntoIterator<Item = &'a str>) -> Result<()> {
        self.always(entity, &SeriesLines::new().with_names(names))
    }

    /// Three lines, x, y and z, in their colours.
    pub(super) fn axes(&self, entity: &str) -> Result<()> {
        self.always(entity, &SeriesLines::new().with_names(NAMES).with_colors(AXES))
    }

    pub(super) fn numbers(&self, entity: &str, values: &[f64]) -> Result<()> {
        self.put(entity, &Scalars::new(values.iter().copied()))
    }

    pub(super) fn pose(&self, entity: &str, pose: &Isometry3<f64>) -> Result<()> {
        self.put(entity, &transform(pose))
    }

    /// A way, as a whole.
    pub(super) fn path(&self, entity: &str, places: &[Vector3<f64>], colour: [u8; 3]) -> Result<()> {
        let strip: Vec<[f32; 3]> = places.iter().map(single).collect();
        self.always(entity, &LineStrips3D::new([strip]).with_colors([colour]))
    }

    pub(super) fn points(&self, entity: &str, points: &[Point3<f64>]) -> Result<()> {
        let places = points.iter().map(|point| single(&point.coords));
        self.put(entity, &Points3D::new(places).with_colors([ESTIMATED]))
    }

    pub(super) fn pixels(&self, entity: &str, pixels: impl IntoIterator<Item = Vector2<f64>>) -> Result<()> {
        let places = pixels.into_iter().map(|px| [px.x as f32, px.y as f32]);
        self.put(entity, &Points2D::new(places).with_radii([2.0_f32]).with_colors([[255_u8, 127, 14]]))
    }

    pub(super) fn image(&self, entity: &str, image: &GrayImage) -> Result<()> {
        let size = [image.width() as u32, image.height() as u32];
        self.put(entity, &Image::from_l8(image.pixels().to_vec(), size))
    }

    /// Writes the file, whole or not at all.
    pub(super) fn finish(self, path: &Path) -> Result<()> {
        let bytes = self.storage.drain_as_bytes()?;
        write_file(path, &bytes)?;
        Ok(())
    }
}

/// In the viewer's single precision.
pub(super) fn single(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

pub(super) fn quaternion(pose: &Isometry3<f64>) -> Quaternion {
    let q = pose.rotation.coords;
    Quaternion::from_xyzw([q.x as f32, q.y as f32, q.z as f32, q.w as f32])
}

pub(super) fn transform(pose: &Isometry3<f64>) -> Transform3D {
    Transform3D::from_translation_rotation(single(&pose.translation.vector), quaternion(pose))
}
