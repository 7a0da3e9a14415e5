//! Gaussian pyramids.
//!
//! Each level is the one below it, smoothed by `(1 4 6 4 1) / 16` in rows and columns and cut to every second pixel, rounded once:
//! pixel `(x, y)` of a level lies over `(2x, 2y)` of the one below. Source: Burt and Adelson 1983; the same to the bit as OpenCV's
//! `pyrDown`.

use super::plane::Plane;
use dpn_core::GrayView;
use pulp::{Arch, Simd, WithSimd};

/// An image at half, a quarter, an eighth of its size, and itself.
#[derive(Debug, Clone, Default)]
pub struct Pyramid {
    planes: Vec<Plane>,
    scratch: Scratch,
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    column: Vec<u16>,
    even: Vec<u16>,
    odd: Vec<u16>,
}

impl Pyramid {
    /// The pyramid of `image` with `levels` planes, the image itself among them; fewer where one would be under 8 px.
    pub fn new(image: GrayView<'_>, levels: usize) -> Self {
        let mut pyramid = Self::default();
        pyramid.build(image, levels);
        pyramid
    }

    /// The same in place of what it was; memory is kept where the size stays.
    pub(crate) fn build(&mut self, image: GrayView<'_>, levels: usize) {
        let smallest = image.width().min(image.height());
        let levels = (1..levels).take_while(|&level| smallest >> level >= 8).count() + 1;
        self.planes.resize_with(levels, Plane::default);
        self.planes[0].copy(image);
        for level in 1..levels {
            let (below, above) = self.planes.split_at_mut(level);
            Arch::new().dispatch(Down {
                from: &below[level - 1],
                to: &mut above[0],
                scratch: &mut self.scratch,
            });
        }
    }

    /// The planes, largest first.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }
}

/// The next level over `from`, `(width + 1) / 2` by `(height + 1) / 2`.
#[cfg(test)]
pub(crate) fn pyr_down(from: &Plane) -> Plane {
    let mut to = Plane::default();
    Arch::new().dispatch(Down { from, to: &mut to, scratch: &mut Scratch::default() });
    to
}

struct Down<'a> {
    from: &'a Plane,
    to: &'a mut Plane,
    scratch: &'a mut Scratch,
}

impl WithSimd for Down<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { from, to, scratch: Scratch { column, even, odd } } = self;
        to.resize(from.width().div_ceil(2), from.height().div_ceil(2));
        // Columns -2 to 2 * width + 2 of the plane below, so that pixel x of the output begins at 2 x.
        let wide = 2 * to.width() + 4;
        column.resize(wide, 0);
        even.resize(wide / 2, 0);
        odd.resize(wide / 2, 0);
        for y in 0..to.height() {
            let row = |dy: isize| from.run(-2, 2 * y as isize + dy, wide);
            smooth_columns([row(-2), row(-1), row(0), row(1), row(2)], column);
            for ((pair, even), odd) in column.chunks_exact(2).zip(even.iter_mut()).zip(odd.iter_mut()) {
                (*even, *odd) = (pair[0], pair[1]);
            }
            smooth_rows(even, odd, to.row_mut(y));
        }
        to.mirror();
    }
}

/// Five rows into one of 16 times their range.
#[inline(always)]
fn smooth_columns(rows: [&[u8]; 5], out: &mut [u16]) {
    let n = out.len();
    let [a, b, c, d, e] = rows.map(|row| &row[..n]);
    for i in 0..n {
        let [a, b, c, d, e] = [a[i], b[i], c[i], d[i], e[i]].map(u16::from);
        out[i] = a + e + 4 * (b + d) + 6 * c;
    }
}

/// One output pixel from five neighbours; 16 * 16 * 255 + 128 fits 16 bits.
#[inline(always)]
fn smooth_rows(even: &[u16], odd: &[u16], out: &mut [u8]) {
    let n = out.len();
    let (e0, e1, e2) = (&even[..n], &even[1..][..n], &even[2..][..n]);
    let (o0, o1) = (&odd[..n], &odd[1..][..n]);
    for i in 0..n {
        out[i] = ((e0[i] + e2[i] + 6 * e1[i] + 4 * (o0[i] + o1[i]) + 128) >> 8) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;
    use proptest::prelude::*;

    /// The definition, pixel by pixel.
    fn plain(plane: &Plane, x: isize, y: isize) -> u8 {
        let weights = [1, 4, 6, 4, 1];
        let mut sum = 128;
        for (j, wy) in (-2..=2).zip(weights) {
            for (i, wx) in (-2..=2).zip(weights) {
                sum += wx * wy * u32::from(plane.run(2 * x + i, 2 * y + j, 1)[0]);
            }
        }
        (sum / 256) as u8
    }

    proptest! {
        #[test]
        fn a_level_is_its_definition(width in 1..90usize, height in 1..40usize, seed in any::<u32>()) {
            let image = GrayImage::from_fn(width, height, |x, y| {
                (seed ^ (x as u32 * 7919 + y as u32 * 104_729)).wrapping_mul(2_654_435_761).to_be_bytes()[0]
            }).unwrap();
            let plane = Plane::new(image.view());
            let down = pyr_down(&plane);
            prop_assert_eq!((down.width(), down.height()), (width.div_ceil(2), height.div_ceil(2)));
            for y in 0..down.height() {
                for x in 0..down.width() {
                    prop_assert_eq!(down.row(y)[x], plain(&plane, x as isize, y as isize), "at {}, {}", x, y);
                }
            }
        }
    }

    #[test]
    fn an_image_all_white_stays_white_and_a_small_one_has_fewer_levels() {
        let image = GrayImage::from_fn(50, 40, |_, _| 255).unwrap();
        let pyramid = Pyramid::new(image.view(), 4);
        let sizes: Vec<_> = pyramid.planes().iter().map(|p| (p.width(), p.height())).collect();
        assert_eq!(sizes, [(50, 40), (25, 20), (13, 10)]);
        assert!(pyramid.planes().iter().all(|p| (0..p.height()).all(|y| p.row(y).iter().all(|v| *v == 255))));
    }
}
