//! Error against the constant given, both logarithmic: the sweep with its intervals, and other noises as marks at the level they say.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel, pale};
use super::error::{FigureError, check_count, check_each};
use super::frame::{BELOW, LEFT, RIGHT, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::sheet::Sheet;
use super::style::{self, Anchor, PALETTE};
use super::summary::extent;

const FIGURE: &str = "sweep of constants";
const PANEL: i32 = 640;
/// Room over the panel for the constants' names, clear of the legend.
const HEAD: i32 = 44;
/// Marks nearer than this stand side by side \[pixels\].
const APART: i32 = 26;
/// Marks at most: shapes and colours that can be told apart.
const MOST: usize = 5;

/// A noise's place: what it says, and the error that comes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPoint {
    /// The noise.
    pub name: String,
    /// What it says, in multiples of the baseline.
    pub multiple: f64,
    /// The error \[m\].
    pub error: f64,
    /// Its interval \[m\].
    pub interval: Option<[f64; 2]>,
}

/// A curve through `constants`, in rising order of multiples, and up to five `marks`; `what` names the error.
///
/// # Errors
/// No constant, too many marks, values that are not finite and positive.
pub fn sweep_curve(
    constants: &[SweepPoint],
    marks: &[SweepPoint],
    what: &str,
    caption: &str,
) -> Result<Chart, FigureError> {
    if constants.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "constant".into() });
    }
    check_count(FIGURE, "marks", marks.len(), MOST)?;
    let all = || constants.iter().chain(marks);
    for point in all() {
        let ends = point.interval.unwrap_or([point.error; 2]);
        let values = [point.multiple, point.error, ends[0], ends[1]];
        check_each(FIGURE, &point.name, &values, "it must be finite and positive", |v| {
            v.is_finite() && v > 0.0
        })?;
    }
    let (left, right) = extent(all().map(|p| p.multiple));
    let (low, high) =
        extent(all().flat_map(|p| p.interval.unwrap_or([p.error; 2]).into_iter().chain([p.error])));
    let mut legend =
        vec![Entry { key: Key::Line, colour: style::INK, words: "constants, with 95 % interval".into() }];
    legend.extend(legend::marked(marks.iter().map(|mark| mark.name.as_str())));
    let x = Axis::log(
        "noise given, in multiples of the baseline (.08 m/s², .004 rad/s)".into(),
        left / 1.25,
        right * 1.25,
    );
    let y = Axis::log(format!("{what} [m]"), low / 1.15, high * 1.15);
    let place = Rect { left: LEFT, top: HEAD, right: style::WIDTH as i32 - RIGHT, bottom: HEAD + PANEL };
    let x_at = |p: &SweepPoint| (x.fraction(p.multiple) * f64::from(place.right - LEFT)).round() as i32;
    let edge = |end: usize| {
        constants.iter().map(|p| (p.multiple, p.interval.unwrap_or([p.error; 2])[end])).collect()
    };
    let line = constants.iter().map(|p| (p.multiple, p.error)).collect();
    let mut layers = vec![
        Layer::Grid,
        Layer::band(edge(1), edge(0), pale(style::MUTED, 0.16)),
        Layer::Line(line, style::stroke(style::INK, style::LINE - 1)),
    ];
    for p in constants {
        // Above the panel no mark and no bar can cover a name.
        let up = vec![(p.multiple, y.high()), (p.multiple, p.error)];
        layers.push(Layer::Line(up, style::stroke(style::GRID, style::THIN)));
        layers.push(Layer::Mark(0, (p.multiple, p.error), style::INK));
        let (name, at) = (p.name.clone(), (x_at(p), -16));
        layers.push(Layer::Words(name, style::CAPTION, style::MUTED, Anchor::Centre, at));
    }
    let places: Vec<i32> = marks.iter().map(x_at).collect();
    for (series, (p, moved)) in marks.iter().zip(side_by_side(&places)).enumerate() {
        let (at, shift) = ((p.multiple, p.error), moved - places[series]);
        layers.push(Layer::Error { series, at, shift, ends: p.interval, colour: PALETTE[series] });
    }
    layers.push(Layer::Axes(true));

    let row = |kind: &str, p: &SweepPoint| {
        let end = |i: usize| p.interval.map_or_else(String::new, |ends| ends[i].to_string());
        row![kind, p.name, p.multiple, p.error, end(0), end(1)]
    };
    let of_constants = constants.iter().map(|p| row("constant", p));
    let rows = of_constants.chain(marks.iter().map(|p| row("mark", p))).collect();
    let drawn = Drawn { header: vec!["kind", "noise", "multiple", "error_m", "low_m", "high_m"], rows };
    let sheet = Sheet { gap: 0, ..Sheet::new(legend, HEAD + PANEL + BELOW, caption.to_owned()) };
    Ok(Chart::new(sheet, vec![Panel { place, x, y, layers }], drawn))
}

