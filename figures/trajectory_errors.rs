//! Trajectories held against the truth: all from above, each coloured by its error, and below over time the error, positions and angles.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel};
use super::error::{FigureError, check_each};
use super::frame::{BELOW, LEFT, RIGHT, Rect};
use super::heat;
use super::legend::{Entry, Key};
use super::plot::Drawn;
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor, PALETTE};
use super::summary::{extent, unbroken};
use dpn_eval::metrics::{Compared, PosePair};
use nalgebra::Isometry3;
use plotters::style::RGBColor;

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

/// Up to four trajectories by name, each compared with the same truth; `error` is what was counted, with its unit, `time` what stamps count, `caption`
/// the small print.
///
/// # Errors
/// None or too many; a pose or an error that is not finite.
pub fn trajectory_errors(
    of: &[(String, &Compared)],
    (error, time): (&str, &str),
    caption: &str,
) -> Result<Chart, FigureError> {
    let Some((_, first)) = of.first() else {
        return Err(FigureError::Empty { figure: FIGURE, what: "trajectory".into() });
    };
    super::error::check_count(FIGURE, "trajectories", of.len(), MOST)?;
    for (name, compared) in of {
        let errors: Vec<f64> = compared.errors.iter().map(|(_, error)| *error).collect();
        check_each(FIGURE, &format!("error of {name}"), &errors, "it must be finite", f64::is_finite)?;
    }
    let start = of.iter().map(|(_, c)| c.pairs[0].t).min().unwrap_or(first.pairs[0].t);
    let lines: Vec<Path> = of
        .iter()
        .zip(PALETTE)
        .map(|((name, compared), colour)| Path::new(name, compared, colour, |p| p.t.seconds_since(start)))
        .collect();
    let truth = Path {
        colour: style::INK,
        ..Path::of("truth", &first.pairs, |p| p.t.seconds_since(start), truth_of)
    };

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
    let sheet = Sheet::new(legend, body, caption.to_owned());
    let header = vec!["path", "t_s", "x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg", "error"];
    let rows = std::iter::once(&truth).chain(&lines).flat_map(Path::rows).collect();
    Ok(Chart::new(sheet, panels, Drawn { header, rows }))
}

fn truth_of(pair: &PosePair) -> &Isometry3<f64> {
    &pair.true_world_from_body
}

/// One trajectory as it is drawn: thinned, seconds from the first pose of all.
struct Path {
    name: String,
    colour: RGBColor,
    /// Time, then x, y, z \[m\], roll, pitch, yaw \[deg\], the angles without jumps.
    poses: Vec<(f64, [f64; 6])>,
    /// Error by time.
    errors: Vec<(f64, f64)>,
}

impl Path {
    fn of(
        name: &str,
        pairs: &[PosePair],
        time: impl Fn(&PosePair) -> f64,
        pose: fn(&PosePair) -> &Isometry3<f64>,
    ) -> Self {
        let step = pairs.len().div_ceil(POINTS).max(1);
        let mut last = [0.0; 3];
        let mut poses = Vec::new();
        for (i, pair) in pairs.iter().enumerate() {
            let pose = pose(pair);
            let (roll, pitch, yaw) = pose.rotation.euler_angles();
            // The turn that is nearest to the last: no line jumps from 180 to -180.
            for (last, angle) in last.iter_mut().zip([roll, pitch, yaw].map(f64::to_degrees)) {
                *last = angle + 360.0 * ((*last - angle) / 360.0).round();
            }
            if i % step == 0 {
                let [x, y, z]: [f64; 3] = pose.translation.vector.into();
                poses.push((time(pair), [x, y, z, last[0], last[1], last[2]]));
            }
        }
        Self { name: name.to_owned(), colour: style::INK, poses, errors: Vec::new() }
    }

    fn new(name: &str, compared: &Compared, colour: RGBColor, time: impl Fn(&PosePair) -> f64) -> Self {
        let mut path = Self::of(name, &compared.pairs, &time, |pair| &pair.est_world_from_body);
        let step = compared.errors.len().div_ceil(POINTS).max(1);
        let mut errors: Vec<(f64, f64)> =
            compared.errors.iter().step_by(step).map(|(i, e)| (time(&compared.pairs[*i]), *e)).collect();
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        (path.colour, path.errors) = (colour, errors);
        path
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

/// Lines by colour.
type Lines = Vec<(RGBColor, Vec<(f64, f64)>)>;

/// What stands over time: words and lines.
fn rows_over_time(truth: &Path, lines: &[Path], error: &str) -> Vec<(String, Lines)> {
    let mut rows: Vec<(String, Lines)> =
        vec![(error.to_owned(), lines.iter().map(|line| (line.colour, line.errors.clone())).collect())];
    for (k, name) in
        ["x [m]", "y [m]", "z [m]", "roll [deg]", "pitch [deg]", "yaw [deg]"].into_iter().enumerate()
    {
        let middle =
            |path: &Path| path.poses.iter().map(|(_, p)| p[k]).sum::<f64>() / path.poses.len() as f64;
        let of = |path: &Path| {
            // Both without jumps, they may still be whole turns apart.
            let turns = if k < 3 { 0.0 } else { 360.0 * ((middle(truth) - middle(path)) / 360.0).round() };
            (path.colour, path.poses.iter().map(|(t, p)| (*t, p[k] + turns)).collect())
        };
        rows.push((name.to_owned(), std::iter::once(truth).chain(lines).map(of).collect()));
    }
    rows
}

fn over_time(place: Rect, time: &Axis, label: String, lines: &Lines, last: bool) -> Panel {
    let (low, high) = extent(lines.iter().flat_map(|(_, line)| line).map(|(_, v)| *v));
    let pad = 0.06 * (high - low);
    let y = Axis::linear(String::new(), low - pad, high + pad, 3);
    let mut layers = vec![Layer::Grid];
    for (colour, line) in lines {
        let parts = unbroken(line, |(t, _)| *t);
        layers.extend(parts.map(|part| Layer::Line(part.to_vec(), style::stroke(*colour, style::THIN))));
    }
    layers.push(Layer::Axes(last));
    layers.push(Layer::Words(label, style::CAPTION, style::INK, Anchor::West, (0, -18)));
    Panel { place, x: time.clone(), y, layers }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};
    use dpn_core::Stamp;
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
            trajectory_errors(&[("A".into(), &compared)], ("APE [m]", "time [s]"), "Made up.").unwrap();
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
        let five = vec![("A".to_owned(), &compared); 5];
        assert!(matches!(trajectory_errors(&five, ("", ""), ""), Err(FigureError::TooMany { .. })));
    }
}
