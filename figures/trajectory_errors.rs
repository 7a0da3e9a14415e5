//! Trajectories held against the truth: all from above, each coloured by its error, and below over time the error, positions and angles.

use super::axis::Axis;
use super::belief::PoseBelief;
use super::chart::{Chart, Layer, Panel};
use super::error::{FigureError, check_each};
use super::frame::{BELOW, LEFT, RIGHT, Rect};
use super::heat;
use super::legend::{Entry, Key};
use super::plot::Drawn;
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor, PALETTE};
use super::summary::{extent, unbroken};
use dpn_core::Stamp;
use dpn_eval::metrics::{Alignment, Compared, PosePair};
use nalgebra::Isometry3;
use plotters::style::{Color, RGBColor};

const FIGURE: &str = "trajectory errors";
/// Trajectories at most.
const MOST: usize = 4;
/// Points of a line at most.
const POINTS: usize = 1200;
/// Height of the maps' data, and room around it: left, above, right, below.
const MAP: i32 = 430;
const AROUND: (i32, i32, i32, i32) = (100, 60, 30, 62);
/// Height of a panel over time, and room for the words above it.
const PANEL: i32 = 130;
const WORDS: i32 = 40;

/// Up to four trajectories by name, each compared with the same truth, and what they believe of their poses by their own stamps, empty where that is not known; `error` is what was counted, with its unit, `time` what stamps count, `caption`
/// the small print.
///
/// # Errors
/// None or too many; a pose or an error that is not finite.
pub fn trajectory_errors(
    of: &[(String, &Compared, &[PoseBelief])],
    (error, time): (&str, &str),
    caption: &str,
) -> Result<Chart, FigureError> {
    let Some((_, first, _)) = of.first() else {
        return Err(FigureError::Empty { figure: FIGURE, what: "trajectory".into() });
    };
    super::error::check_count(FIGURE, "trajectories", of.len(), MOST)?;
    for (name, compared, _) in of {
        let errors: Vec<f64> = compared.errors.iter().map(|(_, error)| *error).collect();
        check_each(FIGURE, &format!("error of {name}"), &errors, "it must be finite", f64::is_finite)?;
    }
    let start = of.iter().map(|(_, c, _)| c.pairs[0].t).min().unwrap_or(first.pairs[0].t);
    let lines: Vec<Path> = of
        .iter()
        .zip(PALETTE)
        .map(|((name, compared, beliefs), colour)| Path::new(name, compared, beliefs, colour, start))
        .collect();
    let truth =
        Path::of("truth", first.pairs.iter().map(|p| (p.t.seconds_since(start), &p.true_world_from_body)));

    let most = lines.iter().flat_map(|line| &line.errors).map(|(_, e)| *e).fold(0.0, f64::max).max(1e-12);
    let maps = lines.len() + 1;
    let across = if maps.is_multiple_of(2) { 2 } else { 3 };
    let (mut panels, mut top) = (Vec::new(), 0);
    for i in 0..maps {
        let place = map_place(i as i32, across);
        top = place.bottom + AROUND.3;
        panels.push(match i.checked_sub(1) {
            None => map(place, "from above", std::iter::once(&truth).chain(&lines), Vec::new()),
            Some(k) => {
                let path = &lines[k];
                map(place, &path.name, [&truth, path], path.coloured(most))
            }
        });
    }
    panels.push(heat::scale(top + WORDS, Axis::linear(error.to_owned(), 0.0, most, 8)));
    top += WORDS + heat::SCALE;
    let over = Axis::linear(time.to_owned(), 0.0, truth.end().max(1e-9), 10);
    let rows = rows_over_time(&truth, &lines, error);
    let count = rows.len();
    for (i, (label, lines)) in rows.into_iter().enumerate() {
        let top = top + WORDS + i as i32 * (PANEL + WORDS);
        let place = Rect { left: LEFT, top, right: style::WIDTH as i32 - RIGHT, bottom: top + PANEL };
        panels.push(over_time(place, &over, label, &lines, i + 1 == count));
    }
    let body = top + count as i32 * (PANEL + WORDS) + BELOW;
    let entry = |path: &Path| Entry { key: Key::Line, colour: path.colour, words: path.name.clone() };
    let legend = std::iter::once(&truth).chain(&lines).map(entry).collect();
    let mut caption = caption.to_owned();
    if lines.iter().any(|line| !line.bands.is_empty()) {
        caption.push_str(" Bands: three deviations, as believed.");
    }
    let sheet = Sheet::new(legend, body, caption);
    let header = vec!["path", "t_s", "x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg", "error"];
    let rows = std::iter::once(&truth).chain(&lines).flat_map(Path::rows).collect();
    Ok(Chart::new(sheet, panels, Drawn { header, rows }))
}