/// Places at which no mark covers another: those that are too near share out the room about their middle, in their order.
fn side_by_side(places: &[i32]) -> Vec<i32> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&i| places[i]);
    // Groups of neighbours, each with the room it needs; one that then touches the group before it joins it.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let middle = |group: &[usize]| group.iter().map(|&i| places[i]).sum::<i32>() / group.len() as i32;
    let half = |group: &[usize]| APART * (group.len() as i32 - 1) / 2;
    for i in order {
        let mut group = vec![i];
        while let Some(before) =
            groups.pop_if(|before| middle(&group) - half(&group) - middle(before) - half(before) < APART)
        {
            group = before.into_iter().chain(group).collect();
        }
        groups.push(group);
    }
    let mut found = places.to_vec();
    for group in groups {
        let first = middle(&group) - half(&group);
        for (n, i) in (0..).zip(&group) {
            if group.len() > 1 {
                found[*i] = first + n * APART;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn point(name: &str, multiple: f64, error: f64) -> SweepPoint {
        SweepPoint { name: name.into(), multiple, error, interval: Some([0.8 * error, 1.3 * error]) }
    }

    #[test]
    fn the_csv_holds_curve_and_marks_and_the_axes_their_units() {
        let constants = [point("x1", 1.0, 0.2), point("x4", 4.0, 0.1), point("x16", 16.0, 0.3)];
        let marks =
            [point("dualpronet", 3.3, 0.1), SweepPoint { interval: None, ..point("shuffled", 3.3, 0.12) }];
        let plot = sweep_curve(&constants, &marks, "ATE", "Small print.").unwrap();
        let csv = plot.csv();
        assert_eq!((csv.rows.len(), csv.rows[1][3].as_str(), csv.rows[4][4].as_str()), (5, "0.1", ""));
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["ATE [m]", "multiples of the baseline", "dualpronet", "x16", "Small print."] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn marks_that_would_cover_each_other_stand_side_by_side() {
        assert_eq!(side_by_side(&[500, 100, 300]), [500, 100, 300]);
        assert_eq!(side_by_side(&[101, 99, 400]), [113, 87, 400]);
        let places = side_by_side(&[300, 302, 298, 320, 330, 700]);
        let mut sorted = places.clone();
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] >= APART), "{places:?}");
        assert!(places[2] < places[0] && places[0] < places[1] && places[5] == 700, "{places:?}");
        assert!(side_by_side(&[]).is_empty());
    }

    #[test]
    fn what_has_no_place_is_refused() {
        let good = [point("x1", 1.0, 0.2)];
        assert!(matches!(sweep_curve(&[], &good, "ATE", ""), Err(FigureError::Empty { .. })));
        let six: Vec<_> = (1..=6).map(|i| point("m", f64::from(i), 0.1)).collect();
        assert!(matches!(sweep_curve(&good, &six, "ATE", ""), Err(FigureError::TooMany { .. })));
        let error = sweep_curve(&good, &[point("m", 0.0, 0.1)], "ATE", "").unwrap_err().to_string();
        assert!(error.contains("m is 0 at index 0"), "{error}");
    }
}
