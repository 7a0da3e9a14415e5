//! Contrast-limited adaptive histogram equalisation.
//!
//! The image is cut in tiles; each tile's histogram is clipped, what was clipped is spread over all grey values, and its running sum
//! is the tile's map of grey values. A pixel is mapped by the four tiles around it, weighted bilinearly by its distance to their
//! centres. Source: Zuiderveld 1994 (*Graphics Gems IV*, VIII.5), with OpenCV's rules for clipping and rounding.

use super::plane::{PAD, Plane};
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// How contrast is equalised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClaheConfig {
    /// Whether it is. Default false: the tracker holds its own against slow changes of light.
    pub enabled: bool,
    /// How many times the mean a histogram's bin may hold, 1 to 255. Default 3.
    pub clip_limit: f64,
    /// Tiles in a row and in a column, 1 to 32. Default 8.
    pub tiles: usize,
}

impl Default for ClaheConfig {
    fn default() -> Self {
        Self { enabled: false, clip_limit: 3.0, tiles: 8 }
    }
}

impl Validate for ClaheConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.within("clip_limit", self.clip_limit, 1.0, 255.0);
        faults.within("tiles", self.tiles, 1, PAD);
        faults.0
    }
}

type Map = [f32; 256];

/// Equalises image after image; its tables are kept.
#[derive(Debug, Clone)]
pub struct Clahe {
    config: ClaheConfig,
    /// Each tile's map, tiles row after row.
    maps: Vec<Map>,
    /// The maps of a row of tiles, blended for one row of pixels.
    blended: Vec<Map>,
}

/// Where pixels lie between tiles' centres along one side.
#[derive(Clone, Copy)]
struct Between {
    first: usize,
    second: usize,
    /// Weight of the second.
    weight: f32,
}

impl Between {
    fn at(pixel: usize, tile: usize, tiles: usize) -> Self {
        let place = pixel as f32 / tile as f32 - 0.5;
        let first = place.floor();
        let clamp = |tile: f32| (tile.max(0.0) as usize).min(tiles - 1);
        Self { first: clamp(first), second: clamp(first + 1.0), weight: place - first }
    }
}

impl Clahe {
    /// Equalisation as `config` says, whether or not it says `enabled`.
    pub fn new(config: ClaheConfig) -> Self {
        Self { config, maps: Vec::new(), blended: Vec::new() }
    }

    /// Equalises a plane and its border.
    pub fn apply(&mut self, plane: &mut Plane) {
        let tiles = self.config.tiles.clamp(1, PAD);
        // The last tiles reach into the mirrored border where the size is no multiple.
        let tile = [plane.width().div_ceil(tiles), plane.height().div_ceil(tiles)];
        self.maps.clear();
        for ty in 0..tiles {
            for tx in 0..tiles {
                self.maps.push(tile_map(plane, [tx * tile[0], ty * tile[1]], tile, self.config.clip_limit));
            }
        }
        self.blended.resize(tiles, [0.0; 256]);
        Arch::new().dispatch(Remap { plane, tile, tiles, maps: &self.maps, blended: &mut self.blended });
        plane.mirror();
    }
}

