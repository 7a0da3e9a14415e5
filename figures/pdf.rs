//! A PDF back-end: one page, shapes as plotters' SVG has them, letters as their outlines.
//!
//! Outlines, because journals refuse many an embedded font, and none need be looked for. Nothing in the file is of the hour or
//! the machine.

use super::error::FigureError;
use super::letters;
use super::style::WIDTH;
use ab_glyph::{Font, FontRef, OutlineCurve, Point};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::io::Write;

/// Points to a pixel: a figure is as wide as the text of a page, 170 mm.
const POINTS: f32 = 170.0 / 25.4 * 72.0 / WIDTH as f32;
/// SVG's limit of a corner's tip over the line's width; noise would have spikes without it.
const MITER: f32 = 4.0;
/// How far the handles of a quarter of a circle stand, over its radius.
const ROUND: f32 = 0.552_285;

/// A page that is drawn on, in pixels from its upper left corner.
pub(super) struct Page {
    size: (u32, u32),
    content: Content,
    /// Opacities that were asked for, in thousandths.
    opacities: BTreeSet<u16>,
}

impl Page {
    /// An empty page of `size` pixels.
    pub(super) fn new(size: (u32, u32)) -> Self {
        let mut content = Content::new();
        content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, POINTS * size.1 as f32]);
        content.set_miter_limit(MITER);
        Self { size, content, opacities: BTreeSet::new() }
    }

    /// What draws on it.
    pub(super) fn back_end(&mut self) -> Vector<'_> {
        Vector { page: self, font: letters::font() }
    }

    /// The file.
    ///
    /// # Errors
    /// [`FigureError::Draw`] if what was drawn cannot be compressed.
    pub(super) fn finish(self) -> Result<Vec<u8>, FigureError> {
        let [catalogue, pages, page, content] = [1, 2, 3, 4].map(Ref::new);
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        let packed = encoder
            .write_all(&self.content.finish())
            .and_then(|()| encoder.finish())
            .map_err(|error| FigureError::Draw { reason: error.to_string() })?;
        let mut pdf = Pdf::new();
        pdf.catalog(catalogue).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut sheet = pdf.page(page);
        let (width, height) = (POINTS * self.size.0 as f32, POINTS * self.size.1 as f32);
        sheet.parent(pages).contents(content).media_box(Rect::new(0.0, 0.0, width, height));
        let mut resources = sheet.resources();
        let mut states = resources.ext_g_states();
        for opacity in self.opacities {
            let share = f32::from(opacity) / 1000.0;
            let mut state = states
                .insert(Name(name(opacity).as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>();
            state.stroking_alpha(share).non_stroking_alpha(share);
        }
        states.finish();
        resources.finish();
        sheet.finish();
        pdf.stream(content, &packed).filter(Filter::FlateDecode);
        Ok(pdf.finish())
    }
}

/// What a page calls an opacity.
fn name(opacity: u16) -> String {
    format!("O{opacity}")
}

/// The back-end; draws onto a [`Page`].
pub(super) struct Vector<'a> {
    page: &'a mut Page,
    font: FontRef<'static>,
}

impl Vector<'_> {
    /// Where the next shape comes, in its colour and, where it is a line, of its width. Nothing where it cannot be seen.
    fn pen<S: BackendStyle>(&mut self, style: &S) -> Option<&mut Content> {
        let BackendColor { alpha, rgb: (r, g, b) } = style.color();
        let opacity = (alpha.clamp(0.0, 1.0) * 1000.0).round() as u16;
        if opacity == 0 {
            return None;
        }
        self.page.opacities.insert(opacity);
        let [r, g, b] = [r, g, b].map(|part| hundredths(f32::from(part) / 2.55) / 100.0);
        let content = &mut self.page.content;
        content.set_parameters(Name(name(opacity).as_bytes()));
        content.set_fill_rgb(r, g, b).set_stroke_rgb(r, g, b).set_line_width(style.stroke_width() as f32);
        Some(content)
    }
}

