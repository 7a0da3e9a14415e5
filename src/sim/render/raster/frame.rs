//! A frame of light: every pixel's grey value before lens blur, exposure and noise.
//!
//! A tile that one surface fills is shaded at once. Elsewhere the nearest surface is found at every pixel, and pixels beside another
//! surface are averages over eight lines of sight, so that edges move smoothly.

use super::super::scene::Scene;
use super::batch::{Batch, NOTHING};
use super::lens::{BATCH, Lens, TILE, Tile};
use super::view::View;
use nalgebra::{Isometry3, Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Lines of sight of a pixel at an edge.
const PER_PX: usize = 8;

/// Where a pixel at an edge is looked through, in sixteenths of it: eight places no two of which share a row or a column.
const PLACES: [[i8; 2]; PER_PX] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];

/// Width of a sample on a surface, in pixels: a bilinear look-up widens it by as much again.
const SAMPLE_PX: f32 = 0.75;

/// The same for one of the eight of a pixel.
const SUBSAMPLE_PX: f32 = 0.4;

/// Room for a frame, and the frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct Frame {
    view: View,
    batch: Box<Batch>,
    /// Grey values, row after row.
    pub(crate) grey: Vec<f32>,
    /// The facet that each pixel sees.
    places: Vec<u32>,
    /// Pixels of a tile that lie at an edge.
    edges: Vec<usize>,
}

impl Frame {
    /// What `lens` sees of `scene` from `world_from_cam`.
    pub(crate) fn render(&mut self, scene: &Scene, lens: &Lens, world_from_cam: &Isometry3<f64>) {
        self.paint(scene, lens, world_from_cam, 0..lens.tiles_across[1], None);
    }

    /// The same, line after line: line y is seen from `world_from_cam(y)`.
    ///
    /// Turns are exact to the line. Lines of a tile share the place of its middle one, a third of a millisecond off.
    pub(crate) fn render_lines(
        &mut self,
        scene: &Scene,
        lens: &Lens,
        world_from_cam: impl Fn(usize) -> Isometry3<f64>,
    ) {
        for row in 0..lens.tiles_across[1] {
            let middle = world_from_cam(row * TILE + TILE / 2);
            let turns = std::array::from_fn(|line| {
                let turn = middle.rotation.inverse() * world_from_cam(row * TILE + line).rotation;
                turn.to_rotation_matrix().into_inner().cast::<f32>()
            });
            self.paint(scene, lens, &middle, row..row + 1, Some(&turns));
        }
    }

    fn paint(
        &mut self,
        scene: &Scene,
        lens: &Lens,
        world_from_cam: &Isometry3<f64>,
        rows: Range<usize>,
        turns: Option<&[Matrix3<f32>; TILE]>,
    ) {
        let tiles = rows.start * lens.tiles_across[0]..rows.end * lens.tiles_across[0];
        self.view.look(scene, lens, world_from_cam, &tiles);
        let pixels = lens.size[0] * lens.size[1];
        self.grey.resize(pixels, 0.0);
        self.places.resize(pixels, NOTHING);
        let lines = rows.start * TILE..(rows.end * TILE).min(lens.size[1]);
        Arch::new().dispatch(Paint { frame: self, scene, lens, tiles, lines, turns });
    }
}

/// The part that is compiled for the machine's vector units.
struct Paint<'a> {
    frame: &'a mut Frame,
    scene: &'a Scene,
    lens: &'a Lens,
    /// Those that are painted, and their lines: beyond them nothing is known yet.
    tiles: Range<usize>,
    lines: Range<usize>,
    /// How each line of a tile is turned against the pose.
    turns: Option<&'a [Matrix3<f32>; TILE]>,
}

impl WithSimd for Paint<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { frame, scene, lens, tiles, lines, turns } = self;
        let Frame { view, batch, grey, places, edges } = frame;
        let texels = scene.atlas.texels();
        for index in tiles.clone() {
            let list = view.of(index);
            load(batch, &lens.tiles[index]);
            turn(batch, turns, |i| i / TILE);
            match list {
                [only] => batch.fill(*only),
                _ => batch.find(&view.facets, list),
            }
            batch.shade(&view.facets, list, texels);
            store(lens, index, &batch.grey, grey);
            store(lens, index, &batch.place, places);
        }
        for index in tiles {
            let list = view.of(index);
            if list.len() < 2 {
                continue;
            }
            at_edges(lens, index, &lines, places, edges);
            for some in edges.chunks(BATCH / PER_PX) {
                spread(batch, &lens.tiles[index], some);
                turn(batch, turns, |i| some[(i / PER_PX).min(some.len() - 1)] / TILE);
                batch.find(&view.facets, list);
                batch.shade(&view.facets, list, texels);
                for (n, &pixel) in some.iter().enumerate() {
                    let samples = &batch.grey[n * PER_PX..][..PER_PX];
                    let at = place_of(lens, index, pixel);
                    grey[at] = samples.iter().sum::<f32>() / PER_PX as f32;
                }
            }
        }
    }
}

