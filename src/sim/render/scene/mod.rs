//! The world that is rendered: rectangles with textures and light on them.

mod builder;
mod course;
mod hall;
mod layout;
mod light;
mod rect;

use super::texture::Atlas;
use crate::tracks::World;
pub(super) use course::Course;
use dpn_core::random::Stream;
use layout::Layout;
use nalgebra::Vector3;
pub(super) use rect::{LIGHT_TERMS, Rect};

/// A world: what there is, and its textures.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) rects: Vec<Rect>,
    pub(super) texels_per_m: f64,
    pub(super) atlas: Atlas,
}

impl Scene {
    /// The world around a flight on `course`.
    pub(super) fn new(course: &Course, world: World, [contrast, bare]: [f64; 2], stream: &Stream) -> Self {
        let layout = Layout::new(course, world, [contrast, bare], &mut stream.named("layout").rng());
        Self { rects: layout.rects, texels_per_m: layout.texels_per_m, atlas: Atlas::new(stream) }
    }

    /// The rectangle that is met first along `ray` from `eye`, and how far along, in lengths of `ray`.
    pub(super) fn hit(&self, eye: &Vector3<f64>, ray: &Vector3<f64>) -> Option<(usize, f64)> {
        let hits = self.rects.iter().enumerate().filter_map(|(i, rect)| Some((i, rect.hit(eye, ray)?)));
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
