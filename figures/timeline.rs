//! A run over time: panels one above the other on one time axis, a few lines each, and marks where something happened.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel};
use super::error::FigureError;
use super::frame::{BELOW, LEFT, RIGHT, Rect};
use super::plot::Drawn;
use super::sheet::Sheet;
use super::style::{self, Anchor, PALETTE};
use super::summary::{columns, extent, unbroken};
use super::trajectory_errors::band;

const FIGURE: &str = "timeline";
/// Height of a panel's data, and of the words above it.
const PANEL: i32 = 190;
const WORDS: i32 = 44;
/// Pixels of the time axis.
const WIDE: i32 = style::WIDTH as i32 - LEFT - RIGHT;
/// Most points of a line.
const MOST: usize = 1400;
/// Decades that a logarithmic panel shows.
const DECADES: f64 = 1e-5;

/// One panel: what its axis says, and lines of (seconds, value) in increasing time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TimelinePanel {
    /// What is shown, with its unit.
    pub(super) label: String,
    /// Whether the axis is logarithmic; values of 0 or below are left out there.
    pub(super) log: bool,
    /// Lines with their names.
    pub(super) lines: Vec<(String, Vec<(f64, f64)>)>,
    /// A band around the first line: time, the lower end and the upper.
    pub(super) band: Vec<(f64, f64, f64)>,
}

/// Panels from above; those without a point are left out. `marks` \[s\] are drawn through all of them, `caption` says what they are.
///
/// # Errors
/// [`FigureError::Empty`] where no panel has a point.
pub(super) fn over_time(
    title: String,
    panels: Vec<TimelinePanel>,
    marks: Vec<f64>,
    caption: String,
) -> Result<Chart, FigureError> {
    let mut kept: Vec<TimelinePanel> = panels
        .into_iter()
        .map(|mut panel| {
            for (_, line) in &mut panel.lines {
                line.retain(|(t, v)| t.is_finite() && v.is_finite() && (!panel.log || *v > 0.0));
            }
            panel
        })
        .collect();
    kept.retain(|panel| panel.lines.iter().any(|(_, line)| !line.is_empty()));
    let times = kept.iter().flat_map(|p| p.lines.iter().flat_map(|(_, line)| line.iter().map(|p| p.0)));
    let (start, end) = extent(times);
    if start > end {
        return Err(FigureError::Empty { figure: FIGURE, what: "point in time".into() });
    }
    let time = Axis::linear("time [s]".into(), start, end, 10);
    let body = kept.len() as i32 * (PANEL + WORDS) + BELOW;
    let sheet = Sheet { title, head: WORDS, ..Sheet::new(Vec::new(), body, caption) };
    let marks: Vec<f64> = marks.into_iter().filter(|t| (start..=end).contains(t)).collect();
    let (mut drawn, mut rows) = (Vec::new(), Vec::new());
    for (i, panel) in kept.iter().enumerate() {
        let (y, panel) = (panel.axis(), panel.thinned());
        for (name, line) in &panel.lines {
            let row = |(t, value): &(f64, f64)| {
                vec![panel.label.clone(), name.clone(), t.to_string(), value.to_string()]
            };
            rows.extend(line.iter().map(row));
        }
        let top = WORDS + i as i32 * (PANEL + WORDS);
        let place = Rect { left: LEFT, top, right: LEFT + WIDE, bottom: top + PANEL };
        let layers = panel.layers(&y, &marks, i + 1 == kept.len());
        drawn.push(Panel { place, x: time.clone(), y, layers });
    }
    Ok(Chart::new(sheet, drawn, Drawn { header: vec!["panel", "line", "t_s", "value"], rows }))
}

impl TimelinePanel {
    /// At most as many points as the paper shows, medians of equal stretches of time.
    fn thinned(&self) -> Self {
        let thin = |line: &[(f64, f64)]| {
            if line.len() <= MOST {
                return line.to_vec();
            }
            let (t, values): (Vec<f64>, Vec<f64>) = line.iter().copied().unzip();
            columns(&t, &values, MOST).into_iter().map(|column| (column.t, column.middle)).collect()
        };
        let lines = self.lines.iter().map(|(name, line)| (name.clone(), thin(line))).collect();
        Self { lines, ..self.clone() }
    }