#[inline(always)]
fn load(batch: &mut Batch, tile: &Tile) {
    (batch.x, batch.y) = (tile.x, tile.y);
    batch.per_sample = tile.per_px.map(|row| row.map(|v| v * SAMPLE_PX));
}

/// Lines of sight as they are at their line's instant; `line_of` says the line of a place in the batch.
#[inline(always)]
fn turn(batch: &mut Batch, turns: Option<&[Matrix3<f32>; TILE]>, line_of: impl Fn(usize) -> usize) {
    let Some(turns) = turns else { return };
    for i in 0..BATCH {
        let turned = turns[line_of(i)] * Vector3::new(batch.x[i], batch.y[i], 1.0);
        (batch.x[i], batch.y[i]) = (turned.x / turned.z, turned.y / turned.z);
    }
}

/// The lines of sight through the places of some pixels of a tile; where the batch is not full, the last pixel's again.
#[inline(always)]
fn spread(batch: &mut Batch, tile: &Tile, pixels: &[usize]) {
    let [[xa, xb], [ya, yb]] = tile.per_px;
    let last = pixels.len() - 1;
    let (xs, ys) = (batch.x.as_chunks_mut::<PER_PX>().0, batch.y.as_chunks_mut::<PER_PX>().0);
    for (n, (xs, ys)) in xs.iter_mut().zip(ys).enumerate() {
        let pixel = pixels[n.min(last)];
        let (x, y) = (tile.x[pixel], tile.y[pixel]);
        for i in 0..PER_PX {
            let [du, dv] = PLACES[i].map(|v| f32::from(v) * (1.0 / 16.0));
            xs[i] = x + du * xa + dv * xb;
            ys[i] = y + du * ya + dv * yb;
        }
    }
    batch.per_sample = tile.per_px.map(|row| row.map(|v| v * SUBSAMPLE_PX));
}

/// A tile's values into the image, as far as they lie in it.
#[inline(always)]
fn store<T: Copy>(lens: &Lens, index: usize, values: &[T; BATCH], to: &mut [T]) {
    let [width, height] = lens.size;
    let (left, top) = (index % lens.tiles_across[0] * TILE, index / lens.tiles_across[0] * TILE);
    let columns = TILE.min(width - left);
    for row in 0..TILE.min(height - top) {
        to[(top + row) * width + left..][..columns].copy_from_slice(&values[row * TILE..][..columns]);
    }
}

/// Where a tile's pixel is in the image.
#[inline(always)]
fn place_of(lens: &Lens, index: usize, pixel: usize) -> usize {
    let (left, top) = (index % lens.tiles_across[0] * TILE, index / lens.tiles_across[0] * TILE);
    (top + pixel / TILE) * lens.size[0] + left + pixel % TILE
}

