//! `sensor_msgs/Image` and `sensor_msgs/CompressedImage` from their bytes.
//!
//! Image: header, height, width, encoding, order of bytes, step, pixels behind their length. CompressedImage: header, format, a PNG or JPEG behind
//! its length, told by its first bytes; what the format says of it is passed over. Source: sensor_msgs/Image.msg, CompressedImage.msg.

use crate::fields::{Encoding, Fields, Undecodable};
use dpn_core::GrayImage;
use dpn_io::{ByteOrder, IoError, PixelLayout, parse_image, printable};
use std::path::Path;

/// The two types of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageKind {
    /// `sensor_msgs/Image`.
    Raw,
    /// `sensor_msgs/CompressedImage`.
    Compressed,
}

impl ImageKind {
    /// By a type's name in ROS 1 or 2; `None` for all other types.
    pub(crate) fn of(name: &str) -> Option<Self> {
        match name {
            "sensor_msgs/Image" | "sensor_msgs/msg/Image" => Some(Self::Raw),
            "sensor_msgs/CompressedImage" | "sensor_msgs/msg/CompressedImage" => Some(Self::Compressed),
            _ => None,
        }
    }
}

/// One message; its pixels are not looked at yet.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageMessage<'a> {
    /// The header's stamp; 0 where it has none.
    pub t_ns: i64,
    body: Body<'a>,
}

#[derive(Debug, Clone, PartialEq)]
enum Body<'a> {
    Raw { size: [usize; 2], encoding: String, order: ByteOrder, step: usize, data: &'a [u8] },
    Compressed(&'a [u8]),
}

/// Reads a message.
///
/// # Errors
/// One that is too short or in no known representation.
pub fn decode(data: &[u8], encoding: Encoding, kind: ImageKind) -> Result<ImageMessage<'_>, Undecodable> {
    let mut fields = Fields::new(data, encoding)?;
    message(&mut fields, kind).ok_or(Undecodable::Short)
}

fn message<'a>(fields: &mut Fields<'a>, kind: ImageKind) -> Option<ImageMessage<'a>> {
    let t_ns = fields.header()?.t_ns;
    let body = match kind {
        ImageKind::Raw => {
            let (height, width) = (fields.u32()? as usize, fields.u32()? as usize);
            let encoding = fields.text()?;
            let order = if fields.u8()? == 0 { ByteOrder::Little } else { ByteOrder::Big };
            let step = fields.u32()? as usize;
            Body::Raw { size: [width, height], encoding, order, step, data: fields.counted()? }
        }
        ImageKind::Compressed => {
            let _format = fields.counted()?;
            Body::Compressed(fields.counted()?)
        }
    };
    Some(ImageMessage { t_ns, body })
}

impl ImageMessage<'_> {
    /// The image, grey, which is to have `size` \[width, height\]; `path` is for messages. Room is made for an image of that size alone.
    ///
    /// # Errors
    /// An encoding that is not known; another size; a step smaller than a row; fewer bytes than pixels; no readable PNG or JPEG.
    pub fn grey(&self, path: &Path, size: [usize; 2]) -> Result<GrayImage, IoError> {
        let bad = |problem| IoError::BadImage { path: path.to_path_buf(), problem };
        match &self.body {
            Body::Compressed(data) => parse_image(data, path, size),
            Body::Raw { size: [width, height], encoding, order, step, data } => {
                let layout = PixelLayout::of_ros(encoding, *order).ok_or_else(|| {
                    let name: String = encoding.chars().take(40).collect();
                    bad(format!("is encoded as `{}`; known are {}", printable(&name), PixelLayout::KNOWN))
                })?;
                if [*width, *height] != size {
                    let [w, h] = size;
                    return Err(bad(format!("has {width} x {height} px; the camera's have {w} x {h}")));
                }
                layout.grey(data, size, *step).map_err(bad)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(body: &mut Vec<u8>, text: &[u8]) {
        body.extend((text.len() as u32).to_le_bytes());
        body.extend(text);
    }

    /// A message in ROS 1's encoding.
    fn raw(size: [u32; 2], encoding: &str, step: u32, pixels: &[u8]) -> Vec<u8> {
        let mut body = [7u32, 5, 9].map(u32::to_le_bytes).concat();
        text(&mut body, b"cam");
        body.extend([size[1], size[0]].map(u32::to_le_bytes).concat());
        text(&mut body, encoding.as_bytes());
        body.push(0);
        body.extend(step.to_le_bytes());
        text(&mut body, pixels);
        body
    }

    fn grey(message: &[u8], size: [usize; 2]) -> Result<Vec<u8>, String> {
        let message = decode(message, Encoding::Ros1, ImageKind::Raw).map_err(|e| e.to_string())?;
        let image = message.grey(Path::new("a.bag"), size).map_err(|e| e.to_string())?;
        Ok(image.pixels().to_vec())
    }

    #[test]
    fn what_cannot_be_used_is_named_with_what_can() {
        let whole = raw([3, 2], "mono8", 4, &[1, 2, 3, 0, 4, 5, 6, 0]);
        assert_eq!(grey(&whole, [3, 2]).unwrap(), [1, 2, 3, 4, 5, 6]);
        assert_eq!(decode(&whole, Encoding::Ros1, ImageKind::Raw).unwrap().t_ns, 5_000_000_009);
        assert_eq!(grey(&whole[..whole.len() - 1], [3, 2]).unwrap_err(), "end before their fields do");
        assert_eq!(grey(&whole, [2, 3]).unwrap_err(), "a.bag has 3 x 2 px; the camera's have 2 x 3");
        let error = grey(&raw([3, 2], "32FC1", 12, &[0; 24]), [3, 2]).unwrap_err();
        assert!(error.starts_with("a.bag is encoded as `32FC1`; known are mono8, "), "{error}");
        let error = grey(&raw([3, 2], "bgr8", 8, &[0; 18]), [3, 2]).unwrap_err();
        assert_eq!(error, "a.bag has rows of 3 px, which are 9 bytes, but a step of 8 bytes");
        let error = grey(&raw([3, 2], "mono8", 3, &[0; 5]), [3, 2]).unwrap_err();
        assert_eq!(error, "a.bag is cut off: 5 bytes hold no 3 x 2 px in rows of 3 bytes");
    }
}
