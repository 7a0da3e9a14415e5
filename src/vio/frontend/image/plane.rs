//! A grey image with a border around it, so that no kernel asks where the image ends.
//!
//! The border mirrors the image about its outermost pixels (`c b | a b c`, OpenCV's `BORDER_REFLECT_101`).

use dpn_core::GrayView;

/// Width of the border on every side \[px\].
pub(crate) const PAD: usize = 32;

/// How far a vector load may reach behind the last row's border.
const SLACK: usize = 64;

/// An image of 8 bits a pixel with `PAD` mirrored pixels on every side.
#[derive(Debug, Clone, Default)]
pub struct Plane {
    width: usize,
    height: usize,
    stride: usize,
    data: Vec<u8>,
}

impl Plane {
    /// A copy of `image` with its border.
    pub fn new(image: GrayView<'_>) -> Self {
        let mut plane = Self::default();
        plane.copy(image);
        plane
    }

    /// Takes over another image; memory is kept where the size stays.
    pub(crate) fn copy(&mut self, image: GrayView<'_>) {
        self.resize(image.width(), image.height());
        for (y, row) in image.rows().enumerate() {
            self.row_mut(y).copy_from_slice(row);
        }
        self.mirror();
    }

    /// Columns without the border.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Rows without the border.
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// Changes the size; what the pixels hold afterwards is not said.
    pub(crate) fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height, self.stride) = (width, height, width + 2 * PAD);
        self.data.resize(self.stride * (height + 2 * PAD) + SLACK, 0);
    }

    /// Row `y` without its border.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn row(&self, y: usize) -> &[u8] {
        &self.data[self.at(0, y as isize)..][..self.width]
    }

    /// Row `y` without its border, to be written; [`Self::mirror`] makes the border afterwards.
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        let at = self.at(0, y as isize);
        &mut self.data[at..][..self.width]
    }

    /// `count` pixels of row `y` from column `x` on; both may lie in the border, and `count` may reach [`SLACK`] px past it.
    #[inline(always)]
    pub(crate) fn run(&self, x: isize, y: isize, count: usize) -> &[u8] {
        &self.data[self.at(x, y)..][..count]
    }

    /// Grey values along a line of points, by bilinear interpolation: from `first` on by `step` \[px\], to the position's 1/65536th. They and
    /// their right and lower neighbours lie in the image, whose sides are below 32768 px.
    #[inline(always)]
    pub(crate) fn along(&self, first: [f32; 2], step: [f32; 2], grey: &mut [f32]) {
        const ONE: f32 = 65536.0;
        let [mut x, mut y] = first.map(|c| (c * ONE) as i32);
        let [across, down] = step.map(|c| (c * ONE) as i32);
        let share = |c: i32| (c & 0xffff) as f32 * (1.0 / ONE);
        for grey in grey {
            let at = self.at((x >> 16) as isize, (y >> 16) as isize);
            let above: &[u8; 2] = self.data[at..].first_chunk().expect("a pixel and its right neighbour");
            let below: &[u8; 2] = self.data[at + self.stride..].first_chunk().expect("the row below");
            let [a, b, c, d] = [above[0], above[1], below[0], below[1]].map(f32::from);
            let (above, below) = (a + share(x) * (b - a), c + share(x) * (d - c));
            *grey = above + share(y) * (below - above);
            (x, y) = (x + across, y + down);
        }
    }

    #[inline(always)]
    fn at(&self, x: isize, y: isize) -> usize {
        let pad = PAD as isize;
        debug_assert!(
            (-pad..self.width as isize + pad).contains(&x) && (-pad..self.height as isize + pad).contains(&y)
        );
        (y + pad) as usize * self.stride + (x + pad) as usize
    }

    /// Fills the border from the pixels inside.
    pub(crate) fn mirror(&mut self) {
        let (width, height) = (self.width, self.height);
        for y in 0..height {
            let from = (y + PAD) * self.stride;
            let (left, rest) = self.data[from..][..self.stride].split_at_mut(PAD);
            let (row, right) = rest.split_at_mut(width);
            if width > PAD {
                left.iter_mut().rev().zip(&row[1..]).for_each(|(to, from)| *to = *from);
                right.iter_mut().zip(row[..width - 1].iter().rev()).for_each(|(to, from)| *to = *from);
            } else {
                for (i, to) in left.iter_mut().enumerate() {
                    *to = row[mirrored(i as isize - PAD as isize, width)];
                }
                for (i, to) in right.iter_mut().enumerate() {
                    *to = row[mirrored((width + i) as isize, width)];
                }
            }
        }
        for y in (-(PAD as isize)..0).chain(height as isize..(height + PAD) as isize) {
            let from = (mirrored(y, height) + PAD) * self.stride;
            let to = (y + PAD as isize) as usize * self.stride;
            self.data.copy_within(from..from + self.stride, to);
        }
    }
}

/// The index inside `0..n` that mirrors `i` about the first and the last.
fn mirrored(i: isize, n: usize) -> usize {
    if n == 1 {
        return 0;
    }
    let period = 2 * (n as isize - 1);
    let i = i.rem_euclid(period);
    i.min(period - i) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    #[test]
    fn the_border_mirrors_the_image_whatever_its_size() {
        for (width, height) in [(1, 1), (2, 5), (9, 4), (33, 70), (80, 40)] {
            let image = GrayImage::from_fn(width, height, |x, y| (x * 7 + y * 13) as u8).unwrap();
            let plane = Plane::new(image.view());
            let pad = PAD as isize;
            for y in -pad..height as isize + pad {
                for x in -pad..width as isize + pad {
                    let expected = mirrored(x, width) * 7 + mirrored(y, height) * 13;
                    assert_eq!(plane.run(x, y, 1)[0], expected as u8, "{width} x {height} at {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn mirroring_leaves_out_the_edge_itself() {
        let seen: Vec<usize> = (-3..7).map(|i| mirrored(i, 4)).collect();
        assert_eq!(seen, [3, 2, 1, 0, 1, 2, 3, 2, 1, 0]);
    }
}
