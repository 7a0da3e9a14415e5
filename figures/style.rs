//! What all figures look like: colours, sizes, fonts.
//!
//! Colours are those of Okabe and Ito (2008), told apart with the common kinds of colour blindness; yellow is left out (too
//! pale on paper), black and grey are kept for references. Sizes are pixels of the drawing, which is [`WIDTH`] wide: printed
//! over a text width of 170 mm, ticks are 7.5 points high.

use super::FigureError;
use dpn_core::Sensor;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontDesc, FontFamily, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle, register_font,
};
use std::sync::OnceLock;

/// Width of every figure.
pub(super) const WIDTH: u32 = 1600;
/// Panel titles.
pub(super) const TITLE: f64 = 30.0;
/// Axis labels and legends.
pub(super) const LABEL: f64 = 28.0;
/// Tick labels.
pub(super) const TICK: f64 = 25.0;
/// The small print under a figure.
pub(super) const CAPTION: f64 = 22.0;
/// Lines that carry data.
pub(super) const LINE: u32 = 4;
/// Axes, ticks, references.
pub(super) const THIN: u32 = 2;

/// Text and axes.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Small print, references.
pub(super) const MUTED: RGBColor = RGBColor(0x5A, 0x5A, 0x5A);
/// Grid lines.
pub(super) const GRID: RGBColor = RGBColor(0xDF, 0xDF, 0xDF);
/// One colour a series, in this order.
pub(super) const PALETTE: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xB2), // blue
    RGBColor(0xD5, 0x5E, 0x00), // vermillion
    RGBColor(0x00, 0x9E, 0x73), // bluish green
    RGBColor(0xCC, 0x79, 0xA7), // reddish purple
    RGBColor(0xE6, 0x9F, 0x00), // orange
    RGBColor(0x56, 0xB4, 0xE9), // sky blue
];

/// Font family in SVG (the first is that of the PNG), and the name the bundled font is registered under.
const FAMILY: &str = "DejaVu Sans, sans-serif";
/// plotters writes `size / 1.24` as the em of an SVG text.
pub(super) const SIZE_PER_EM: f64 = 1.24;
/// Height of DejaVu Sans between ascender and descender over its em: `(1901 + 483) / 2048`.
pub(super) const HEIGHT_PER_EM: f64 = 2384.0 / 2048.0;

/// Makes the bundled font known to plotters, once.
///
/// # Errors
/// [`FigureError::Draw`] if plotters cannot read the font.
pub(super) fn prepare() -> Result<(), FigureError> {
    static READY: OnceLock<bool> = OnceLock::new();
    let ready = READY.get_or_init(|| {
        register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular()).is_ok()
            && register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular()).is_ok()
    });
    if *ready {
        Ok(())
    } else {
        Err(FigureError::Draw { reason: "the bundled font DejaVu Sans cannot be read".into() })
    }
}

/// Where a text's anchor lies relative to it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Anchor {
    /// Left end, half height.
    West,
    /// Right end, half height.
    East,
    /// Middle of the upper edge.
    North,
    /// Middle.
    Centre,
}

/// A text style of `em` pixels.
pub(super) fn text(em: f64, colour: RGBColor, anchor: Anchor) -> TextStyle<'static> {
    let (h_pos, v_pos) = match anchor {
        Anchor::West => (HPos::Left, VPos::Center),
        Anchor::East => (HPos::Right, VPos::Center),
        Anchor::North => (HPos::Center, VPos::Top),
        Anchor::Centre => (HPos::Center, VPos::Center),
    };
    TextStyle { font: font(em), color: colour.to_backend_color(), pos: Pos { h_pos, v_pos } }
}

/// A text that reads upwards, centred on its anchor.
pub(super) fn text_upwards(em: f64, colour: RGBColor) -> TextStyle<'static> {
    let style = text(em, colour, Anchor::Centre);
    style.transform(FontTransform::Rotate270)
}

fn font(em: f64) -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FAMILY), em * SIZE_PER_EM, FontStyle::Normal)
}

/// Width of `words` at `em` pixels, in the bundled font.
pub(super) fn width(words: &str, em: f64) -> i32 {
    let _ = prepare(); // a drawing that follows reports the failure
    // The layout takes the size as the font's height, see `HEIGHT_PER_EM`. Without a font the width is a fair guess.
    FontDesc::new(FontFamily::Name(FAMILY), em * HEIGHT_PER_EM, FontStyle::Normal)
        .layout_box(words)
        .map_or((0.6 * em * words.chars().count() as f64) as i32, |(low, high)| high.0 - low.0)
}

/// A line of `width` pixels.
pub(super) fn stroke(colour: impl Color, width: u32) -> ShapeStyle {
    colour.stroke_width(width)
}

/// The unit of a sensor as it is typeset.
pub(super) fn unit(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Accel => "m/s²",
        Sensor::Gyro => "rad/s",
    }
}

/// The name of a sensor as it stands over a panel.
pub(super) fn title(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Accel => "Accelerometer",
        Sensor::Gyro => "Gyroscope",
    }
}

/// Digits in groups of three.
pub(super) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use ab_glyph::{Font, FontRef};

    #[test]
    fn the_height_of_the_font_is_that_of_the_file() {
        let font = FontRef::try_from_slice(dejavu::sans::regular()).unwrap();
        let per_em = font.height_unscaled() / font.units_per_em().unwrap();
        assert!((f64::from(per_em) - HEIGHT_PER_EM).abs() < 1e-6);
    }

    #[test]
    fn colours_differ_in_lightness_or_hue_and_stand_out_from_paper() {
        // Relative luminance (WCAG): a line needs some contrast to white to be seen at all.
        for RGBColor(r, g, b) in PALETTE {
            let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
            let luminance = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
            assert!(1.05 / (luminance + 0.05) > 2.0);
        }
    }

    #[test]
    fn text_width_grows_with_size_and_words() {
        let one = width("sigma", 20.0);
        assert!((width("sigma", 40.0) - 2 * one).abs() <= 2);
        assert!((width("sigmasigma", 20.0) - 2 * one).abs() <= 3);
    }

    #[test]
    fn digits_stand_in_groups_of_three() {
        assert_eq!([grouped(7), grouped(1234), grouped(20_427_000)], ["7", "1,234", "20,427,000"]);
    }
}
