//! A bitmap back-end for print: everything is drawn at twice the size and averaged down.
//!
//! plotters' bitmap back-end smooths lines but not the edges of thick ones, and its text drops each glyph's left bearing and
//! sits higher than in SVG. Here shapes go to that back-end at double size, and text is set with ab_glyph from the bundled
//! font, at the places where plotters' SVG puts it. So the PNG looks like the SVG.

use super::error::FigureError;
use super::letters;
use ab_glyph::{Font, FontRef};
use dpn_core::GrayImage;
use plotters::prelude::BitMapBackend;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

/// Pixels drawn per pixel kept, along each side.
const FINE: u32 = 2;

/// Memory of a bitmap of `size`: three bytes a pixel drawn.
pub(super) fn canvas(size: (u32, u32)) -> Vec<u8> {
    vec![0xFF; (size.0 * FINE * size.1 * FINE * 3) as usize]
}

/// A canvas that shows `image`, with `strip` white rows below it.
pub(super) fn canvas_over(image: &GrayImage, strip: usize) -> Vec<u8> {
    let (width, height, fine) = (image.width(), image.height(), FINE as usize);
    let mut canvas = vec![0xFF; width * fine * (height + strip) * fine * 3];
    let stride = width * fine * 3;
    for (y, row) in canvas.chunks_exact_mut(stride).take(height * fine).enumerate() {
        let pixels = &image.pixels()[y / fine * width..][..width];
        for (block, &grey) in row.chunks_exact_mut(3 * fine).zip(pixels) {
            block.fill(grey);
        }
    }
    canvas
}

/// Averages a canvas down to `size`: three bytes a pixel, rows from the top.
fn averaged(canvas: &[u8], size: (u32, u32)) -> Vec<u8> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    let fine = FINE as usize;
    let mut out = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let sum: u32 = (0..fine)
                    .flat_map(|dy| (0..fine).map(move |dx| (dx, dy)))
                    .map(|(dx, dy)| ((y * fine + dy) * width * fine + x * fine + dx) * 3 + channel)
                    .map(|at| u32::from(canvas[at]))
                    .sum();
                out.push(((sum + FINE * FINE / 2) / (FINE * FINE)) as u8);
            }
        }
    }
    out
}

/// A canvas as a PNG of `size`.
///
/// # Errors
/// [`FigureError::Draw`] if the encoder refuses.
pub(super) fn encoded(
    canvas: &[u8],
    size: (u32, u32),
    compression: png::Compression,
) -> Result<Vec<u8>, FigureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(compression);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&averaged(canvas, size)))
        .map_err(|error| FigureError::Draw { reason: error.to_string() })?;
    Ok(bytes)
}

/// The back-end; draws onto a [`canvas`].
pub(super) struct Raster<'a> {
    fine: BitMapBackend<'a>,
    font: FontRef<'static>,
    size: (u32, u32),
}

impl<'a> Raster<'a> {
    /// A back-end of `size` over `canvas`.
    pub(super) fn new(canvas: &'a mut [u8], size: (u32, u32)) -> Self {
        Self {
            fine: BitMapBackend::with_buffer(canvas, (size.0 * FINE, size.1 * FINE)),
            font: letters::font(),
            size,
        }
    }
}

/// A style at the finer scale.
struct Fine {
    colour: BackendColor,
    width: u32,
}

impl Fine {
    fn of<S: BackendStyle>(style: &S) -> Self {
        Self { colour: style.color(), width: style.stroke_width() * FINE }
    }
}

impl BackendStyle for Fine {
    fn color(&self) -> BackendColor {
        self.colour
    }

    fn stroke_width(&self) -> u32 {
        self.width
    }
}

fn fine((x, y): BackendCoord) -> BackendCoord {
    (x * FINE as i32, y * FINE as i32)
}

type Failure<'a> = DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>;

impl<'a> DrawingBackend for Raster<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Result<(), Failure<'a>> {
        self.fine.ensure_prepared()
    }

    fn present(&mut self) -> Result<(), Failure<'a>> {
        Ok(())
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Result<(), Failure<'a>> {
        self.draw_rect(at, (at.0 + 1, at.1 + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), Failure<'a>> {
        self.fine.draw_line(fine(from), fine(to), &Fine::of(style))
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        a: BackendCoord,
        b: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), Failure<'a>> {
        self.fine.draw_rect(fine(a), fine(b), &Fine::of(style), fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), Failure<'a>> {
        self.fine.draw_path(path.into_iter().map(fine), &Fine::of(style))
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Result<(), Failure<'a>> {
        self.fine.draw_circle(fine(centre), radius * FINE, &Fine::of(style), fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        points: I,
        style: &S,
    ) -> Result<(), Failure<'a>> {
        self.fine.fill_polygon(points.into_iter().map(fine), &Fine::of(style))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Result<(), Failure<'a>> {
        let turn = style.transform();
        let (x0, y0) = fine(at);
        let colour = style.color();
        for glyph in letters::set(&self.font, text, style, f64::from(FINE)) {
            let Some(outline) = self.font.outline_glyph(glyph) else {
                continue; // a space
            };
            let corner = outline.px_bounds().min;
            let mut dots = Vec::new();
            outline.draw(|x, y, cover| dots.push((x as i32, y as i32, f64::from(cover))));
            for (x, y, cover) in dots {
                let (x, y) = turn.transform(x + corner.x as i32, y + corner.y as i32);
                self.fine.draw_pixel((x0 + x, y0 + y), colour.mix(cover.clamp(0.0, 1.0)))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plotters::style::{BLACK, Color};

    #[test]
    fn shapes_keep_their_size_and_edges_are_averaged() {
        let size = (8, 6);
        let mut memory = canvas(size);
        Raster::new(&mut memory, size).draw_rect((2, 1), (5, 4), &BLACK.filled(), true).unwrap();
        let pixels = averaged(&memory, size);
        let dark: Vec<usize> = (0..48).filter(|i| pixels[3 * i] == 0).collect();
        assert_eq!(dark, [10, 11, 12, 18, 19, 20, 26, 27, 28]);
        assert!(pixels.iter().all(|&v| v == 0 || v == 255));
    }
}