/// One trajectory as it is drawn: thinned, seconds from the first pose of all.
pub(super) struct Path {
    name: String,
    colour: RGBColor,
    /// Time, then x, y, z \[m\], roll, pitch, yaw \[deg\], the angles without jumps.
    poses: Vec<(f64, [f64; 6])>,
    /// Three deviations of each pose's numbers, where they are believed.
    bands: Vec<(f64, [f64; 6])>,
    /// Error by time.
    errors: Vec<(f64, f64)>,
}

impl Path {
    /// Of poses by time.
    pub(super) fn of<'a>(name: &str, all: impl ExactSizeIterator<Item = (f64, &'a Isometry3<f64>)>) -> Self {
        let step = all.len().div_ceil(POINTS).max(1);
        let mut last = [0.0; 3];
        let mut poses = Vec::new();
        for (i, (t, pose)) in all.enumerate() {
            let (roll, pitch, yaw) = pose.rotation.euler_angles();
            // The turn that is nearest to the last: no line jumps from 180 to -180.
            for (last, angle) in last.iter_mut().zip([roll, pitch, yaw].map(f64::to_degrees)) {
                *last = angle + 360.0 * ((*last - angle) / 360.0).round();
            }
            if i % step == 0 {
                let [x, y, z]: [f64; 3] = pose.translation.vector.into();
                poses.push((t, [x, y, z, last[0], last[1], last[2]]));
            }
        }
        Self { name: name.to_owned(), colour: style::INK, poses, bands: Vec::new(), errors: Vec::new() }
    }

    fn new(name: &str, compared: &Compared, beliefs: &[PoseBelief], colour: RGBColor, start: Stamp) -> Self {
        let time = |pair: &PosePair| pair.t.seconds_since(start);
        let pairs = &compared.pairs;
        let mut path = Self::of(name, pairs.iter().map(|pair| (time(pair), &pair.est_world_from_body)));
        let poses = pairs.iter().map(|pair| (pair.t, time(pair), &pair.est_world_from_body));
        path.believed(beliefs, &compared.alignment, poses);
        let step = compared.errors.len().div_ceil(POINTS).max(1);
        let mut errors: Vec<(f64, f64)> =
            compared.errors.iter().step_by(step).map(|(i, e)| (time(&compared.pairs[*i]), *e)).collect();
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        (path.colour, path.errors) = (colour, errors);
        path
    }

    /// Takes what is believed of `poses`, each with its stamp and time.
    pub(super) fn believed<'a>(
        &mut self,
        beliefs: &[PoseBelief],
        alignment: &Alignment,
        poses: impl ExactSizeIterator<Item = (Stamp, f64, &'a Isometry3<f64>)>,
    ) {
        let step = poses.len().div_ceil(POINTS).max(1);
        let band = |(t, seconds, pose): (Stamp, f64, &Isometry3<f64>)| {
            let belief = beliefs.get(beliefs.binary_search_by_key(&t, |belief| belief.t).ok()?)?;
            Some((seconds, belief.three_sigma(pose, alignment)))
        };
        self.bands = poses.step_by(step).filter_map(band).collect();
    }

    fn end(&self) -> f64 {
        self.poses.last().map_or(0.0, |pose| pose.0)
    }

    /// The path from above, in parts without a gap.
    fn seen(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        unbroken(&self.poses, |pose| pose.0).map(|part| part.iter().map(|(_, p)| (p[0], p[1])).collect())
    }

    /// The error at a time: that of the first stretch or pose that ends there or later.
    fn error_at(&self, t: f64) -> Option<f64> {
        self.errors.get(self.errors.partition_point(|(end, _)| *end < t)).map(|(_, error)| *error)
    }

    /// The path from above, each step in the colour of its error.
    fn coloured(&self, most: f64) -> Vec<Layer> {
        let mut layers = Vec::new();
        for part in unbroken(&self.poses, |pose| pose.0) {
            let step = |pose: &(f64, [f64; 6])| self.error_at(pose.0).map(|e| heat::step(e / most));
            let ends: Vec<(Option<usize>, usize)> =
                part.iter().enumerate().skip(1).map(|(i, pose)| (step(pose), i)).collect();
            for run in ends.chunk_by(|a, b| a.0 == b.0) {
                let (from, to) = (run[0].1 - 1, run[run.len() - 1].1);
                let points = part[from..=to].iter().map(|(_, p)| (p[0], p[1])).collect();
                let colour = run[0].0.map_or(style::GRID, heat::colour);
                layers.push(Layer::Line(points, style::stroke(colour, style::LINE + 1)));
            }
        }
        layers
    }

    fn rows(&self) -> Vec<Vec<String>> {
        let row = |(t, pose): &(f64, [f64; 6])| {
            let mut row = vec![self.name.clone(), t.to_string()];
            row.extend(pose.map(|v| format!("{v:.5}")));
            row.push(self.error_at(*t).map_or_else(String::new, |error| error.to_string()));
            row
        };
        self.poses.iter().map(row).collect()
    }
}

