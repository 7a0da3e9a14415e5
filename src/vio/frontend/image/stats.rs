//! What an image is like as a whole: bright or dark, flat or not, the same as the last one or not.

use dpn_core::GrayView;
use pulp::{Arch, Simd, WithSimd};
use serde::Serialize;

/// A pixel at or below this is dark.
const DARK: u8 = 8;
/// A pixel at or above this is saturated.
const SATURATED: u8 = 250;

/// Figures over all pixels of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImageStats {
    /// Mean grey value, 0 to 255.
    pub mean: f64,
    /// Standard deviation of the grey values.
    pub std: f64,
    /// Share of pixels at 8 or below.
    pub dark: f64,
    /// Share of pixels at 250 or above.
    pub saturated: f64,
    /// A number that two images share when all their pixels are the same, and by a chance of 2^-64 otherwise.
    #[serde(skip)]
    pub fingerprint: u64,
}

impl ImageStats {
    /// The figures of `image`.
    pub fn of(image: GrayView<'_>) -> Self {
        Arch::new().dispatch(Figures { image })
    }

    /// The share of pixels that say nothing: too dark or too bright.
    pub(crate) fn unusable(&self) -> f64 {
        self.dark + self.saturated
    }
}

struct Figures<'a> {
    image: GrayView<'a>,
}

impl WithSimd for Figures<'_> {
    type Output = ImageStats;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> ImageStats {
        let image = self.image;
        let (mut sum, mut squares, mut dark, mut saturated) = (0u64, 0u64, 0u64, 0u64);
        let mut fingerprint = [0x9e37_79b9_7f4a_7c15_u64, 1, 2, 3];
        for row in image.rows() {
            // A block's sums fit 32 bits, which keeps twice as many in a vector.
            for block in row.chunks(1024) {
                let (mut s, mut q, mut d, mut b) = (0u32, 0u32, 0u32, 0u32);
                for &pixel in block {
                    s += u32::from(pixel);
                    q += u32::from(pixel) * u32::from(pixel);
                    d += u32::from(pixel <= DARK);
                    b += u32::from(pixel >= SATURATED);
                }
                sum += u64::from(s);
                squares += u64::from(q);
                dark += u64::from(d);
                saturated += u64::from(b);
            }
            mix_row(&mut fingerprint, row);
        }
        let n = (image.width() * image.height()) as f64;
        let mean = sum as f64 / n;
        ImageStats {
            mean,
            std: (squares as f64 / n - mean * mean).max(0.0).sqrt(),
            dark: dark as f64 / n,
            saturated: saturated as f64 / n,
            fingerprint: fingerprint.into_iter().fold(0, mix),
        }
    }
}

/// Four chains, so that one multiplication need not wait for the one before it.
#[inline(always)]
fn mix_row(chains: &mut [u64; 4], row: &[u8]) {
    let (words, rest) = row.as_chunks::<8>();
    let (blocks, last) = words.as_chunks::<4>();
    for block in blocks {
        for (chain, word) in chains.iter_mut().zip(block) {
            *chain = mix(*chain, u64::from_le_bytes(*word));
        }
    }
    for word in last {
        chains[0] = mix(chains[0], u64::from_le_bytes(*word));
    }
    for &byte in rest {
        chains[0] = mix(chains[0], u64::from(byte));
    }
}

#[inline(always)]
fn mix(chain: u64, word: u64) -> u64 {
    let product = (chain ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
    product ^ (product >> 32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    #[test]
    fn the_figures_are_those_of_the_pixels() {
        let image = GrayImage::new(5, 2, vec![0, 8, 9, 100, 255, 250, 249, 0, 3, 200]).unwrap();
        let stats = ImageStats::of(image.view());
        let values: Vec<f64> = image.pixels().iter().map(|v| f64::from(*v)).collect();
        let mean = values.iter().sum::<f64>() / 10.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 10.0;
        assert!((stats.mean - mean).abs() < 1e-12 && (stats.std - variance.sqrt()).abs() < 1e-9);
        assert_eq!((stats.dark, stats.saturated), (0.4, 0.2));
    }

    #[test]
    fn one_changed_pixel_changes_the_fingerprint() {
        let image = GrayImage::from_fn(77, 5, |x, y| (x * y) as u8).unwrap();
        let print = ImageStats::of(image.view()).fingerprint;
        for at in 0..image.pixels().len() {
            let mut other = image.clone();
            other.pixels_mut()[at] ^= 1;
            assert_ne!(ImageStats::of(other.view()).fingerprint, print, "pixel {at}");
        }
        assert_eq!(ImageStats::of(image.clone().view()).fingerprint, print);
    }
}
