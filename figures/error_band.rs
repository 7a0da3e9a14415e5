//! Errors of position over time with the band of three deviations that the estimator believed: a row an axis, a column a noise.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel, pale};
use super::error::{FigureError, check_column, check_count};
use super::frame::Rect;
use super::legend::{Entry, Key};
use super::plot::Drawn;
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor, PALETTE};
use plotters::style::RGBColor;

const FIGURE: &str = "error by time";
const MOST: usize = 3;
/// Room around a panel's data: left, above, right, below.
const AROUND: (i32, i32, i32, i32) = (104, 16, 20, 26);
const HEIGHT: i32 = 230;
/// Room over the upper row for the columns' names, below the lowest for its ticks.
const NAMES: i32 = 50;
const TICKS: i32 = 62;
/// Points of a line at most.
const POINTS: usize = 500;

/// One run.
#[derive(Debug, Clone)]
pub struct ErrorColumn {
    /// Name over the column.
    pub name: String,
    /// Times \[s\], ascending.
    pub t: Vec<f64>,
    /// Errors of x, y, z \[m\] at each time.
    pub errors: Vec<[f64; 3]>,
    /// Three deviations believed of x, y, z \[m\] at each time.
    pub bands: Vec<[f64; 3]>,
}

/// Up to three runs of one sequence.
///
/// # Errors
/// No run, too many, columns of different lengths, values that are not finite.
pub fn error_band(title: &str, columns: &[ErrorColumn], caption: &str) -> Result<Chart, FigureError> {
    if columns.is_empty() || columns.iter().any(|c| c.t.len() < 2) {
        return Err(FigureError::Empty { figure: FIGURE, what: "pair of poses".into() });
    }
    check_count(FIGURE, "runs", columns.len(), MOST)?;
    for column in columns {
        check_column(FIGURE, "time", &column.t, column.t.len())?;
        for (what, rows) in [("error", &column.errors), ("band", &column.bands)] {
            for axis in 0..3 {
                let values: Vec<f64> = rows.iter().map(|row| row[axis]).collect();
                check_column(FIGURE, &format!("{what} of {}", column.name), &values, column.t.len())?;
            }
        }
    }
    let thinned = |c: &ErrorColumn| {
        let step = c.t.len().div_ceil(POINTS).max(1);
        let rows = |rows: &[[f64; 3]]| rows.iter().step_by(step).copied().collect::<Vec<_>>();
        ErrorColumn {
            name: c.name.clone(),
            t: c.t.iter().step_by(step).copied().collect(),
            errors: rows(&c.errors),
            bands: rows(&c.bands),
        }
    };
    let columns: Vec<ErrorColumn> = columns.iter().map(thinned).collect();
    let start = columns.iter().map(|c| c.t[0]).fold(f64::INFINITY, f64::min);
    let end = columns.iter().map(|c| c.t[c.t.len() - 1]).fold(f64::NEG_INFINITY, f64::max);
    let scales = [0, 1, 2].map(|axis| {
        let error = columns.iter().flat_map(|c| &c.errors).map(|e| e[axis].abs()).fold(0.0, f64::max);
        let band = columns.iter().flat_map(|c| &c.bands).map(|b| b[axis]).fold(0.0, f64::max);
        // A band far wider than any error is cut: it would leave no room for the errors.
        let most = 1.08 * error.max(band.min(3.0 * error)).max(1e-6);
        Axis::linear(format!("{} [m]", ["x", "y", "z"][axis]), -most, most, 4)
    });
    let time = Axis::linear("time [s]".into(), start, end, 6);
    let entry = |key, colour, words: &str| Entry { key, colour, words: words.into() };
    let sheet = Sheet {
        title: title.to_owned(),
        head: NAMES,
        legend: vec![
            entry(Key::Line, PALETTE[0], "error of position"),
            entry(Key::Patch, on_white(style::MUTED, 0.25), "3 deviations, as believed"),
        ],
        body: NAMES + 3 * (AROUND.1 + HEIGHT + AROUND.3) + TICKS,
        gap: -TICKS / 2,
        caption: caption.to_owned(),
    };
    let width = ROOM / columns.len() as i32;
    let (mut panels, mut rows) = (Vec::new(), Vec::new());
    for (i, column) in columns.iter().enumerate() {
        let left = MARGIN + i as i32 * width + AROUND.0;
        let right = MARGIN + (i as i32 + 1) * width - AROUND.2;
        for (axis, scale) in scales.iter().enumerate() {
            let top = NAMES + axis as i32 * (AROUND.1 + HEIGHT + AROUND.3) + AROUND.1;
            let of = |rows: &[[f64; 3]], sign: f64| {
                column.t.iter().zip(rows).map(|(t, row)| (*t, sign * row[axis])).collect()
            };
            let band = Layer::band(of(&column.bands, 1.0), of(&column.bands, -1.0), pale(style::MUTED, 0.25));
            let line = Layer::Line(of(&column.errors, 1.0), style::stroke(PALETTE[0], style::LINE - 1));
            let mut layers = vec![Layer::Grid, band, line, Layer::SmallAxes];
            if axis == 0 {
                let name = column.name.clone();
                layers.push(Layer::Words(name, style::LABEL, style::INK, Anchor::West, (0, -26)));
            }
            let place = Rect { left, top, right, bottom: top + HEIGHT };
            panels.push(Panel { place, x: time.clone(), y: scale.clone(), layers });
        }
        for ((t, error), band) in column.t.iter().zip(&column.errors).zip(&column.bands) {
            let mut row = vec![column.name.clone(), t.to_string()];
            row.extend(error.iter().chain(band).map(|v| format!("{v:.5}")));
            rows.push(row);
        }
    }
    let header = vec!["noise", "t_s", "x_m", "y_m", "z_m", "x_3std_m", "y_3std_m", "z_3std_m"];
    Ok(Chart::new(sheet, panels, Drawn { header, rows }))
}

/// A colour as it looks at some strength on white paper.
fn on_white(RGBColor(r, g, b): RGBColor, share: f64) -> RGBColor {
    let mix = |c: u8| (255.0 - share * (255.0 - f64::from(c))).round() as u8;
    RGBColor(mix(r), mix(g), mix(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn column(name: &str, n: usize) -> ErrorColumn {
        ErrorColumn {
            name: name.into(),
            t: (0..n).map(|i| i as f64 * 0.1).collect(),
            errors: (0..n).map(|i| [0.01, -0.02, 0.03].map(|v| v * (i as f64 * 0.05).sin())).collect(),
            bands: vec![[0.05, 0.06, 70.0]; n],
        }
    }

    #[test]
    fn a_band_far_wider_than_the_errors_does_not_hide_them() {
        let plot = error_band("MH_04", &[column("x1", 900), column("dualpronet", 900)], "Small.").unwrap();
        assert!(plot.panels[2].y.high() < 0.1 && plot.panels[0].y.high() > 0.029);
        assert!(plot.csv().rows.len() <= 2 * POINTS);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["MH_04", "dualpronet", "x [m]", "z [m]", "time [s]", "Small."] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(matches!(error_band("", &[column("a", 1)], ""), Err(FigureError::Empty { .. })));
        let mut short = column("a", 10);
        short.bands.pop();
        assert!(matches!(error_band("", &[short], ""), Err(FigureError::Lengths { .. })));
    }
}
