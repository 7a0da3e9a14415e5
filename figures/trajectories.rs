//! Trajectories from above, a panel a sequence: the ground truth, and estimates aligned to it.

use super::axis::Axis;
use super::error::{FigureError, check_column, check_count};
use super::frame::{Frame, Rect};
use super::legend::{Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot};
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor, PALETTE};
use super::summary::extent;
use plotters::style::ShapeStyle;
use plotters_backend::DrawingBackend;

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
    /// Aligned positions \[m\] of each estimate, in the order of the names given to [`Trajectories::new`]; none where a run failed.
    pub estimates: Vec<Option<Vec<[f64; 3]>>>,
    /// Words under the name: the errors.
    pub words: String,
}

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct Trajectories {
    panels: Vec<Drawable>,
    names: Vec<String>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Drawable {
    name: String,
    words: String,
    x: Axis,
    y: Axis,
    truth: Vec<[f64; 2]>,
    estimates: Vec<Vec<[f64; 2]>>,
}

impl Trajectories {
    /// One panel a sequence; `names` of the estimates; `caption` under all.
    ///
    /// # Errors
    /// No panel, a panel without truth, estimates that are not one a name, values that are not finite.
    pub fn new(panels: &[TrajectoryPanel], names: &[&str], caption: &str) -> Result<Self, FigureError> {
        if panels.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: "sequence".into() });
        }
        check_count(FIGURE, "estimates", names.len(), MOST_ESTIMATES)?;
        let mut legend = vec![Entry { key: Key::Line, colour: style::INK, words: "ground truth".into() }];
        let colours = PALETTE.iter().cycle().skip(1);
        for (i, (name, _)) in names.iter().zip(colours).enumerate() {
            legend.push(Entry { key: Key::Line, colour: colour(i), words: (*name).to_owned() });
        }
        let rows = panels.len().div_ceil(ACROSS) as i32;
        let body = rows * (AROUND.1 + PANEL.1 + AROUND.3);
        Ok(Self {
            panels: panels.iter().map(|p| Drawable::new(p, names)).collect::<Result<_, _>>()?,
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            sheet: Sheet { gap: 0, ..Sheet::new(legend, body, caption.to_owned()) },
        })
    }
}

/// Vermillion first, then blue: both far from the truth's black.
fn colour(estimate: usize) -> plotters::style::RGBColor {
    PALETTE[[1, 0, 2, 3][estimate % MOST_ESTIMATES]]
}

impl Drawable {
    fn new(panel: &TrajectoryPanel, names: &[&str]) -> Result<Self, FigureError> {
        let seen = |what: &str, path: &[[f64; 3]]| {
            for axis in 0..2 {
                let values: Vec<f64> = path.iter().map(|p| p[axis]).collect();
                check_column(FIGURE, &format!("{what} of {}", panel.name), &values, path.len())?;
            }
            let step = path.len().div_ceil(MOST).max(1);
            Ok::<_, FigureError>(path.iter().step_by(step).map(|p| [p[0], p[1]]).collect::<Vec<_>>())
        };
        if panel.truth.is_empty() {
            return Err(FigureError::Empty {
                figure: FIGURE,
                what: format!("true position of {}", panel.name),
            });
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
        let metres_a_pixel =
            (1.12 * wide / f64::from(PANEL.0)).max(1.12 * high / f64::from(PANEL.1)).max(1e-3);
        let half = |pixels: i32| 0.5 * f64::from(pixels) * metres_a_pixel;
        Ok(Self {
            name: panel.name.clone(),
            words: panel.words.clone(),
            x: Axis::linear("x [m]".into(), x - half(PANEL.0), x + half(PANEL.0), 5),
            y: Axis::linear("y [m]".into(), y - half(PANEL.1), y + half(PANEL.1), 5),
            truth,
            estimates,
        })
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, rect: Rect) -> Painted<DB> {
        let frame = Frame::new(area, rect, &self.x, &self.y);
        frame.grid()?;
        let line = |path: &[[f64; 2]]| path.iter().map(|p| frame.at(p[0], p[1])).collect::<Vec<_>>();
        // In pieces: where a thick line crosses itself in one piece, bitmaps leave a hole.
        let draw = |path: &[[f64; 2]], style: ShapeStyle| {
            let ends = (0..path.len().saturating_sub(1)).step_by(PIECE);
            ends.map(|from| &path[from..(from + PIECE + 1).min(path.len())])
                .try_for_each(|piece| frame.path(line(piece), style))
        };
        draw(&self.truth, style::stroke(style::INK, style::LINE + 1))?;
        for (i, path) in self.estimates.iter().enumerate() {
            draw(path, style::stroke(colour(i), style::THIN + 1))?;
        }
        frame.small_axes()?;
        let at = |up: i32| (rect.left, rect.top - up);
        frame.words(&self.name, style::TICK, style::INK, Anchor::West, at(48))?;
        frame.words(&self.words, style::CAPTION, style::MUTED, Anchor::West, at(18))
    }
}

impl Plot for Trajectories {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        let (width, height) = (AROUND.0 + PANEL.0 + AROUND.2, AROUND.1 + PANEL.1 + AROUND.3);
        self.sheet.draw(area, |top| {
            for (i, panel) in self.panels.iter().enumerate() {
                let (column, row) = ((i % ACROSS) as i32, (i / ACROSS) as i32);
                let left = MARGIN + column * width + AROUND.0;
                let top = top + row * height + AROUND.1;
                panel.draw(area, Rect { left, top, right: left + PANEL.0, bottom: top + PANEL.1 })?;
            }
            Ok(())
        })
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        for panel in &self.panels {
            let truth = std::iter::once(("ground truth", &panel.truth));
            let estimates = self.names.iter().map(String::as_str).zip(&panel.estimates);
            for (name, path) in truth.chain(estimates) {
                for point in path {
                    let words = [panel.name.clone(), name.to_owned()];
                    rows.push(words.into_iter().chain(point.map(|v| format!("{v:.4}"))).collect());
                }
            }
        }
        Drawn { header: vec!["sequence", "path", "x_m", "y_m"], rows }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

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
        let plot = Trajectories::new(&panels, &["x1", "dualpronet"], "From above.").unwrap();
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
        assert!(matches!(Trajectories::new(&[], &[], ""), Err(FigureError::Empty { .. })));
        let error = Trajectories::new(&[panel("a")], &["x1"], "").unwrap_err().to_string();
        assert!(error.contains("estimates of a has 2 values where 1"), "{error}");
        let mut bad = panel("b");
        bad.truth[3][1] = f64::NAN;
        let error = Trajectories::new(&[bad], &["x1", "x2"], "").unwrap_err().to_string();
        assert!(error.contains("true position of b is NaN at index 3"), "{error}");
    }
}
