//! Trajectories from above, a panel a sequence: the ground truth, and estimates aligned to it.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel};
use super::error::{FigureError, check_column, check_count};
use super::frame::Rect;
use super::legend::{Entry, Key};
use super::plot::Drawn;
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor, PALETTE};
use super::summary::extent;

const FIGURE: &str = "trajectories";
/// Panels side by side.
const ACROSS: usize = 3;
/// Room around a panel's data: left, above, right, below.
const AROUND: (i32, i32, i32, i32) = (84, 74, 14, 52);
/// Width and height of a panel's data.
const PANEL: (i32, i32) = ((ROOM - ACROSS as i32 * (AROUND.0 + AROUND.2)) / ACROSS as i32, 400);
/// Points of a path at most: a point every few centimetres of paper.
const MOST: usize = 700;
/// Steps of a path drawn at once.
const PIECE: usize = 8;
/// Estimates at most.
const MOST_ESTIMATES: usize = 4;

/// One sequence.
#[derive(Debug, Clone)]
pub struct TrajectoryPanel {
    /// Name of the sequence, marked where it is a test sequence.
    pub name: String,
    /// True positions \[m\], in time.
    pub truth: Vec<[f64; 3]>,
    /// Aligned positions \[m\] of each estimate, in the order of the names given to [`trajectories`]; none where a run failed.
    pub estimates: Vec<Option<Vec<[f64; 3]>>>,
    /// Words under the name: the errors.
    pub words: String,
}

/// One panel a sequence; `names` of the estimates; `caption` under all.
///
/// # Errors
/// No panel, a panel without truth, estimates that are not one a name, values that are not finite.
pub fn trajectories(panels: &[TrajectoryPanel], names: &[&str], caption: &str) -> Result<Chart, FigureError> {
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "sequence".into() });
    }
    check_count(FIGURE, "estimates", names.len(), MOST_ESTIMATES)?;
    let entry = |colour, words: &str| Entry { key: Key::Line, colour, words: words.to_owned() };
    let mut legend = vec![entry(style::INK, "ground truth")];
    legend.extend(names.iter().enumerate().map(|(i, name)| entry(colour(i), name)));
    let (width, height) = (AROUND.0 + PANEL.0 + AROUND.2, AROUND.1 + PANEL.1 + AROUND.3);
    let (mut drawn, mut rows) = (Vec::new(), Vec::new());
    for (i, panel) in panels.iter().enumerate() {
        let (column, row) = ((i % ACROSS) as i32, (i / ACROSS) as i32);
        let (left, top) = (MARGIN + column * width + AROUND.0, row * height + AROUND.1);
        let place = Rect { left, top, right: left + PANEL.0, bottom: top + PANEL.1 };
        drawn.push(panel_of(panel, names, place, &mut rows)?);
    }
    let body = panels.len().div_ceil(ACROSS) as i32 * height;
    let sheet = Sheet { gap: 0, ..Sheet::new(legend, body, caption.to_owned()) };
    Ok(Chart::new(sheet, drawn, Drawn { header: vec!["sequence", "path", "x_m", "y_m"], rows }))
}

/// Vermillion first, then blue: both far from the truth's black.
fn colour(estimate: usize) -> plotters::style::RGBColor {
    PALETTE[[1, 0, 2, 3][estimate % MOST_ESTIMATES]]
}

/// In pieces: where a thick line crosses itself in one piece, bitmaps leave a hole.
fn pieces(path: &[[f64; 2]], colour: plotters::style::RGBColor, width: u32) -> impl Iterator<Item = Layer> {
    let ends = (0..path.len().saturating_sub(1)).step_by(PIECE);
    ends.map(move |from| {
        let piece = &path[from..(from + PIECE + 1).min(path.len())];
        Layer::Line(piece.iter().map(|p| (p[0], p[1])).collect(), style::stroke(colour, width))
    })
}

