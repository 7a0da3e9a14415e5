//! One run from above: the ground truth and the estimate aligned to it, in metres alike on both axes.

use super::axis::Axis;
use super::error::FigureError;
use super::frame::{ABOVE, BELOW, Frame, LEFT, RIGHT, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::extent;
use plotters_backend::DrawingBackend;

const FIGURE: &str = "top view";
/// The longer side of the panel; the shorter follows the data, but not below the least.
const SIDE: i32 = style::WIDTH as i32 - LEFT - RIGHT;
const LEAST: f64 = 0.25;
const TALLEST: f64 = 0.85;

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct TopView {
    title: String,
    x: Axis,
    y: Axis,
    tall: i32,
    truth: Vec<[f64; 2]>,
    /// Parts of the estimate without a break.
    estimate: Vec<Vec<[f64; 2]>>,
    sheet: Sheet,
}

impl TopView {
    /// Positions \[m\], x and y of a world whose z axis points up; the estimate in parts without a break. Without truth the estimate stands
    /// alone.
    ///
    /// # Errors
    /// [`FigureError::Empty`] where there is no position at all.
    pub fn new(
        title: String,
        truth: Vec<[f64; 2]>,
        estimate: Vec<Vec<[f64; 2]>>,
        caption: String,
    ) -> Result<Self, FigureError> {
        let all =
            || truth.iter().chain(estimate.iter().flatten()).filter(|p| p.iter().all(|v| v.is_finite()));
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
        Ok(Self {
            title,
            x: Axis::linear("x [m]".into(), x - half[0], x + half[0], 9),
            y: Axis::linear("y [m]".into(), y - half[1], y + half[1], 7),
            tall,
            truth,
            estimate,
            sheet: Sheet::new(legend, ABOVE + tall + BELOW, caption),
        })
    }
}

impl Plot for TopView {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.draw(area, |top| {
            let top = top + ABOVE;
            let rect = Rect { left: LEFT, top, right: LEFT + SIDE, bottom: top + self.tall };
            let frame = Frame::new(area, rect, &self.x, &self.y);
            frame.grid()?;
            let line = |part: &[[f64; 2]]| part.iter().map(|p| frame.at(p[0], p[1])).collect::<Vec<_>>();
            frame.path(line(&self.truth), style::stroke(style::INK, style::THIN))?;
            for part in &self.estimate {
                frame.path(line(part), style::stroke(PALETTE[1], style::THIN + 1))?;
            }
            if let Some(first) = self.estimate.iter().flatten().next() {
                legend::marker(area, 0, frame.at(first[0], first[1]), PALETTE[1])?;
            }
            frame.axes(true)?;
            frame.title(&self.title)
        })
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        let mut add = |what: &str, part: &[[f64; 2]]| {
            rows.extend(part.iter().map(|p| vec![what.to_owned(), p[0].to_string(), p[1].to_string()]));
        };
        add("truth", &self.truth);
        for (i, part) in self.estimate.iter().enumerate() {
            add(&format!("estimate {i}"), part);
        }
        Drawn { header: vec!["line", "x_m", "y_m"], rows }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_is_as_long_on_both_axes_whatever_the_shape() {
        for (wide, high) in [(10.0, 1.0), (1.0, 10.0), (3.0, 2.0), (0.0, 0.0)] {
            let truth = vec![[5.0, -2.0], [5.0 + wide, -2.0 + high]];
            let plot = TopView::new("f".into(), truth, vec![vec![[5.0, -2.0]]], String::new()).unwrap();
            let metres = |axis: &Axis| axis.high() - axis.low();
            let (x, y) = (metres(&plot.x) / f64::from(SIDE), metres(&plot.y) / f64::from(plot.tall));
            assert!((x / y - 1.0).abs() < 1e-3, "{x} {y}");
            for end in [[5.0, -2.0], [5.0 + wide, -2.0 + high]] {
                assert!((0.0..=1.0).contains(&plot.x.fraction(end[0])));
                assert!((0.0..=1.0).contains(&plot.y.fraction(end[1])), "{wide} {high}");
            }
        }
        assert!(TopView::new(String::new(), vec![], vec![], String::new()).is_err());
    }
}
