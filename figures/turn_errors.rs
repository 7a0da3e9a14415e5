//! How far integrated rates are off after a span of time, both logarithmic: as they are, and without the mean bias of each sequence beside it. What both panels
//! show differs by a constant bias alone.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::{FigureError, check_count, check_each};
use super::legend;
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use super::summary::extent;

const FIGURE: &str = "errors of turns";
const MOST: usize = 6;

/// A way to rates.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnErrors {
    /// What it is called.
    pub name: String,
    /// Lengths of spans \[s\], mean errors as they are and without bias \[deg\].
    pub points: Vec<[f64; 3]>,
}

/// A line for each of up to six ways to rates; `caption` is the small print.
///
/// # Errors
/// None or too many; an error that is not finite and positive.
pub fn turn_errors(of: &[TurnErrors], caption: &str) -> Result<Chart, FigureError> {
    check_count(FIGURE, "ways to rates", of.len(), MOST)?;
    for one in of {
        let values: Vec<f64> = one.points.iter().flatten().copied().collect();
        check_each(FIGURE, &one.name, &values, "it must be finite and positive", |v| {
            v.is_finite() && v > 0.0
        })?;
    }
    let points = || of.iter().flat_map(|one| &one.points);
    if points().next().is_none() {
        return Err(FigureError::Empty { figure: FIGURE, what: "span".into() });
    }
    let (short, long) = extent(points().map(|p| p[0]));
    let (low, high) = extent(points().flat_map(|p| [p[1], p[2]]));
    let panel = |title: &str, column: usize| {
        let x = Axis::log("time after a true rotation [s]".into(), short / 1.15, long * 1.15);
        let y = Axis::log("mean error of the rotation [deg]".into(), low / 1.2, high * 1.2);
        let layers = of.iter().zip(PALETTE).enumerate().flat_map(|(i, (one, colour))| {
            let line: Vec<(f64, f64)> = one.points.iter().map(|p| (p[0], p[column])).collect();
            let marks = line.clone().into_iter().map(move |point| Layer::Mark(i, point, colour));
            std::iter::once(Layer::Line(line, style::stroke(colour, style::LINE))).chain(marks)
        });
        (title.to_owned(), x, y, layers.collect())
    };
    let panels = vec![panel("As they are", 1), panel("Without the sequence's own mean bias", 2)];
    let rows = of.iter().flat_map(|one| one.points.iter().map(|p| row![one.name, p[0], p[1], p[2]]));
    let drawn =
        Drawn { header: vec!["rates", "span_s", "error_deg", "without_bias_deg"], rows: rows.collect() };
    let legend = legend::marked(of.iter().map(|one| one.name.as_str()));
    Ok(Chart::side_by_side(legend, caption.to_owned(), panels, drawn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    #[test]
    fn the_csv_holds_both_panels_and_what_has_no_place_is_named() {
        let one = |name: &str, error| TurnErrors {
            name: name.into(),
            points: vec![[0.1, error, 0.01], [1.0, 0.5, 0.02]],
        };
        let plot = turn_errors(&[one("affine", 0.05), one("network", 0.04)], "Small print.").unwrap();
        assert_eq!(plot.csv().rows[2], ["network", "0.1", "0.04", "0.01"]);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["time after a true rotation [s]", "own mean bias", "network", "Small print."] {
            assert!(text.contains(words), "{words}");
        }
        let error = turn_errors(&[one("raw", f64::NAN)], "").unwrap_err().to_string();
        assert!(error.contains("raw is NaN at index 1"), "{error}");
        assert!(matches!(turn_errors(&[], ""), Err(FigureError::Empty { .. })));
    }
}
