//! What the camera saw and what was made of it: the image, its tracks coloured by age with the way they came, and those that ended.

use super::error::FigureError;
use super::plot::{Area, Painted};
use super::raster::{Raster, canvas_over, encoded};
use super::style::{self, Anchor};
use dpn_core::GrayImage;
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::{Color, RGBColor, WHITE};
use plotters_backend::DrawingBackend;

/// Height of the words under an image.
const STRIP: u32 = 30;
/// Frames after which a track is as old as the colours tell.
const OLD: u32 = 40;
/// Colours by age, young to old; between them they are mixed. Light enough on a dark image, and dark on a bright one.
const AGES: [RGBColor; 4] = [
    RGBColor(0x56, 0xB4, 0xE9), // sky blue
    RGBColor(0x00, 0x9E, 0x73), // bluish green
    RGBColor(0xF0, 0xE4, 0x42), // yellow
    RGBColor(0xE6, 0x9F, 0x00), // orange
];
/// Tracks that do not agree with the camera's motion.
const OUTLIER: RGBColor = RGBColor(0xFF, 0x20, 0x20);
/// Tracks that were not found again.
const LOST: RGBColor = RGBColor(0xCC, 0x79, 0xA7);

/// A track in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackDot {
    /// Where it is \[px\].
    pub px: [f64; 2],
    /// Where it was in the frame drawn before; none of a new one.
    pub before: Option<[f64; 2]>,
    /// Frames in which it has been, this one among them.
    pub age: u32,
}

/// A track that ended since the frame drawn before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackEnd {
    /// Where it was last, or where it was found \[px\].
    pub px: [f64; 2],
    /// Whether it did not agree with the others; else it was not found again.
    pub outlier: bool,
}

/// The picture of one frame; see the head of its file.
#[derive(Debug, Clone, Copy)]
pub struct TrackPicture<'a> {
    /// The image.
    pub image: &'a GrayImage,
    /// Its tracks.
    pub tracks: &'a [TrackDot],
    /// Tracks that ended.
    pub ended: &'a [TrackEnd],
    /// Words under it.
    pub words: &'a str,
}

impl TrackPicture<'_> {
    /// The picture as PNG.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub(crate) fn png(&self) -> Result<Vec<u8>, FigureError> {
        style::prepare()?;
        let size = (self.image.width() as u32, self.image.height() as u32 + STRIP);
        let mut memory = canvas_over(self.image, STRIP as usize);
        {
            let area = Raster::new(&mut memory, size).into_drawing_area();
            self.draw(&area)
                .and_then(|()| area.present())
                .map_err(|error| FigureError::Draw { reason: error.to_string() })?;
        }
        encoded(&memory, size, png::Compression::default())
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        let at = |px: [f64; 2]| (px[0].round() as i32, px[1].round() as i32);
        for dot in self.tracks {
            let colour = by_age(dot.age);
            if let Some(before) = dot.before {
                area.draw(&PathElement::new(vec![at(before), at(dot.px)], style::stroke(colour, 2)))?;
                area.draw(&Circle::new(at(dot.px), 3, colour.filled()))?;
            } else {
                area.draw(&Circle::new(at(dot.px), 3, style::stroke(WHITE, 1)))?;
            }
        }
        for end in self.ended {
            let (x, y) = at(end.px);
            let colour = if end.outlier { OUTLIER } else { LOST };
            for arm in [[(x - 4, y - 4), (x + 4, y + 4)], [(x - 4, y + 4), (x + 4, y - 4)]] {
                area.draw(&PathElement::new(arm.to_vec(), style::stroke(colour, 2)))?;
            }
        }
        let (width, height) = (self.image.width() as i32, self.image.height() as i32);
        area.draw(&Rectangle::new([(0, height), (width, height + STRIP as i32)], WHITE.filled()))?;
        let middle = height + STRIP as i32 / 2;
        area.draw_text(self.words, &style::text(14.0, style::INK, Anchor::West), (6, middle))?;
        // The key, from the right.
        let mut x = width - 8;
        for (words, colour) in [("lost", LOST), ("outlier", OUTLIER)] {
            x -= style::width(words, 14.0);
            area.draw_text(words, &style::text(14.0, colour, Anchor::West), (x, middle))?;
            x -= 14;
        }
        let old = format!("{OLD}+ frames");
        x -= style::width(&old, 14.0);
        area.draw_text(&old, &style::text(14.0, style::INK, Anchor::West), (x, middle))?;
        for step in (0..60).rev() {
            x -= 1;
            let colour = by_age(1 + step * OLD / 60);
            area.draw(&Rectangle::new([(x - 4, middle - 6), (x - 3, middle + 6)], colour.filled()))?;
        }
        let words = "age 1";
        x -= style::width(words, 14.0) + 8;
        area.draw_text(words, &style::text(14.0, style::INK, Anchor::West), (x, middle))
    }
}

fn by_age(age: u32) -> RGBColor {
    let place = f64::from(age.clamp(1, OLD) - 1) / f64::from(OLD - 1) * (AGES.len() - 1) as f64;
    let at = (place as usize).min(AGES.len() - 2);
    let share = place - at as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    let (a, b) = (AGES[at], AGES[at + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(bytes: &[u8], [x, y]: [usize; 2]) -> [u8; 3] {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let at = (y * info.width as usize + x) * 3;
        [pixels[at], pixels[at + 1], pixels[at + 2]]
    }

    #[test]
    fn tracks_are_where_they_are_in_the_colour_of_their_age_and_the_image_is_below() {
        let image = GrayImage::from_fn(400, 100, |x, _| (x / 4) as u8).unwrap();
        let dot = |x: f64, age, before| TrackDot { px: [x, 50.0], before, age };
        let tracks =
            [dot(40.0, 1, Some([20.0, 50.0])), dot(120.0, 90, Some([120.0, 50.0])), dot(200.0, 1, None)];
        let ended = [TrackEnd { px: [300.0, 50.0], outlier: true }];
        let picture = TrackPicture { image: &image, tracks: &tracks, ended: &ended, words: "2.00 s" };
        let bytes = picture.png().unwrap();
        let rgb = |c: RGBColor| [c.0, c.1, c.2];
        assert_eq!(pixel(&bytes, [40, 50]), rgb(AGES[0]));
        assert_eq!(pixel(&bytes, [30, 50]), rgb(AGES[0]), "the way it came");
        assert_eq!(pixel(&bytes, [120, 50]), rgb(AGES[3]));
        assert_eq!(pixel(&bytes, [200, 50]), [50; 3], "a new one is a ring");
        assert!(pixel(&bytes, [300, 50])[0] > 200 && pixel(&bytes, [300, 50])[1] < 100);
        assert_eq!(pixel(&bytes, [360, 10]), [90; 3]);
    }
}
