//! All textures in one array, each at its full size, a half, a quarter: looked up by a single load.
//!
//! A texel holds the four grey values that bilinear interpolation needs, its own, its right neighbour's, those below, as the bytes
//! of one number. The square of side 2^k of texture m begins at `m * STRIDE + 2^(2k - 1)`, so that a level's place is a shift. A level
//! is the mean of 2 x 2 texels of the finer one, which leaves places where they are: texel i of level l is centred at `(i + 1/2) 2^l`.

use super::canvas::SIDE;
use super::material::Material;
use dpn_core::random::Stream;
use rayon::prelude::*;

/// log2 of [`SIDE`].
pub(crate) const LOG_SIDE: u32 = SIDE.trailing_zeros();

/// The coarsest level has this side \[log2 texels\].
pub(crate) const LOG_COARSEST: u32 = 2;

/// Numbers a texture takes: up to the end of its finest level.
const STRIDE: usize = 3 << (2 * LOG_SIDE - 1);

/// The textures of all [`Material`]s.
#[derive(Debug, Clone)]
pub(crate) struct Atlas {
    texels: Vec<u32>,
}

impl Atlas {
    /// Paints every material. The same whatever the number of threads.
    pub(crate) fn new(stream: &Stream) -> Self {
        let mut texels = vec![0; Material::ALL.len() * STRIDE];
        texels.par_chunks_mut(STRIDE).enumerate().for_each(|(index, texels)| {
            let mut grey = Material::ALL[index].paint(&mut stream.named("texture").index(index as u64).rng());
            for log_side in (LOG_COARSEST..=LOG_SIDE).rev() {
                pack(&grey, log_side, &mut texels[1 << (2 * log_side - 1)..][..1 << (2 * log_side)]);
                grey = halved(&grey, 1 << log_side);
            }
        });
        Self { texels }
    }

    /// Where a material's texture begins.
    pub(crate) fn base(material: Material) -> u32 {
        let index = Material::ALL.iter().position(|m| *m == material).expect("`ALL` holds every material");
        (index * STRIDE) as u32
    }

    /// All texels.
    pub(crate) fn texels(&self) -> &[u32] {
        &self.texels
    }
}

/// Grey values as bytes, four in each number.
fn pack(grey: &[f32], log_side: u32, to: &mut [u32]) {
    let side = 1_usize << log_side;
    let byte = |x: usize, y: usize| {
        let grey = grey[((y & (side - 1)) << log_side) + (x & (side - 1))];
        grey.round().clamp(0.0, 255.0) as u32
    };
    for y in 0..side {
        for x in 0..side {
            let (right, below) = (byte(x + 1, y), byte(x, y + 1));
            to[y * side + x] = byte(x, y) | right << 8 | below << 16 | byte(x + 1, y + 1) << 24;
        }
    }
}

fn halved(grey: &[f32], side: usize) -> Vec<f32> {
    let half = side / 2;
    let mean = |x: usize, y: usize| {
        let at = 2 * y * side + 2 * x;
        0.25 * (grey[at] + grey[at + 1] + grey[at + side] + grey[at + side + 1])
    };
    (0..half * half).map(|i| mean(i % half, i / half)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn byte(atlas: &Atlas, material: Material, log_side: u32, x: usize, y: usize) -> u32 {
        let at = Atlas::base(material) as usize + (1 << (2 * log_side - 1)) + (y << log_side) + x;
        atlas.texels()[at]
    }

    #[test]
    fn levels_do_not_overlap_and_coarse_ones_are_means_of_fine_ones() {
        let atlas = Atlas::new(&Stream::new(3));
        for material in [Material::Clutter, Material::Print] {
            for log_side in LOG_COARSEST..LOG_SIDE {
                for (x, y) in [(0, 0), (1, 2), (3, 3), ((1 << log_side) - 1, 1)] {
                    let fine = byte(&atlas, material, log_side + 1, 2 * x, 2 * y);
                    let mean = (fine.to_le_bytes().map(u32::from).iter().sum::<u32>() as f64) / 4.0;
                    let coarse = byte(&atlas, material, log_side, x, y) & 255;
                    // Both are rounded.
                    assert!((f64::from(coarse) - mean).abs() <= 1.01, "{log_side} {x} {y}");
                }
            }
            let seam = byte(&atlas, material, LOG_SIDE, SIDE - 1, 7);
            assert_eq!(seam >> 8 & 255, byte(&atlas, material, LOG_SIDE, 0, 7) & 255);
        }
    }

    #[test]
    fn every_material_but_the_plain_one_has_contrast_and_no_texture_is_another() {
        let atlas = Atlas::new(&Stream::new(3));
        let mut seen = Vec::new();
        for material in Material::ALL {
            let base = Atlas::base(material) as usize + (1 << (2 * LOG_SIDE - 1));
            let greys: Vec<f64> =
                atlas.texels()[base..base + SIDE * SIDE].iter().map(|t| f64::from(t & 255)).collect();
            let mean = greys.iter().sum::<f64>() / greys.len() as f64;
            let std = (greys.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / greys.len() as f64).sqrt();
            assert_eq!(std > 5.0, material != Material::Plain, "{material:?}: {mean} {std}");
            assert!((25.0..215.0).contains(&mean), "{material:?}: {mean}");
            seen.push(greys);
        }
        assert!((1..seen.len()).all(|i| seen[i] != seen[i - 1]));
    }
}