fn map_place(i: i32, across: i32) -> Rect {
    let width = ROOM / across;
    let left = MARGIN + (i % across) * width;
    let top = (i / across) * (AROUND.1 + MAP + AROUND.3) + AROUND.1;
    Rect { left: left + AROUND.0, top, right: left + width - AROUND.2, bottom: top + MAP }
}

/// Paths from above, metres alike on both axes, under `layers`.
fn map<'a>(place: Rect, title: &str, paths: impl IntoIterator<Item = &'a Path>, layers: Vec<Layer>) -> Panel {
    let paths: Vec<&Path> = paths.into_iter().collect();
    let range = |axis: usize| {
        let (low, high) = extent(paths.iter().flat_map(|path| &path.poses).map(|(_, p)| p[axis]));
        (0.5 * (low + high), high - low)
    };
    let ((x, wide), (y, high)) = (range(0), range(1));
    let (across, up) = (f64::from(place.right - place.left), f64::from(place.bottom - place.top));
    let scale = (1.1 * wide / across).max(1.1 * high / up).max(1e-6);
    let plain = layers.is_empty();
    let mut all = vec![Layer::Grid];
    for (i, path) in paths.iter().enumerate().filter(|(i, _)| plain || *i == 0) {
        let width = if i == 0 { style::LINE } else { style::THIN };
        // Under its colours a path is not drawn, and the truth is thin.
        let width = if plain { width } else { style::THIN };
        all.extend(path.seen().map(|points| Layer::Line(points, style::stroke(path.colour, width))));
    }
    all.extend(layers);
    all.push(Layer::SmallAxes);
    all.push(Layer::Words(title.to_owned(), style::TICK, style::INK, Anchor::West, (0, -24)));
    let axis = |name: &str, middle: f64, pixels: f64, count: usize| {
        Axis::linear(
            format!("{name} [m]"),
            middle - 0.5 * scale * pixels,
            middle + 0.5 * scale * pixels,
            count,
        )
    };
    Panel { place, x: axis("x", x, across, 6), y: axis("y", y, up, 5), layers: all }
}

/// A line over time, and around it a band of what is believed.
pub(super) struct LineOverTime {
    pub(super) name: String,
    pub(super) colour: RGBColor,
    pub(super) points: Vec<(f64, f64)>,
    /// Time, the lower end and the upper.
    pub(super) band: Vec<(f64, f64, f64)>,
}

/// What stands over time: words and lines.
fn rows_over_time(truth: &Path, lines: &[Path], error: &str) -> Vec<(String, Vec<LineOverTime>)> {
    let errors = |path: &Path| LineOverTime {
        name: path.name.clone(),
        colour: path.colour,
        points: path.errors.clone(),
        band: Vec::new(),
    };
    let mut rows = vec![(error.to_owned(), lines.iter().map(errors).collect())];
    rows.extend(poses_over_time(Some(truth), lines));
    rows
}

/// Positions and angles over time: words and lines.
pub(super) fn poses_over_time(truth: Option<&Path>, lines: &[Path]) -> Vec<(String, Vec<LineOverTime>)> {
    let names = ["x [m]", "y [m]", "z [m]", "roll [deg]", "pitch [deg]", "yaw [deg]"];
    let row = |(k, name): (usize, &str)| {
        let middle =
            |path: &Path| path.poses.iter().map(|(_, p)| p[k]).sum::<f64>() / path.poses.len() as f64;
        let of = |path: &Path| {
            // Both without jumps, they may still be whole turns apart.
            let apart = truth.filter(|_| k >= 3).map_or(0.0, |truth| (middle(truth) - middle(path)) / 360.0);
            let turns = 360.0 * apart.round();
            let points: Vec<(f64, f64)> = path.poses.iter().map(|(t, p)| (*t, p[k] + turns)).collect();
            let band = |(t, sigma): &(f64, [f64; 6])| {
                let (_, middle) = points.get(points.partition_point(|point| point.0 < *t))?;
                Some((*t, middle - sigma[k], middle + sigma[k]))
            };
            let band = path.bands.iter().filter_map(band).collect();
            LineOverTime { name: path.name.clone(), colour: path.colour, points, band }
        };
        (name.to_owned(), truth.into_iter().chain(lines).map(of).collect())
    };
    names.into_iter().enumerate().map(row).collect()
}