/// Pixels of a tile with another surface to the left, right, above or below.
#[inline(always)]
fn at_edges(lens: &Lens, index: usize, lines: &Range<usize>, places: &[u32], edges: &mut Vec<usize>) {
    let [width, height] = lens.size;
    let (left, top) = (index % lens.tiles_across[0] * TILE, index / lens.tiles_across[0] * TILE);
    let inner = left > 0 && left + TILE < width;
    edges.clear();
    for row in 0..TILE.min(height - top) {
        let y = top + row;
        let (above, below) =
            (y.saturating_sub(1).max(lines.start) * width, (y + 1).min(lines.end - 1) * width);
        // Most rows have no edge: asked at once where the tile has neighbours on both sides.
        if inner {
            let own = &places[y * width + left..][..TILE];
            let others = [y * width + left - 1, y * width + left + 1, above + left, below + left];
            let differ = |from: usize| {
                let pairs = own.iter().zip(&places[from..][..TILE]);
                pairs.fold(0, |bits, (own, other)| bits | (own ^ other))
            };
            if others.into_iter().fold(0, |bits, from| bits | differ(from)) == 0 {
                continue;
            }
        }
        for column in 0..TILE.min(width - left) {
            let x = left + column;
            let own = places[y * width + x];
            let (before, after) = (x.saturating_sub(1), (x + 1).min(width - 1));
            let others = [y * width + before, y * width + after, above + x, below + x];
            if others.into_iter().any(|at| places[at] != own) {
                edges.push(row * TILE + column);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::scene::Course;
    use super::super::super::texture::{LOG_SIDE, SIDE};
    use super::super::uncalibrated::Uncalibrated;
    use super::super::view::Facet;
    use super::*;
    use crate::tracks::{Bounds, World};
    use dpn_core::camera::CameraModel;
    use dpn_core::random::Stream;

    fn scene() -> Scene {
        let bounds = Bounds { low: Vector3::new(-2.0, -1.5, 0.2), high: Vector3::new(2.0, 1.5, 1.4) };
        Scene::new(&Course::within(&bounds), World::Room, [1.0, 0.0], &Stream::new(9))
    }

    fn poses() -> impl Iterator<Item = Isometry3<f64>> {
        (0..5).map(|i| {
            let i = f64::from(i);
            let place =
                Vector3::new(1.8 * (1.3 * i).sin(), 1.4 * (0.7 * i).cos(), 0.8 + 0.5 * (2.0 * i).sin());
            Isometry3::new(place, Vector3::new(-1.2, 0.3, 0.2) + i * Vector3::new(0.1, 0.2, 1.3))
        })
    }

    #[test]
    fn every_pixel_shows_the_nearest_surface() {
        let (scene, camera) = (scene(), CameraModel::euroc_cam0());
        let (lens, mut frame) =
            (Lens::new(&camera, &Uncalibrated::new(0.0, 752, &Stream::new(0)), 1).unwrap(), Frame::default());
        for pose in poses() {
            frame.render(&scene, &lens, &pose);
            let facing =
                |rect: &&usize| Facet::new(&scene.rects[**rect], scene.texels_per_m, &pose).is_some();
            let rects: Vec<usize> = (0..scene.rects.len()).collect();
            let rects: Vec<usize> = rects.iter().filter(facing).copied().collect();
            let (mut seen, mut edges) = (0, 0);
            for (i, place) in frame.places.iter().enumerate().step_by(53) {
                let px = nalgebra::Vector2::new((i % 752) as f64, (i / 752) as f64);
                let ray = pose.rotation * camera.normalise(&px).unwrap().push(1.0);
                let (rect, _) = scene.hit(&pose.translation.vector, &ray).unwrap();
                let shown = rects[*place as usize];
                // Single precision may decide otherwise a thousandth of a pixel from an edge.
                edges += usize::from(shown != rect);
                seen += 1;
            }
            assert!(edges * 2000 <= seen, "{edges} of {seen}");
        }
    }

    #[test]
    fn the_texture_lies_where_geometry_says() {
        let (scene, camera) = (scene(), CameraModel::euroc_cam0());
        let (lens, mut frame) =
            (Lens::new(&camera, &Uncalibrated::new(0.0, 752, &Stream::new(0)), 1).unwrap(), Frame::default());
        let mut compared = 0;
        for pose in poses() {
            frame.render(&scene, &lens, &pose);
            for i in (0..frame.grey.len()).step_by(31) {
                let px = nalgebra::Vector2::new((i % 752) as f64, (i / 752) as f64);
                let ray = pose.rotation * camera.normalise(&px).unwrap().push(1.0);
                let (index, way) = scene.hit(&pose.translation.vector, &ray).unwrap();
                let rect = &scene.rects[index];
                // Near and face to face: a pixel is smaller than a texel, so its value is that of the finest level.
                let slope = -rect.normal().dot(&ray) / ray.norm();
                if way > 0.9 || slope < 0.8 {
                    continue;
                }
                let at = pose.translation.vector + way * ray - rect.origin;
                let local = [at.dot(&rect.across), at.dot(&rect.along)].map(|v| v * scene.texels_per_m);
                let [u, v] = [0, 1].map(|k| local[k] + f64::from(rect.skin.offset[k]) - 0.5);
                let texel = |x: i64, y: i64| {
                    let side = SIDE as i64;
                    let place =
                        (y.rem_euclid(side) << LOG_SIDE) + x.rem_euclid(side) + (1 << (2 * LOG_SIDE - 1));
                    f64::from(scene.atlas.texels()[rect.skin.base() as usize + place as usize] & 255)
                };
                let (x, y) = (u.floor() as i64, v.floor() as i64);
                let (fx, fy) = (u - u.floor(), v - v.floor());
                let grey = (1.0 - fy) * ((1.0 - fx) * texel(x, y) + fx * texel(x + 1, y))
                    + fy * ((1.0 - fx) * texel(x, y + 1) + fx * texel(x + 1, y + 1));
                let [c, a, b, aa, ab, bb] = rect.light.map(f64::from);
                let [u, v] = local;
                let light = c + a * u + b * v + aa * u * u + ab * u * v + bb * v * v;
                let expected = light * f64::from(rect.skin.tone) * grey;
                let own = frame.places[i];
                let inside = [1, 752].iter().all(|s| {
                    frame.places.get(i + s) == Some(&own)
                        && i.checked_sub(*s).is_some_and(|at| frame.places[at] == own)
                });
                if inside {
                    assert!(
                        (f64::from(frame.grey[i]) - expected).abs() < 0.8,
                        "{px}: {} {expected}",
                        frame.grey[i]
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 50, "{compared}");
    }
}