    /// Without its label, which stands above the panel, where there is room for it.
    fn axis(&self) -> Axis {
        let (low, high) = extent(self.lines.iter().flat_map(|(_, line)| line.iter().map(|p| p.1)));
        if self.log {
            return Axis::log(String::new(), low.max(high * DECADES) / 1.2, high * 1.2);
        }
        // Counts and lengths begin at nought.
        let low = if low >= 0.0 { 0.0 } else { low };
        let pad = 0.06 * (high - low);
        Axis::linear(String::new(), if low < 0.0 { low - pad } else { low }, high + pad, 4)
    }

    fn layers(&self, y: &Axis, marks: &[f64], last: bool) -> Vec<Layer> {
        let mut layers = vec![Layer::Grid];
        let mark = |t: &f64| {
            Layer::Dashed(vec![(*t, y.high()), (*t, y.low())], style::stroke(style::MUTED, style::THIN))
        };
        layers.extend(marks.iter().map(mark));
        layers.extend(band(y, PALETTE[0], &self.band));
        let mut x = WIDE;
        for ((name, line), colour) in self.lines.iter().zip(PALETTE).rev() {
            let parts = unbroken(line, |(t, _)| *t);
            layers.extend(parts.map(|part| Layer::Line(part.to_vec(), style::stroke(colour, style::THIN))));
            if self.lines.len() > 1 {
                layers.push(Layer::Words(name.clone(), style::CAPTION, colour, Anchor::East, (x, -18)));
                x -= style::width(name, style::CAPTION) + 24;
            }
        }
        layers.push(Layer::Axes(last));
        layers.push(Layer::Words(self.label.clone(), style::CAPTION, style::INK, Anchor::West, (0, -18)));
        layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn panel(label: &str, log: bool, line: &[(f64, f64)]) -> TimelinePanel {
        TimelinePanel { label: label.into(), log, lines: vec![("a".into(), line.to_vec())], band: Vec::new() }
    }

    #[test]
    fn a_line_breaks_off_where_values_are_missing() {
        let line: Vec<(f64, f64)> = [0, 1, 2, 3, 9, 10, 11].map(|t| (f64::from(t), 1.0)).to_vec();
        assert_eq!(unbroken(&line, |(t, _)| *t).map(<[_]>::len).collect::<Vec<_>>(), [4, 3]);
        assert_eq!(unbroken(&[], |(t, _): &(f64, f64)| *t).count(), 0);
    }

    #[test]
    fn panels_without_points_are_left_out_and_values_are_kept() {
        let panels = vec![
            panel("tracks", false, &[(0.0, 10.0), (1.0, 20.0), (2.0, f64::NAN)]),
            panel("nothing", false, &[]),
            panel("sigma [m]", true, &[(0.5, 0.0), (1.5, 0.1)]),
        ];
        let plot = over_time("f01".into(), panels, vec![1.0, 9.0], "Dashed: restarts.".into()).unwrap();
        let rows = plot.csv().rows;
        let of = |row: &Vec<String>| (row[0].clone(), row[2].clone(), row[3].clone());
        let expected = [("tracks", "0", "10"), ("tracks", "1", "20"), ("sigma [m]", "1.5", "0.1")];
        let expected = expected.map(|(a, b, c)| (a.to_owned(), b.to_owned(), c.to_owned()));
        assert_eq!(rows.iter().map(of).collect::<Vec<_>>(), expected);
        let marks = plot.panels[0].layers.iter().filter(|layer| matches!(layer, Layer::Dashed(..)));
        assert_eq!(marks.count(), 1);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        assert!(text.contains("time [s]") && text.contains("restarts") && !text.contains("nothing"));
        let none = over_time(String::new(), vec![panel("x", false, &[])], vec![], String::new());
        assert!(matches!(none, Err(FigureError::Empty { .. })));
    }
}
