//! Grey images of 8 bits a pixel.
//!
//! Rows from the top, pixels from the left; the centre of the first pixel is at `(0, 0)`, as in [`crate::camera`].

use thiserror::Error;

/// Bytes that do not make an image of the size they were said to have.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum ImageError {
    /// An image without pixels.
    #[error("an image of {width} x {height} px")]
    Empty {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Rows that overlap.
    #[error("rows of {width} px cannot begin {stride} bytes apart")]
    Stride {
        /// Columns.
        width: usize,
        /// Bytes from one row's begin to the next.
        stride: usize,
    },
    /// Too few bytes, or too many for an image that owns them.
    #[error("{found} bytes for an image of {width} x {height} px, which needs {needed}")]
    Length {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        needed: usize,
    },
}

/// A grey image that owns its pixels, row after row without gaps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GrayImage {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl GrayImage {
    /// An image of `width * height` pixels.
    ///
    /// # Errors
    /// No pixel; another number of bytes.
    pub fn new(width: usize, height: usize, pixels: Vec<u8>) -> Result<Self, ImageError> {
        let needed = checked_size(width, height)?;
        if pixels.len() != needed {
            return Err(ImageError::Length { width, height, found: pixels.len(), needed });
        }
        Ok(Self { width, height, pixels })
    }

    /// An image whose pixel in column `x` and row `y` is `value(x, y)`.
    ///
    /// # Errors
    /// No pixel.
    pub fn from_fn(
        width: usize,
        height: usize,
        mut value: impl FnMut(usize, usize) -> u8,
    ) -> Result<Self, ImageError> {
        let mut pixels = Vec::with_capacity(checked_size(width, height)?);
        for y in 0..height {
            pixels.extend((0..width).map(|x| value(x, y)));
        }
        Ok(Self { width, height, pixels })
    }

    /// The image with `times` as few columns and rows: each pixel the mean of a square, what is left over at the right and below cut off.
    ///
    /// # Panics
    /// An image smaller than one such square.
    #[must_use]
    pub fn reduced(self, times: usize) -> Self {
        // A number that the compiler knows makes vectors of the loops.
        let pixels = match times {
            1 => return self,
            2 => self.means(2),
            3 => self.means(3),
            4 => self.means(4),
            _ => self.means(times),
        };
        let (width, height) = (self.width / times, self.height / times);
        Self::new(width, height, pixels).expect("a square at least")
    }

    /// Rounded means of squares of `times` pixels a side.
    #[inline(always)]
    fn means(&self, times: usize) -> Vec<u8> {
        let (width, height) = (self.width / times, self.height / times);
        let count = (times * times) as u32;
        let mut sums = vec![0; width];
        let mut pixels = Vec::with_capacity(width * height);
        for rows in self.pixels.chunks_exact(times * self.width).take(height) {
            sums.fill(count / 2);
            for row in rows.chunks_exact(self.width) {
                for (sum, part) in sums.iter_mut().zip(row.chunks_exact(times)) {
                    *sum += part.iter().map(|value| u32::from(*value)).sum::<u32>();
                }
            }
            pixels.extend(sums.iter().map(|sum| (sum / count) as u8));
        }
        pixels
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row after row.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.pixels
    }

    /// The image, borrowed.
    pub fn view(&self) -> GrayView<'_> {
        GrayView { width: self.width, height: self.height, stride: self.width, pixels: &self.pixels }
    }
}

/// A grey image in somebody else's memory; its rows may lie apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GrayView<'a> {
    width: usize,
    height: usize,
    stride: usize,
    pixels: &'a [u8],
}

impl<'a> GrayView<'a> {
    /// `height` rows of `width` pixels that begin `stride` bytes apart; what lies behind a row, or behind the last, is never read.
    ///
    /// # Errors
    /// No pixel, overlapping rows, too few bytes.
    pub fn new(width: usize, height: usize, stride: usize, pixels: &'a [u8]) -> Result<Self, ImageError> {
        checked_size(width, height)?;
        if stride < width {
            return Err(ImageError::Stride { width, stride });
        }
        let needed = stride.saturating_mul(height - 1).saturating_add(width);
        if pixels.len() < needed {
            return Err(ImageError::Length { width, height, found: pixels.len(), needed });
        }
        Ok(Self { width, height, stride, pixels })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Row `y`, counted from the top.
    ///
    /// # Panics
    /// `y` is not below the height.
    pub fn row(&self, y: usize) -> &'a [u8] {
        &self.pixels[y * self.stride..][..self.width]
    }

    /// Every row from the top.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &'a [u8]> + use<'a> {
        let view = *self;
        (0..self.height).map(move |y| view.row(y))
    }

    /// A copy that owns its pixels.
    pub fn to_image(&self) -> GrayImage {
        let mut pixels = Vec::with_capacity(self.width * self.height);
        self.rows().for_each(|row| pixels.extend_from_slice(row));
        GrayImage { width: self.width, height: self.height, pixels }
    }
}

fn checked_size(width: usize, height: usize) -> Result<usize, ImageError> {
    width.checked_mul(height).filter(|size| *size > 0).ok_or(ImageError::Empty { width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_image_has_the_means_of_squares_and_what_is_left_over_is_cut_off() {
        let image = GrayImage::from_fn(5, 7, |x, y| (10 * x + 3 * y) as u8).unwrap();
        assert_eq!(image.clone().reduced(1), image);
        let half = image.reduced(2);
        assert_eq!((half.width(), half.height()), (2, 3));
        // 0, 10, 3, 13: 6.5, rounded up.
        assert_eq!(half.pixels(), [7, 27, 13, 33, 19, 39]);
    }

    #[test]
    fn a_view_with_a_stride_sees_the_same_rows_as_a_copy() {
        let bytes: Vec<u8> = (0..17).collect();
        let view = GrayView::new(3, 3, 7, &bytes).unwrap();
        assert_eq!(view.row(2), [14, 15, 16]);
        assert_eq!(view.to_image().pixels(), [0, 1, 2, 7, 8, 9, 14, 15, 16]);
        assert_eq!(view.to_image().view().row(1), view.row(1));
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        assert_eq!(
            GrayImage::new(2, 2, vec![0; 5]),
            Err(ImageError::Length { width: 2, height: 2, found: 5, needed: 4 })
        );
        assert_eq!(GrayImage::new(0, 2, vec![]), Err(ImageError::Empty { width: 0, height: 2 }));
        assert_eq!(GrayView::new(3, 2, 2, &[0; 9]), Err(ImageError::Stride { width: 3, stride: 2 }));
        assert!(GrayView::new(3, 2, 7, &[0; 9]).is_err() && GrayView::new(3, 2, 6, &[0; 9]).is_ok());
        assert!(GrayView::new(usize::MAX, 2, usize::MAX, &[0; 9]).is_err());
    }
}
