//! A line of text in the bundled font, set where plotters' SVG puts it.

use super::style::{HEIGHT_PER_EM, SIZE_PER_EM};
use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use plotters_backend::BackendTextStyle;
use plotters_backend::text_anchor::{HPos, VPos};

/// The bundled font.
pub(super) fn font() -> FontRef<'static> {
    FontRef::try_from_slice(dejavu::sans::regular()).expect("the font that is built in is one")
}

/// The glyphs of `text`, `fine` units to a pixel, y downwards, before any turn: where they stand seen from the text's anchor.
pub(super) fn set<S: BackendTextStyle>(
    font: &FontRef<'static>,
    text: &str,
    style: &S,
    fine: f64,
) -> Vec<Glyph> {
    let em = style.size() / SIZE_PER_EM * fine;
    let scaled = font.as_scaled(PxScale::from((em * HEIGHT_PER_EM) as f32));
    let mut pen = 0.0;
    let mut last = None;
    let mut glyphs = Vec::new();
    for letter in text.chars() {
        let id = font.glyph_id(letter);
        pen += last.map_or(0.0, |last| scaled.kern(last, id));
        glyphs.push((id, pen));
        pen += scaled.h_advance(id);
        last = Some(id);
    }
    let start = match style.anchor().h_pos {
        HPos::Left => 0.0,
        HPos::Center => -pen / 2.0,
        HPos::Right => -pen,
    };
    // As plotters' SVG: 0.76 em, 0.5 ex, -0.5 ex; an ex of this font is 0.547 em.
    let baseline = match style.anchor().v_pos {
        VPos::Top => 0.76,
        VPos::Center => 0.5 * 0.547,
        VPos::Bottom => -0.5 * 0.547,
    } * em as f32;
    glyphs
        .into_iter()
        .map(|(id, x)| id.with_scale_and_position(scaled.scale(), point(start + x, baseline)))
        .collect()
}
