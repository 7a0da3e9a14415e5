//! Pixels of cameras, made grey.
//!
//! Colour becomes grey by ITU-R BT.601's weights, Y = 0.299 R + 0.587 G + 0.114 B, in OpenCV's fixed point (15 bits for colours, 14 for
//! colour filters) and therefore to its bits. Of 16 bits a pixel the upper 8 are taken. A colour filter (Bayer) is interpolated between its nearest
//! neighbours; the outermost pixels are those beside them. Of YUV the Y is taken as it is.

use super::IoError;
use dpn_core::image::GrayImage;
use std::path::Path;

/// Weights of red, green and blue, and how far their sum is shifted.
const COLOUR: ([u32; 3], u32) = ([9798, 19235, 3735], 15);
/// The same for colour filters.
const FILTER: ([u32; 3], u32) = ([4899, 9617, 1868], 14);

/// How a camera's pixels lie in its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelLayout {
    /// A byte a pixel.
    Grey8,
    /// Two bytes a pixel.
    Grey16(ByteOrder),
    /// So many bytes a pixel, of which red, green and blue are at these places.
    Colour {
        /// Bytes a pixel.
        bytes: usize,
        /// Places of red, green and blue.
        rgb: [usize; 3],
    },
    /// A colour filter: red at this column and row of its two by two pixels, blue opposite.
    Filter8([usize; 2]),
    /// The same, two bytes a pixel.
    Filter16([usize; 2], ByteOrder),
    /// Two bytes a pixel, of which Y is this one.
    Yuv422(usize),
}

/// Which byte of two comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lower one.
    Little,
    /// The upper one.
    Big,
}

impl PixelLayout {
    /// ROS' names of what is known, as `sensor_msgs/Image` has them.
    pub const KNOWN: &str = "mono8, mono16, rgb8, bgr8, rgba8, bgra8, bayer_rggb8, bayer_bggr8, bayer_gbrg8, bayer_grbg8, their 16-bit kin, yuv422, yuv422_yuy2, 8UC1, 16UC1";

    /// Red, green, blue, and perhaps an alpha behind.
    pub(crate) fn rgb(bytes: usize) -> Self {
        Self::Colour { bytes, rgb: [0, 1, 2] }
    }

    /// What ROS calls `name`; `None` where that is not known.
    pub fn of_ros(name: &str, order: ByteOrder) -> Option<Self> {
        let bgr = |bytes| Self::Colour { bytes, rgb: [2, 1, 0] };
        let filter = |kind: &str| {
            Some(
                [("rggb", [0, 0]), ("bggr", [1, 1]), ("gbrg", [0, 1]), ("grbg", [1, 0])]
                    .into_iter()
                    .find(|(name, _)| *name == kind)?
                    .1,
            )
        };
        Some(match name {
            "mono8" | "8UC1" => Self::Grey8,
            "mono16" | "16UC1" => Self::Grey16(order),
            "rgb8" => Self::rgb(3),
            "rgba8" => Self::rgb(4),
            "bgr8" => bgr(3),
            "bgra8" => bgr(4),
            "yuv422" | "uyvy" => Self::Yuv422(1),
            "yuv422_yuy2" | "yuyv" => Self::Yuv422(0),
            _ => match name.strip_prefix("bayer_")? {
                kind if kind.ends_with('8') => Self::Filter8(filter(kind.strip_suffix('8')?)?),
                kind => Self::Filter16(filter(kind.strip_suffix("16")?)?, order),
            },
        })
    }

    /// Bytes a pixel.
    pub fn bytes(self) -> usize {
        match self {
            Self::Grey8 | Self::Filter8(_) => 1,
            Self::Grey16(_) | Self::Filter16(..) | Self::Yuv422(_) => 2,
            Self::Colour { bytes, .. } => bytes,
        }
    }

    /// The grey image of `size` \[width, height\] in `data`, whose rows begin `step` bytes apart; `path` and `what` are for messages. Room is made for
    /// what is there alone.
    ///
    /// # Errors
    /// A step smaller than a row; fewer bytes than rows.
    pub fn grey(self, data: &[u8], size: [usize; 2], step: usize) -> Result<GrayImage, String> {
        let [width, height] = size;
        let row = width.checked_mul(self.bytes()).ok_or_else(|| format!("has {width} x {height} px"))?;
        if step < row {
            return Err(format!("has rows of {width} px, which are {row} bytes, but a step of {step} bytes"));
        }
        let needed = step.checked_mul(height.saturating_sub(1)).and_then(|all| all.checked_add(row));
        if needed.is_none_or(|needed| needed > data.len()) || row == 0 {
            let found = data.len();
            return Err(format!(
                "is cut off: {found} bytes hold no {width} x {height} px in rows of {step} bytes"
            ));
        }
        let rows = data.chunks(step).take(height).map(|bytes| &bytes[..row]);
        let mut pixels = Vec::with_capacity(width * height);
        match self {
            Self::Grey8 | Self::Filter8(_) => rows.for_each(|row| pixels.extend_from_slice(row)),
            Self::Grey16(order) | Self::Filter16(_, order) => {
                let upper = usize::from(order == ByteOrder::Little);
                rows.for_each(|row| pixels.extend(row.chunks_exact(2).map(|pair| pair[upper])));
            }
            Self::Yuv422(at) => rows.for_each(|row| pixels.extend(row.chunks_exact(2).map(|pair| pair[at]))),
            Self::Colour { bytes, rgb: [r, g, b] } => {
                let ([red, green, blue], shift) = COLOUR;
                let weigh =
                    |p: &[u8]| red * u32::from(p[r]) + green * u32::from(p[g]) + blue * u32::from(p[b]);
                let grey = |p: &[u8]| ((weigh(p) + (1 << (shift - 1))) >> shift) as u8;
                rows.for_each(|row| pixels.extend(row.chunks_exact(bytes).map(grey)));
            }
        }
        if let Self::Filter8(red) | Self::Filter16(red, _) = self {
            pixels = interpolated(&pixels, size, red)?;
        }
        GrayImage::new(width, height, pixels).map_err(|error| format!("is {error}"))
    }
}