/// No file has more figures than can be seen: a hundredth of a pixel.
fn hundredths(value: f32) -> f32 {
    (value * 100.0).round() / 100.0
}

fn at((x, y): BackendCoord) -> (f32, f32) {
    (x as f32, y as f32)
}

/// Lines from point to point.
fn through(content: &mut Content, points: impl IntoIterator<Item = BackendCoord>) {
    for (n, point) in points.into_iter().enumerate() {
        let (x, y) = at(point);
        if n == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

/// Filled, or its edge alone.
fn ended(content: &mut Content, fill: bool) {
    if fill {
        content.fill_nonzero()
    } else {
        content.close_and_stroke()
    };
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Vector<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.page.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Done {
        self.draw_rect(at, (at.0 + 1, at.1 + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        a: BackendCoord,
        b: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        if let Some(content) = self.pen(style) {
            let ((x, y), (right, bottom)) = (at(a), at(b));
            content.rect(x, y, right - x, bottom - y);
            ended(content, fill);
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        if let Some(content) = self.pen(style) {
            through(content, path);
            content.stroke();
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        if let Some(content) = self.pen(style) {
            let ((x, y), r) = (at(centre), radius as f32);
            let h = hundredths(r * ROUND);
            content.move_to(x + r, y);
            content.cubic_to(x + r, y + h, x + h, y + r, x, y + r);
            content.cubic_to(x - h, y + r, x - r, y + h, x - r, y);
            content.cubic_to(x - r, y - h, x - h, y - r, x, y - r);
            content.cubic_to(x + h, y - r, x + r, y - h, x + r, y);
            ended(content, fill);
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        points: I,
        style: &S,
    ) -> Done {
        if let Some(content) = self.pen(style) {
            through(content, points);
            content.fill_nonzero();
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let font = self.font.clone();
        let Some(content) = self.pen(&style.color()) else { return Ok(()) };
        let turn = style.transform();
        // The turn's columns: what becomes of a step to the right, and of one down.
        let ((right_x, right_y), (down_x, down_y)) = (turn.transform(1, 0), turn.transform(0, 1));
        let [right_x, right_y, down_x, down_y] = [right_x, right_y, down_x, down_y].map(|v| v as f32);
        let mut drawn = false;
        for glyph in letters::set(&font, text, style, 1.0) {
            let Some(outline) = font.outline(glyph.id) else { continue }; // a space
            let scale = glyph.scale.y / font.height_unscaled();
            let place = |p: Point| {
                let (x, y) = (glyph.position.x + p.x * scale, glyph.position.y - p.y * scale);
                let (x, y) = (right_x * x + down_x * y, right_y * x + down_y * y);
                (hundredths(at.0 as f32 + x), hundredths(at.1 as f32 + y))
            };
            let mut last = None;
            for curve in outline.curves {
                let (from, to) = match curve {
                    OutlineCurve::Line(from, to)
                    | OutlineCurve::Quad(from, _, to)
                    | OutlineCurve::Cubic(from, _, _, to) => (from, to),
                };
                if last != Some(from) {
                    let (x, y) = place(from);
                    content.move_to(x, y);
                }
                last = Some(to);
                let (x, y) = place(to);
                let handles = match curve {
                    OutlineCurve::Line(..) => None,
                    OutlineCurve::Quad(_, middle, _) => {
                        let third = |end: Point| Point {
                            x: end.x + 2.0 / 3.0 * (middle.x - end.x),
                            y: end.y + 2.0 / 3.0 * (middle.y - end.y),
                        };
                        Some((place(third(from)), place(third(to))))
                    }
                    OutlineCurve::Cubic(_, first, second, _) => Some((place(first), place(second))),
                };
                match handles {
                    None => content.line_to(x, y),
                    Some(((x1, y1), (x2, y2))) => content.cubic_to(x1, y1, x2, y2, x, y),
                };
                drawn = true;
            }
        }
        if drawn {
            content.fill_nonzero();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::{self, Anchor};
    use plotters::drawing::IntoDrawingArea;
    use plotters::style::{BLACK, Color, RED};
    use std::io::Read;

    /// The objects of a file, each where the table of places at its end says, and what was drawn.
    fn read(bytes: &[u8]) -> (Vec<String>, String) {
        let text = String::from_utf8_lossy(bytes).into_owned();
        assert!(bytes.starts_with(b"%PDF-1.7\n") && text.trim_end().ends_with("%%EOF"));
        let last = text.trim_end().rsplit('\n').nth(1).unwrap();
        let table = std::str::from_utf8(&bytes[last.parse().unwrap()..]).unwrap();
        assert!(table.starts_with("xref\n0 5\n"), "{table}");
        let places: Vec<usize> =
            table.lines().skip(3).take(4).map(|line| line[..10].parse().unwrap()).collect();
        let objects: Vec<String> =
            places.iter().map(|&at| String::from_utf8_lossy(&bytes[at..]).into_owned()).collect();
        for (n, object) in objects.iter().enumerate() {
            assert!(object.starts_with(&format!("{} 0 obj", n + 1)), "{object}");
        }
        let begin = places[3] + objects[3].find("stream").unwrap() + "stream\n".len();
        let mut drawn = String::new();
        flate2::read::ZlibDecoder::new(&bytes[begin..]).read_to_string(&mut drawn).unwrap();
        (objects, drawn)
    }

    #[test]
    fn shapes_are_where_they_are_drawn_and_letters_are_curves() {
        let mut page = Page::new((1600, 400));
        {
            let area = page.back_end().into_drawing_area();
            area.draw(&plotters::element::PathElement::new(vec![(10, 20), (30, 25)], style::stroke(RED, 4)))
                .unwrap();
            area.draw(&plotters::element::Rectangle::new([(1, 2), (5, 9)], BLACK.mix(0.25).filled()))
                .unwrap();
            area.draw_text("I o", &style::text(100.0, style::INK, Anchor::West), (100, 200)).unwrap();
        }
        let (objects, drawn) = read(&page.finish().unwrap());
        // 170 mm in width.
        assert!(objects[2].contains("/MediaBox [0 0 481.889"), "{}", objects[2]);
        assert!(objects[2].contains("/O250 <<") && objects[2].contains("/ca 0.25"), "{}", objects[2]);
        assert!(drawn.contains("1 0 0 RG\n4 w\n10 20 m\n30 25 l\nS"), "{drawn}");
        assert!(drawn.contains("1 2 4 7 re\nf"), "{drawn}");
        // An I of DejaVu Sans is a bar from .098 to .197 em and .729 em high; the o has curves.
        let (letters, curves) = (drawn.rfind("/O1000 gs").unwrap(), drawn.matches(" c\n").count());
        let points: Vec<[f32; 2]> = drawn[letters..]
            .lines()
            .filter(|line| line.ends_with(" m") || line.ends_with(" l"))
            .map(|line| {
                let mut numbers = line.split(' ').map(str::parse::<f32>);
                [numbers.next().unwrap().unwrap(), numbers.next().unwrap().unwrap()]
            })
            .take(4)
            .collect();
        let of = |n: usize| {
            points.iter().map(|point| point[n]).fold([f32::MAX, f32::MIN], |[a, b], v| [a.min(v), b.max(v)])
        };
        let ([left, right], [top, bottom]) = (of(0), of(1));
        for (value, expected) in [(left, 109.8), (right, 119.7), (bottom, 227.3), (bottom - top, 72.9)] {
            assert!((value - expected).abs() < 0.2, "{value}, not {expected}: {points:?}");
        }
        assert!(curves >= 16, "{curves}");
    }
}
