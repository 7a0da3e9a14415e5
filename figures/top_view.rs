//! One run from above: the ground truth and the estimate aligned to it, in metres alike on both axes.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel};
use super::error::FigureError;
use super::frame::{ABOVE, BELOW, LEFT, RIGHT, Rect};
use super::legend::{Entry, Key};
use super::plot::Drawn;
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::extent;

const FIGURE: &str = "top view";
/// The longer side of the panel; the shorter follows the data, but not below the least.
const SIDE: i32 = style::WIDTH as i32 - LEFT - RIGHT;
const LEAST: f64 = 0.25;
const TALLEST: f64 = 0.85;

/// Positions \[m\], x and y of a world whose z axis points up; the estimate in parts without a break. Without truth the estimate stands
/// alone.
///
/// # Errors
/// [`FigureError::Empty`] where there is no position at all.
pub(super) fn from_above(
    title: String,
    truth: &[[f64; 2]],
    estimate: &[Vec<[f64; 2]>],
    caption: String,
) -> Result<Chart, FigureError> {
    let all = || truth.iter().chain(estimate.iter().flatten()).filter(|p| p.iter().all(|v| v.is_finite()));
    if all().next().is_none() {
        return Err(FigureError::Empty { figure: FIGURE, what: "position".into() });
    }
    let range = |axis: usize| {
        let (low, high) = extent(all().map(|p| p[axis]));
        (0.5 * (low + high), high - low)
    };
    let ((x, wide), (y, high)) = (range(0), range(1));
    // One scale for both axes; a centimetre where nothing moves.
    let share = (high / wide.max(1e-9)).clamp(LEAST, TALLEST);
    let metres = 1.06 * wide.max(high / share).max(0.01);
    let tall = (share * f64::from(SIDE)).round() as i32;
    let half = [0.5 * metres, 0.5 * metres * f64::from(tall) / f64::from(SIDE)];
    let mut legend = Vec::new();
    if !truth.is_empty() {
        legend.push(Entry { key: Key::Line, colour: style::INK, words: "ground truth".into() });
    }
    legend.push(Entry { key: Key::Line, colour: PALETTE[1], words: "estimate".into() });
    legend.push(Entry { key: Key::Marked(0), colour: PALETTE[1], words: "first pose".into() });
    let x = Axis::linear("x [m]".into(), x - half[0], x + half[0], 9);
    let y = Axis::linear("y [m]".into(), y - half[1], y + half[1], 7);
    let line = |part: &[[f64; 2]], width| {
        let colour = if width == style::THIN { style::INK } else { PALETTE[1] };
        Layer::Line(part.iter().map(|p| (p[0], p[1])).collect(), style::stroke(colour, width))
    };
    let mut layers = vec![Layer::Grid, line(truth, style::THIN)];
    layers.extend(estimate.iter().map(|part| line(part, style::THIN + 1)));
    layers.extend(estimate.iter().flatten().next().map(|p| Layer::Mark(0, (p[0], p[1]), PALETTE[1])));
    layers.extend([Layer::Axes(true), Layer::title(title)]);

    let mut rows = Vec::new();
    let mut add = |what: &str, part: &[[f64; 2]]| {
        rows.extend(part.iter().map(|p| vec![what.to_owned(), p[0].to_string(), p[1].to_string()]));
    };
    add("truth", truth);
    for (i, part) in estimate.iter().enumerate() {
        add(&format!("estimate {i}"), part);
    }
    let place = Rect { left: LEFT, top: ABOVE, right: LEFT + SIDE, bottom: ABOVE + tall };
    let sheet = Sheet::new(legend, ABOVE + tall + BELOW, caption);
    let drawn = Drawn { header: vec!["line", "x_m", "y_m"], rows };
    Ok(Chart::new(sheet, vec![Panel { place, x, y, layers }], drawn))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_is_as_long_on_both_axes_whatever_the_shape() {
        for (wide, high) in [(10.0, 1.0), (1.0, 10.0), (3.0, 2.0), (0.0, 0.0)] {
            let truth = vec![[5.0, -2.0], [5.0 + wide, -2.0 + high]];
            let plot = from_above("f".into(), &truth, &[vec![[5.0, -2.0]]], String::new()).unwrap();
            let panel = &plot.panels[0];
            let tall = panel.place.bottom - panel.place.top;
            let metres = |axis: &Axis| axis.high() - axis.low();
            let (x, y) = (metres(&panel.x) / f64::from(SIDE), metres(&panel.y) / f64::from(tall));
            assert!((x / y - 1.0).abs() < 1e-3, "{x} {y}");
            for end in [[5.0, -2.0], [5.0 + wide, -2.0 + high]] {
                assert!((0.0..=1.0).contains(&panel.x.fraction(end[0])));
                assert!((0.0..=1.0).contains(&panel.y.fraction(end[1])), "{wide} {high}");
            }
        }
        assert!(from_above(String::new(), &[], &[], String::new()).is_err());
    }
}