/// A colour filter's grey: at every pixel its own colour four times, the others' nearest neighbours, weighed.
fn interpolated(raw: &[u8], [width, height]: [usize; 2], red: [usize; 2]) -> Result<Vec<u8>, String> {
    if width < 3 || height < 3 {
        return Err(format!("has {width} x {height} px behind a colour filter, too few to interpolate"));
    }
    let ([weight_r, weight_g, weight_b], shift) = FILTER;
    let mut grey = vec![0; raw.len()];
    for y in 1..height - 1 {
        let above = &raw[(y - 1) * width..y * width];
        let here = &raw[y * width..(y + 1) * width];
        let below = &raw[(y + 1) * width..(y + 2) * width];
        let red_row = y % 2 == red[1];
        // The filter's colour in this row that is not green.
        let (own, other) = if red_row { (weight_r, weight_b) } else { (weight_b, weight_r) };
        for x in 1..width - 1 {
            let at = |row: &[u8], x: usize| u32::from(row[x]);
            let beside = at(here, x - 1) + at(here, x + 1);
            let upright = at(above, x) + at(below, x);
            let is_green = (x % 2 == red[0]) != red_row;
            let sum = if is_green {
                4 * weight_g * at(here, x) + 2 * own * beside + 2 * other * upright
            } else {
                let corners = at(above, x - 1) + at(above, x + 1) + at(below, x - 1) + at(below, x + 1);
                4 * own * at(here, x) + weight_g * (beside + upright) + other * corners
            };
            grey[y * width + x] = ((sum + (1 << (shift + 1))) >> (shift + 2)) as u8;
        }
        grey[y * width] = grey[y * width + 1];
        grey[(y + 1) * width - 1] = grey[(y + 1) * width - 2];
    }
    grey.copy_within(width..2 * width, 0);
    let last = (height - 1) * width;
    grey.copy_within(last - width..last, last);
    Ok(grey)
}

/// The error of an image that is not the camera's.
pub(crate) fn bad(path: &Path, problem: impl Into<String>) -> IoError {
    IoError::BadImage { path: path.to_path_buf(), problem: problem.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grey_pixel_is_itself_in_every_layout() {
        let names = PixelLayout::KNOWN.split(", ").filter(|name| !name.starts_with("their"));
        for name in names.chain(["bayer_rggb16", "bayer_grbg16"]) {
            for order in [ByteOrder::Little, ByteOrder::Big] {
                let layout = PixelLayout::of_ros(name, order).unwrap();
                for value in [0, 1, 77, 128, 254, 255] {
                    let data = vec![value; 6 * 4 * layout.bytes()];
                    let grey = layout.grey(&data, [6, 4], 6 * layout.bytes()).unwrap();
                    assert!(grey.pixels().iter().all(|p| *p == value), "{name} {value}");
                }
            }
        }
        assert_eq!(PixelLayout::of_ros("32FC1", ByteOrder::Little), None);
        assert_eq!(PixelLayout::of_ros("bayer_rggb12", ByteOrder::Little), None);
    }

    #[test]
    fn the_upper_byte_of_two_is_where_the_order_says() {
        let grey =
            |order| PixelLayout::Grey16(order).grey(&[1, 2, 3, 4, 9], [2, 1], 5).unwrap().pixels().to_vec();
        assert_eq!((grey(ByteOrder::Little), grey(ByteOrder::Big)), (vec![2, 4], vec![1, 3]));
    }

    #[test]
    fn rows_may_lie_apart_and_a_step_below_a_row_is_named() {
        let data: Vec<u8> = (0..8).collect();
        let grey =
            |size, step| PixelLayout::Grey8.grey(&data, size, step).map(|image| image.pixels().to_vec());
        assert_eq!(grey([3, 2], 5).unwrap(), [0, 1, 2, 5, 6, 7]);
        assert_eq!(
            grey([3, 2], 2).unwrap_err(),
            "has rows of 3 px, which are 3 bytes, but a step of 2 bytes"
        );
        assert_eq!(grey([3, 3], 3).unwrap_err(), "is cut off: 8 bytes hold no 3 x 3 px in rows of 3 bytes");
        assert!(grey([3, usize::MAX], 3).is_err() && grey([0, 2], 0).is_err() && grey([2, 0], 2).is_err());
        assert!(PixelLayout::rgb(3).grey(&data, [usize::MAX / 2, 1], usize::MAX).is_err());
        assert!(PixelLayout::Filter8([0, 0]).grey(&data, [2, 4], 2).unwrap_err().contains("too few"));
    }
}