/// The bands of a panel whose axis is `y`, cut off at its ends.
pub(super) fn band(y: &Axis, colour: RGBColor, band: &[(f64, f64, f64)]) -> Vec<Layer> {
    let within = |v: f64| v.clamp(y.low(), y.high());
    let parts = unbroken(band, |(t, ..)| *t);
    let layer = |part: &[(f64, f64, f64)]| {
        let upper = part.iter().map(|(t, _, high)| (*t, within(*high))).collect();
        let lower = part.iter().map(|(t, low, _)| (*t, within(*low))).collect();
        Layer::band(upper, lower, colour.mix(0.25))
    };
    parts.filter(|part| part.len() > 1).map(layer).collect()
}

fn over_time(place: Rect, time: &Axis, label: String, lines: &[LineOverTime], last: bool) -> Panel {
    let (low, high) = extent(lines.iter().flat_map(|line| &line.points).map(|(_, v)| *v));
    // Room for bands, but no band makes a line flat.
    let widest = lines.iter().flat_map(|line| &line.band).map(|(_, a, b)| 0.5 * (b - a)).fold(0.0, f64::max);
    let pad = (0.06 * (high - low)).max(widest.min(0.5 * (high - low)));
    let y = Axis::linear(String::new(), low - pad, high + pad, 4);
    let mut layers = vec![Layer::Grid];
    layers.extend(lines.iter().flat_map(|line| band(&y, line.colour, &line.band)));
    for line in lines {
        let parts = unbroken(&line.points, |(t, _)| *t);
        layers.extend(parts.map(|part| Layer::Line(part.to_vec(), style::stroke(line.colour, style::THIN))));
    }
    layers.push(Layer::Axes(last));
    layers.push(Layer::Words(label, style::CAPTION, style::INK, Anchor::West, (0, -18)));
    Panel { place, x: time.clone(), y, layers }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};
    use dpn_core::trajectory::StampedPose;
    use dpn_eval::metrics::{Comparing, PoseRelation, absolute};
    use nalgebra::Vector3;

    fn circle(radius: f64) -> Vec<StampedPose> {
        let pose = |i: i32| {
            let angle = 0.1 * f64::from(i);
            let position = Vector3::new(radius * angle.cos(), radius * angle.sin(), 0.0);
            StampedPose {
                t: Stamp::from_ns(i64::from(i) * 100_000_000),
                world_from_body: Isometry3::new(position, Vector3::z() * angle),
            }
        };
        (0..130).map(pose).collect()
    }

    #[test]
    fn angles_do_not_jump_and_colours_are_those_of_the_errors() {
        let by = Comparing {
            relation: PoseRelation::TransPart,
            align: false,
            correct_scale: false,
            align_origin: false,
            n_to_align: None,
            max_diff_s: 0.01,
            offset_s: 0.0,
            from: None,
            to: None,
        };
        let compared = absolute(&circle(1.0), &circle(1.5), &by).unwrap();
        let plot =
            trajectory_errors(&[("A".into(), &compared, &[])], ("APE [m]", "time [s]"), "Made up.").unwrap();
        let rows = plot.csv().rows;
        let yaw: Vec<f64> = rows.iter().take(130).map(|row| row[7].parse().unwrap()).collect();
        assert!(yaw.windows(2).all(|pair| (pair[1] - pair[0] - 0.1f64.to_degrees()).abs() < 1e-3), "{yaw:?}");
        assert_eq!(
            (rows[0][0].as_str(), rows[130][0].as_str(), rows[130][8].as_str()),
            ("truth", "A", "0.5")
        );
        // All errors are the largest: one line in the last colour.
        let coloured = plot.panels[1].layers.iter().filter(|layer| matches!(layer, Layer::Line(..))).count();
        assert_eq!((coloured, plot.panels.len()), (2, 2 + 1 + 7));
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["colour: APE [m]", "yaw [deg]", "time [s]", "Made up."] {
            assert!(text.contains(words), "{words}");
        }
        let five = vec![("A".to_owned(), &compared, &[][..]); 5];
        assert!(matches!(trajectory_errors(&five, ("", ""), ""), Err(FigureError::TooMany { .. })));
    }
}
