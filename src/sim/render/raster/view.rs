//! A world's rectangles as a camera sees them from one pose, and which of them each tile may show.
//!
//! With the line of sight r = (x, y, 1) and a rectangle's origin p, unit vectors e, f, normal n, the eye at c and h = n . (c - p):
//!
//! ```text
//! w = 1/depth = -(n . R r) / h        linear in r
//! u w = e . (c - p) w + e . R r       linear in r, v alike
//! ```
//!
//! so that 0 <= u <= U is two linear inequalities, the nearest surface is the one with the largest w, and one division a pixel is
//! all that perspective costs. R turns the camera's frame into the world's. A pixel is exact to rounding: nothing is interpolated.

use super::super::scene::{LIGHT_TERMS, Rect, Scene};
use super::lens::{Cone, Lens};
use nalgebra::{Isometry3, Vector3};
use std::ops::Range;

/// An eye closer than this to a rectangle's plane does not see it \[m\].
const GRAZING_M: f64 = 1e-5;

/// Coefficients of x, y, 1.
pub(crate) type Linear = [f32; 3];

/// A rectangle in a camera's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    /// 1/depth \[1/m\].
    pub(crate) near: Linear,
    /// u and v over depth \[texels/m\].
    pub(crate) u: Linear,
    pub(crate) v: Linear,
    /// Not negative inside the rectangle.
    pub(crate) edges: [Linear; 4],
    /// The texture's place and its texel at u = v = 0.
    pub(crate) base: u32,
    pub(crate) offset: [f32; 2],
    pub(crate) light: [f32; LIGHT_TERMS],
    /// Grey at unit light = `gain * texture + lift`.
    pub(crate) gain: f32,
    pub(crate) lift: f32,
}

impl Facet {
    /// `None` where the rectangle is seen from behind.
    pub(super) fn new(rect: &Rect, texels_per_m: f64, world_from_cam: &Isometry3<f64>) -> Option<Self> {
        let texels_per_m = texels_per_m * rect.skin.fineness;
        let turn = &world_from_cam.rotation;
        let from_origin = world_from_cam.translation.vector - rect.origin;
        let normal = rect.normal();
        let height = normal.dot(&from_origin);
        if height < GRAZING_M {
            return None;
        }
        let into = |v: &Vector3<f64>| turn.inverse_transform_vector(v);
        let near = -into(&normal) / height;
        let of = |axis: &Vector3<f64>| (from_origin.dot(axis) * near + into(axis)) * texels_per_m;
        let (u, v) = (of(&rect.across), of(&rect.along));
        let [width, height] = rect.size.map(|side| side * texels_per_m);
        let linear = |v: Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let skin = &rect.skin;
        Some(Self {
            near: linear(near),
            u: linear(u),
            v: linear(v),
            edges: [linear(u), linear(width * near - u), linear(v), linear(height * near - v)],
            base: skin.base(),
            offset: skin.offset,
            light: rect.light,
            gain: skin.tone * skin.contrast,
            lift: skin.tone * 128.0 * (1.0 - skin.contrast),
        })
    }

    /// Whether some line of `cone`, or every one, may meet the facet, and between what it is near there.
    fn within(&self, cone: &Cone) -> Option<Within> {
        let [far, near] = range(&self.near, cone);
        if near <= 0.0 {
            return None;
        }
        let mut fills = far > 0.0;
        for edge in &self.edges {
            let [low, high] = range(edge, cone);
            if high < 0.0 {
                return None;
            }
            fills &= low >= 0.0;
        }
        Some(Within { far, near, fills })
    }
}

/// How a facet lies in a cone.
struct Within {
    /// Least and largest 1/depth of its plane.
    far: f32,
    near: f32,
    /// It is all that is seen there, but for what is nearer.
    fills: bool,
}

/// Least and largest value of a linear function over a cone.
fn range(linear: &Linear, cone: &Cone) -> [f32; 2] {
    let [a, b, c] = *linear;
    let along = |slope: f32, [low, high]: [f32; 2]| {
        if slope >= 0.0 { [slope * low, slope * high] } else { [slope * high, slope * low] }
    };
    let (x, y) = (along(a, cone.x), along(b, cone.y));
    [x[0] + y[0] + c, x[1] + y[1] + c]
}

/// What a camera may see from one pose; kept from frame to frame for its room.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub(crate) facets: Vec<Facet>,
    /// For every tile its facets' places in `facets`: `lists[ends[tile - 1]..ends[tile]]`.
    lists: Vec<u16>,
    spans: Vec<(u32, u32)>,
    of_block: Vec<u16>,
    of_tile: Vec<(u16, f32)>,
}

impl View {
    /// Looks from `world_from_cam` through the tiles numbered `asked`.
    pub(crate) fn look(
        &mut self,
        scene: &Scene,
        lens: &Lens,
        world_from_cam: &Isometry3<f64>,
        asked: &Range<usize>,
    ) {
        let facets =
            scene.rects.iter().filter_map(|rect| Facet::new(rect, scene.texels_per_m, world_from_cam));
        self.facets.clear();
        // Places are 16 bits wide; a world of more rectangles shows the first.
        self.facets.extend(facets.take(usize::from(u16::MAX)));
        self.lists.clear();
        self.spans.clear();
        self.spans.resize(lens.tiles.len(), (0, 0));
        for (cone, tiles) in &lens.blocks {
            if !tiles.iter().any(|tile| asked.contains(tile)) {
                continue;
            }
            self.of_block.clear();
            let seen = self.facets.iter().zip(0_u16..).filter(|(facet, _)| facet.within(cone).is_some());
            self.of_block.extend(seen.map(|(_, place)| place));
            for &tile in tiles.iter().filter(|tile| asked.contains(tile)) {
                let first = self.lists.len() as u32;
                self.list(&lens.tiles[tile].cone);
                self.spans[tile] = (first, self.lists.len() as u32);
            }
        }
    }

    /// Adds the facets of a tile to the lists, without those that lie behind one that fills it.
    fn list(&mut self, cone: &Cone) {
        self.of_tile.clear();
        let mut wall = 0.0_f32;
        for &place in &self.of_block {
            let Some(within) = self.facets[usize::from(place)].within(cone) else { continue };
            if within.near <= wall {
                continue;
            }
            self.of_tile.push((place, within.near));
            if within.fills {
                wall = wall.max(within.far);
            }
        }
        self.lists.extend(self.of_tile.iter().filter(|(_, near)| *near > wall).map(|(place, _)| *place));
    }

    /// The facets that a tile may show.
    pub(crate) fn of(&self, tile: usize) -> &[u16] {
        let (first, end) = self.spans[tile];
        &self.lists[first as usize..end as usize]
    }
}
