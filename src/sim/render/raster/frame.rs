//! A frame of light: every pixel's grey value before lens blur, exposure and noise.
//!
//! A tile that one surface fills is shaded at once. Elsewhere the nearest surface is found at every pixel, and pixels beside another
//! surface are averages over eight lines of sight, so that edges move smoothly.

use super::super::scene::Scene;
use super::batch::{Batch, NOTHING};
use super::lens::{BATCH, Lens, TILE, Tile};
use super::view::View;
use nalgebra::Isometry3;
use pulp::{Arch, Simd, WithSimd};

/// Where a pixel at an edge is looked through, in sixteenths of it: eight places no two of which share a row or a column.
const PLACES: [[i8; 2]; 8] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];

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
    places: Vec<u16>,
    /// Pixels of a tile that lie at an edge.
    edges: Vec<usize>,
}

impl Frame {
    /// What `lens` sees of `scene` from `world_from_cam`.
    pub(crate) fn render(&mut self, scene: &Scene, lens: &Lens, world_from_cam: &Isometry3<f64>) {
        self.view.look(scene, lens, world_from_cam);
        let pixels = lens.size[0] * lens.size[1];
        self.grey.resize(pixels, 0.0);
        self.places.resize(pixels, NOTHING);
        Arch::new().dispatch(Paint { frame: self, scene, lens });
    }
}

/// The part that is compiled for the machine's vector units.
struct Paint<'a> {
    frame: &'a mut Frame,
    scene: &'a Scene,
    lens: &'a Lens,
}

impl WithSimd for Paint<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { frame, scene, lens } = self;
        let Frame { view, batch, grey, places, edges } = frame;
        let texels = scene.atlas.texels();
        for (index, tile) in lens.tiles.iter().enumerate() {
            let list = view.of(index);
            load(batch, tile);
            match list {
                [only] => batch.fill(*only),
                _ => batch.find(&view.facets, list),
            }
            batch.shade(&view.facets, list, texels);
            store(lens, index, &batch.grey, grey);
            store(lens, index, &batch.place, places);
        }
        for (index, tile) in lens.tiles.iter().enumerate() {
            let list = view.of(index);
            if list.len() < 2 {
                continue;
            }
            at_edges(lens, index, places, edges);
            for some in edges.chunks(BATCH / PLACES.len()) {
                spread(batch, tile, some);
                batch.find(&view.facets, list);
                batch.shade(&view.facets, list, texels);
                for (n, &pixel) in some.iter().enumerate() {
                    let samples = &batch.grey[n * PLACES.len()..][..PLACES.len()];
                    let at = place_of(lens, index, pixel);
                    grey[at] = samples.iter().sum::<f32>() / PLACES.len() as f32;
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

/// The lines of sight through the places of some pixels of a tile; where the batch is not full, the last pixel's again.
#[inline(always)]
fn spread(batch: &mut Batch, tile: &Tile, pixels: &[usize]) {
    let [[xa, xb], [ya, yb]] = tile.per_px;
    for i in 0..BATCH {
        let pixel = pixels[(i / PLACES.len()).min(pixels.len() - 1)];
        let [du, dv] = PLACES[i % PLACES.len()].map(|v| f32::from(v) / 16.0);
        batch.x[i] = tile.x[pixel] + du * xa + dv * xb;
        batch.y[i] = tile.y[pixel] + du * ya + dv * yb;
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
fn at_edges(lens: &Lens, index: usize, places: &[u16], edges: &mut Vec<usize>) {
    let [width, height] = lens.size;
    let (left, top) = (index % lens.tiles_across[0] * TILE, index / lens.tiles_across[0] * TILE);
    edges.clear();
    for row in 0..TILE.min(height - top) {
        let y = top + row;
        for column in 0..TILE.min(width - left) {
            let x = left + column;
            let at = y * width + x;
            let own = places[at];
            let another = (x > 0 && places[at - 1] != own)
                || (x + 1 < width && places[at + 1] != own)
                || (y > 0 && places[at - width] != own)
                || (y + 1 < height && places[at + width] != own);
            if another {
                edges.push(row * TILE + column);
            }
        }
    }
}
