//! An image file, PNG or JPEG, to grey.
//!
//! Colours are weighed as [`PixelLayout`] says; of a JPEG the luminance is taken as it is stored, which has the same weights (JFIF). The size is known
//! beforehand, from the camera's calibration: a head that says another makes no room.

use super::IoError;
use super::grey::{PixelLayout, bad};
use dpn_core::image::GrayImage;
use png::{ColorType, Decoder, Transformations};
use std::io::Cursor;
use std::path::Path;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Larger files are no camera's images \[bytes\]: an image is read whole.
const LARGEST_FILE: u64 = 256 << 20;
/// Deflate makes at most so many bytes of one: a file with fewer bytes than its pixels ask for is cut off, whatever its head says.
const DEFLATE_MOST: usize = 1032;
/// A JPEG has at least a bit for 8 x 8 pixels; its decoder makes room for all of them at once.
const JPEG_MOST: usize = 512;
/// Behind a JPEG's end some cameras leave so many bytes at most.
const BEHIND_JPEG: usize = 4096;

/// Reads an image file of `size` \[width, height\].
///
/// # Errors
/// A file that is not there or cannot be read; what [`parse_image`] refuses.
pub(crate) fn read_image(path: &Path, size: [usize; 2]) -> Result<GrayImage, IoError> {
    let length = std::fs::metadata(path).map_err(|e| IoError::reading(path, e))?.len();
    if length > LARGEST_FILE {
        return Err(bad(path, format!("has {length} bytes; an image has at most {LARGEST_FILE}")));
    }
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse_image(&bytes, path, size)
}

/// The grey image in a file's bytes, `size` \[width, height\]; `path` is for messages. Room is made for an image of the right size alone, and for
/// none that so few bytes cannot hold.
///
/// # Errors
/// Neither PNG nor JPEG, damaged, cut off, of another size.
pub fn parse_image(bytes: &[u8], path: &Path, size: [usize; 2]) -> Result<GrayImage, IoError> {
    let image = if bytes.starts_with(&[0xff, 0xd8]) { jpeg(bytes, size) } else { png(bytes, size) };
    image.map_err(|problem| bad(path, problem))
}

fn png(bytes: &[u8], size: [usize; 2]) -> Result<GrayImage, String> {
    let unreadable = |error: png::DecodingError| format!("is no readable PNG or JPEG: {error}");
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(unreadable)?;
    right_size([reader.info().width as usize, reader.info().height as usize], size)?;
    let bits = reader.info().bit_depth as usize * reader.info().color_type.samples();
    if size[0].saturating_mul(size[1]).saturating_mul(bits) / 8 / DEFLATE_MOST > bytes.len() {
        return Err(cut_off(bytes.len(), size));
    }
    let layout = match reader.output_color_type().0 {
        ColorType::Grayscale => PixelLayout::Grey8,
        ColorType::GrayscaleAlpha => PixelLayout::Colour { bytes: 2, rgb: [0; 3] },
        ColorType::Rgb => PixelLayout::rgb(3),
        ColorType::Rgba => PixelLayout::rgb(4),
        ColorType::Indexed => return Err("has a palette that is not there".to_owned()),
    };
    let needed = reader.output_buffer_size().ok_or_else(|| format!("has {} x {} px", size[0], size[1]))?;
    let mut pixels = vec![0; needed];
    let frame = reader.next_frame(&mut pixels).map_err(unreadable)?;
    match layout {
        PixelLayout::Grey8 => GrayImage::new(size[0], size[1], pixels).map_err(|error| format!("is {error}")),
        colour => colour.grey(&pixels, size, frame.line_size),
    }
}

fn jpeg(bytes: &[u8], size: [usize; 2]) -> Result<GrayImage, String> {
    let unreadable = |error: DecodeErrors| {
        // The decoder's words may have several lines.
        let words = format!("{error:?}").split_whitespace().collect::<Vec<_>>().join(" ");
        format!("is no readable JPEG: {}", super::printable(&words))
    };
    // The head makes no room: a wrong size is to be said with both sizes, and is refused before pixels are read.
    let options = DecoderOptions::default()
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let found =
        |decoder: &JpegDecoder<_>| decoder.info().map(|i| [usize::from(i.width), usize::from(i.height)]);
    let head = decoder.decode_headers();
    if let Some(found) = found(&decoder) {
        right_size(found, size)?;
    }
    head.map_err(unreadable)?;
    let tail = &bytes[bytes.len().saturating_sub(BEHIND_JPEG)..];
    // The decoder fills with grey what is missing.
    if !tail.windows(2).any(|pair| pair == [0xff, 0xd9])
        || size[0].saturating_mul(size[1]) / JPEG_MOST > bytes.len()
    {
        return Err(cut_off(bytes.len(), size));
    }
    // What is not stored as luminance and colour differences must be weighed.
    let is_luma = matches!(decoder.input_colorspace(), Some(ColorSpace::YCbCr | ColorSpace::Luma));
    if !is_luma {
        decoder.set_options(options.jpeg_set_out_colorspace(ColorSpace::RGB));
    }
    let pixels = decoder.decode().map_err(unreadable)?;
    if is_luma {
        return GrayImage::new(size[0], size[1], pixels).map_err(|error| format!("is {error}"));
    }
    PixelLayout::rgb(3).grey(&pixels, size, 3 * size[0])
}

fn right_size([width, height]: [usize; 2], size: [usize; 2]) -> Result<(), String> {
    match [width, height] == size {
        true => Ok(()),
        false => Err(format!("has {width} x {height} px; the camera's have {} x {}", size[0], size[1])),
    }
}