/// The grey value map of one tile.
fn tile_map(plane: &Plane, [x, y]: [usize; 2], [width, height]: [usize; 2], clip_limit: f64) -> Map {
    // Neighbouring pixels are often alike; two counters a value keep one increment from waiting for the other.
    let mut counts = [[0u32; 256]; 2];
    for row in y..y + height {
        // What the tiles have more than the image is less than the border.
        let pixels = plane.run(x as isize, row as isize, width);
        let (pairs, last) = pixels.as_chunks::<2>();
        for [a, b] in pairs {
            counts[0][usize::from(*a)] += 1;
            counts[1][usize::from(*b)] += 1;
        }
        last.iter().for_each(|a| counts[0][usize::from(*a)] += 1);
    }
    let mut histogram = [0u32; 256];
    histogram.iter_mut().zip(counts[0]).zip(counts[1]).for_each(|((sum, a), b)| *sum = a + b);

    let area = (width * height) as f64;
    let limit = ((clip_limit * area / 256.0) as u32).max(1);
    let clipped: u32 = histogram.iter().map(|count| count.saturating_sub(limit)).sum();
    let rest = (clipped % 256) as usize;
    histogram.iter_mut().for_each(|count| *count = (*count).min(limit) + clipped / 256);
    let step = (256 / rest.max(1)).max(1);
    histogram.iter_mut().step_by(step).take(rest).for_each(|count| *count += 1);

    let scale = 255.0 / area as f32;
    let mut sum = 0u32;
    histogram.map(|count| {
        sum += count;
        (sum as f32 * scale).round_ties_even().min(255.0)
    })
}

struct Remap<'a> {
    plane: &'a mut Plane,
    tile: [usize; 2],
    tiles: usize,
    maps: &'a [Map],
    blended: &'a mut [Map],
}

impl WithSimd for Remap<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { plane, tile, tiles, maps, blended } = self;
        let weights: Vec<Between> = (0..plane.width()).map(|x| Between::at(x, tile[0], tiles)).collect();
        for y in 0..plane.height() {
            let rows = Between::at(y, tile[1], tiles);
            for (tx, out) in blended.iter_mut().enumerate() {
                let (above, below) = (&maps[rows.first * tiles + tx], &maps[rows.second * tiles + tx]);
                for i in 0..256 {
                    out[i] = above[i] + rows.weight * (below[i] - above[i]);
                }
            }
            let mut row = plane.row_mut(y);
            let mut weights = &weights[..];
            while let Some(start) = weights.first().copied() {
                let run =
                    weights.iter().take_while(|w| (w.first, w.second) == (start.first, start.second)).count();
                let (left, right) = (&blended[start.first], &blended[start.second]);
                let (here, rest) = std::mem::take(&mut row).split_at_mut(run);
                for (pixel, between) in here.iter_mut().zip(weights) {
                    let value = usize::from(*pixel);
                    let mapped = left[value] + between.weight * (right[value] - left[value]);
                    *pixel = (mapped + 0.5) as u8;
                }
                (row, weights) = (rest, &weights[run..]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    fn equalised(image: &GrayImage, config: ClaheConfig) -> Plane {
        let mut plane = Plane::new(image.view());
        Clahe::new(config).apply(&mut plane);
        plane
    }

    #[test]
    fn a_faint_ramp_is_spread_and_keeps_its_order() {
        let image = GrayImage::from_fn(256, 64, |x, _| 100 + (x / 16) as u8).unwrap();
        let plane = equalised(&image, ClaheConfig { clip_limit: 255.0, tiles: 1, ..Default::default() });
        let row = plane.row(30);
        assert!(row.is_sorted() && row[0] < 20 && row[255] == 255, "{row:?}");
        // The limit keeps what was flat nearly flat: at most three times the slope of the identity.
        let plane = equalised(&image, ClaheConfig { clip_limit: 3.0, tiles: 1, ..Default::default() });
        assert!(plane.row(30).windows(2).all(|w| w[1] - w[0] <= 4));
    }

    #[test]
    fn no_size_is_too_small_and_odd_sizes_have_no_seams() {
        for (width, height) in [(1, 1), (3, 40), (37, 5), (101, 67)] {
            let image = GrayImage::from_fn(width, height, |x, y| (x + y) as u8).unwrap();
            let plane = equalised(&image, ClaheConfig::default());
            assert_eq!((plane.width(), plane.height()), (width, height));
        }
        let image = GrayImage::from_fn(203, 121, |x, _| x as u8).unwrap();
        let plane = equalised(&image, ClaheConfig::default());
        let row = plane.row(60);
        assert!(row.windows(2).all(|w| w[0].abs_diff(w[1]) < 8), "{row:?}");
    }
}