fn panel_of(
    panel: &TrajectoryPanel,
    names: &[&str],
    place: Rect,
    rows: &mut Vec<Vec<String>>,
) -> Result<Panel, FigureError> {
    let seen = |what: &str, path: &[[f64; 3]]| {
        for axis in 0..2 {
            let values: Vec<f64> = path.iter().map(|p| p[axis]).collect();
            check_column(FIGURE, &format!("{what} of {}", panel.name), &values, path.len())?;
        }
        let step = path.len().div_ceil(MOST).max(1);
        Ok::<_, FigureError>(path.iter().step_by(step).map(|p| [p[0], p[1]]).collect::<Vec<_>>())
    };
    if panel.truth.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: format!("true position of {}", panel.name) });
    }
    if panel.estimates.len() != names.len() {
        let what = format!("estimates of {}", panel.name);
        let (expected, found) = (names.len(), panel.estimates.len());
        return Err(FigureError::Lengths { figure: FIGURE, what, expected, found });
    }
    let truth = seen("true position", &panel.truth)?;
    let estimates = panel
        .estimates
        .iter()
        .zip(names)
        .map(|(path, name)| path.as_deref().map_or(Ok(Vec::new()), |path| seen(name, path)))
        .collect::<Result<Vec<_>, _>>()?;
    // A lost run must not shrink the truth to a point: the panel holds the truth and half its size around it.
    let range = |axis: usize| {
        let (low, high) = extent(truth.iter().map(|p| p[axis]));
        (0.5 * (low + high), high - low)
    };
    let ((x, wide), (y, high)) = (range(0), range(1));
    let metres_a_pixel = (1.12 * wide / f64::from(PANEL.0)).max(1.12 * high / f64::from(PANEL.1)).max(1e-3);
    let half = |pixels: i32| 0.5 * f64::from(pixels) * metres_a_pixel;
    let mut layers = vec![Layer::Grid];
    layers.extend(pieces(&truth, style::INK, style::LINE + 1));
    for (i, path) in estimates.iter().enumerate() {
        layers.extend(pieces(path, colour(i), style::THIN + 1));
    }
    let words =
        |words: &str, em, colour, up: i32| Layer::Words(words.to_owned(), em, colour, Anchor::West, (0, -up));
    layers.push(Layer::SmallAxes);
    layers.push(words(&panel.name, style::TICK, style::INK, 48));
    layers.push(words(&panel.words, style::CAPTION, style::MUTED, 18));
    for (name, path) in std::iter::once((&"ground truth", &truth)).chain(names.iter().zip(&estimates)) {
        let row = |point: &[f64; 2]| {
            let words = [panel.name.clone(), (*name).to_owned()];
            words.into_iter().chain(point.map(|v| format!("{v:.4}"))).collect()
        };
        rows.extend(path.iter().map(row));
    }
    let x = Axis::linear("x [m]".into(), x - half(PANEL.0), x + half(PANEL.0), 5);
    let y = Axis::linear("y [m]".into(), y - half(PANEL.1), y + half(PANEL.1), 5);
    Ok(Panel { place, x, y, layers })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn panel(name: &str) -> TrajectoryPanel {
        let circle = |r: f64| {
            (0..100)
                .map(|i| 0.0628 * f64::from(i))
                .map(|a| [r * a.cos(), r * a.sin(), 1.0])
                .collect::<Vec<_>>()
        };
        TrajectoryPanel {
            name: name.into(),
            truth: circle(5.0),
            estimates: vec![Some(circle(5.1)), None],
            words: "x1 .100 m".into(),
        }
    }

    #[test]
    fn panels_have_equal_scales_and_failed_runs_no_line() {
        let panels: Vec<_> = ["MH_01", "MH_02*", "MH_03", "MH_04*"].map(panel).to_vec();
        let plot = trajectories(&panels, &["x1", "dualpronet"], "From above.").unwrap();
        let one = &plot.panels[0];
        let scale = |axis: &Axis, pixels: i32| (axis.high() - axis.low()) / f64::from(pixels);
        assert!((scale(&one.x, PANEL.0) / scale(&one.y, PANEL.1) - 1.0).abs() < 1e-9);
        assert_eq!(plot.csv().rows.len(), 4 * 200);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["MH_02*", "x1 .100 m", "ground truth", "From above.", "x [m]", "y [m]"] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        assert!(matches!(trajectories(&[], &[], ""), Err(FigureError::Empty { .. })));
        let error = trajectories(&[panel("a")], &["x1"], "").unwrap_err().to_string();
        assert!(error.contains("estimates of a has 2 values where 1"), "{error}");
        let mut bad = panel("b");
        bad.truth[3][1] = f64::NAN;
        let error = trajectories(&[bad], &["x1", "x2"], "").unwrap_err().to_string();
        assert!(error.contains("true position of b is NaN at index 3"), "{error}");
    }
}