fn cut_off(bytes: usize, [width, height]: [usize; 2]) -> String {
    format!("is cut off: {bytes} bytes hold no {width} x {height} px")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use png::BitDepth;
    use std::path::PathBuf;

    fn encode(width: u32, height: u32, colour: ColorType, depth: BitDepth, pixels: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        bytes
    }

    /// A PNG of 4 x 3 px.
    pub(crate) fn grey(seed: u8) -> Vec<u8> {
        let pixels: Vec<u8> = (0..12).map(|i| i * 7 + seed).collect();
        encode(4, 3, ColorType::Grayscale, BitDepth::Eight, &pixels)
    }

    #[test]
    fn every_kind_of_png_becomes_grey() {
        let pixels =
            |bytes: &[u8], size| parse_image(bytes, Path::new("a.png"), size).unwrap().pixels().to_vec();
        let deep = encode(2, 1, ColorType::Grayscale, BitDepth::Sixteen, &[1, 2, 3, 4]);
        assert_eq!(pixels(&deep, [2, 1]), [1, 3]);
        let two_bits = encode(4, 1, ColorType::Grayscale, BitDepth::Two, &[0b0001_1011]);
        assert_eq!(pixels(&two_bits, [4, 1]), [0, 85, 170, 255]);
        let alpha = encode(2, 1, ColorType::GrayscaleAlpha, BitDepth::Eight, &[7, 0, 255, 9]);
        assert_eq!(pixels(&alpha, [2, 1]), [7, 255]);
        // BT.601 by hand: .299, .587, .114 of 255.
        let colour = encode(3, 1, ColorType::Rgb, BitDepth::Eight, &[255, 0, 0, 0, 255, 0, 0, 0, 255]);
        assert_eq!(pixels(&colour, [3, 1]), [76, 150, 29]);
        let colour = encode(1, 1, ColorType::Rgba, BitDepth::Sixteen, &[255, 0, 9, 9, 0, 0, 1, 1]);
        assert_eq!(pixels(&colour, [1, 1]), [(0.299f64 * 255.0 + 0.587 * 9.0).round() as u8]);
    }

    #[test]
    fn what_is_no_image_is_named() {
        let error = |bytes: &[u8]| parse_image(bytes, Path::new("a.png"), [4, 3]).unwrap_err().to_string();
        let whole = grey(1);
        assert!(error(&whole[..whole.len() - 20]).starts_with("a.png is no readable PNG"), "cut off");
        assert!(error(b"<html>not found</html>").starts_with("a.png is no readable PNG or JPEG"));
        assert!(error(b"").starts_with("a.png is no readable PNG"));
        assert!(error(b"\xff\xd8\xff\xe0nothing").starts_with("a.png is no readable JPEG"));
    }

    /// 64 x 48 px, by another program.
    fn golden(name: &str) -> Vec<u8> {
        std::fs::read(
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/rigs/folder_jpeg/images").join(name),
        )
        .unwrap()
    }

    #[test]
    fn a_jpeg_that_is_cut_off_or_too_large_is_refused_before_there_is_room_for_it() {
        let whole = golden("0.jpg");
        let parse =
            |bytes: &[u8], size| parse_image(bytes, &PathBuf::from("a.jpg"), size).map_err(|e| e.to_string());
        assert!(parse(&whole, [64, 48]).is_ok());
        let error = parse(&whole[..whole.len() - 60], [64, 48]).unwrap_err();
        assert!(error.starts_with("a.jpg is cut off: "), "{error}");
        let error = parse(&whole, [63, 48]).unwrap_err();
        assert!(error.starts_with("a.jpg "), "{error}");
        assert_eq!(parse(&whole, [128, 48]).unwrap_err(), "a.jpg has 64 x 48 px; the camera's have 128 x 48");
        // A head that says 65535 x 65535 px, to a calibration that says so too.
        let mut giant = whole;
        let at = giant.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        giant[at + 5..at + 9].fill(0xff);
        let error = parse(&giant, [65535, 65535]).unwrap_err();
        assert!(error.contains("bytes hold no 65535 x 65535 px"), "{error}");
    }

    #[test]
    fn no_damage_of_a_jpeg_makes_the_reader_panic() {
        let whole = golden("0.jpg");
        for at in 0..whole.len() {
            for value in [0, 1, 0x7f, 0xc4, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                if let Err(error) = parse_image(&damaged, Path::new("a.jpg"), [64, 48]) {
                    let said = error.to_string();
                    assert!(said.starts_with("a.jpg") && !said.contains('\n'), "{said}");
                }
            }
            let _ = parse_image(&whole[..at], Path::new("a.jpg"), [64, 48]);
        }
    }

    #[test]
    fn no_damage_makes_the_reader_panic() {
        let whole = grey(5);
        for at in 0..whole.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                if let Err(error) = parse_image(&damaged, Path::new("a.png"), [4, 3]) {
                    assert!(error.to_string().starts_with("a.png") && error.hint().is_some());
                }
                let _ = parse_image(&damaged[..at], Path::new("a.png"), [4, 3]);
            }
        }
    }

    #[test]
    fn a_head_that_says_more_than_the_file_holds_makes_no_room() {
        let mut giant = Vec::new();
        let mut encoder = png::Encoder::new(&mut giant, 65535, 65535);
        encoder.set_color(ColorType::Grayscale);
        drop(encoder.write_header().unwrap());
        // A head ends behind byte 33.
        giant.truncate(33);
        giant.extend_from_slice(&grey(1)[33..]);
        let error = |size| parse_image(&giant, Path::new("a.png"), size).unwrap_err().to_string();
        assert_eq!(error([4, 3]), "a.png has 65535 x 65535 px; the camera's have 4 x 3");
        // The calibration may say the same.
        let said = format!("a.png is cut off: {} bytes hold no 65535 x 65535 px", giant.len());
        assert_eq!(error([65535, 65535]), said);
    }
}
