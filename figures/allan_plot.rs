//! Allan plot: deviation over averaging time, both logarithmic, a panel a sensor, a line an axis with its 95 % band, the fitted model dashed
//! below it, and white noise N marked where its slope crosses one second; N, B and K stand on it.

use super::axis::Axis;
use super::chart::{Chart, HALF, Layer, pale};
use super::error::{FigureError, check_each};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::style::{self, Anchor, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_probe::allan::{AxisFit, Coefficient, Point};

const FIGURE: &str = "Allan plot";

/// Of the axes of a log; `words` end the small print, for example with the log's name and length.
///
/// # Errors
/// [`FigureError`] where an axis has no point, or a value is not finite and positive.
pub fn allan_plot(axes: &[AxisFit], words: &str) -> Result<Chart, FigureError> {
    let (mut panels, mut rows) = (Vec::new(), Vec::new());
    for sensor in Sensor::ALL {
        let of: Vec<&AxisFit> = axes.iter().filter(|a| a.sensor == sensor).collect();
        panels.push(panel(sensor, &of)?);
        for axis in of {
            let (name, unit) = (sensor.name(), sensor.unit());
            let row = |p: &Point| row![name, axis.axis, unit, p.tau, p.deviation, p.low, p.high, p.model];
            rows.extend(axis.fit.points.iter().map(row));
        }
    }
    let mut legend = legend::marked(["x", "y", "z"]);
    legend.push(Entry { key: Key::Dashed, colour: style::INK, words: "fitted model".into() });
    let caption = format!(
        "Overlapping Allan deviation with 95 % bands; dashed: Q, N, B, K, R fitted to it; markers: the fitted white noise N \
         at 1 s, which is its density. N, B, K: white noise, bias instability, walk, in SI units per √Hz, SI units, SI units per s and √Hz. {words}"
    );
    let header = vec!["sensor", "axis", "unit", "tau_s", "deviation", "low", "high", "model"];
    Ok(Chart::side_by_side(legend, caption, panels, Drawn { header, rows }))
}

fn panel(sensor: Sensor, axes: &[&AxisFit]) -> Result<(String, Axis, Axis, Vec<Layer>), FigureError> {
    for axis in axes {
        let points = &axis.fit.points;
        let what = |column: &str| format!("{column} of {sensor} {}", axis.axis);
        if points.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: what("point") });
        }
        for (column, values) in [
            ("averaging time", points.iter().map(|p| p.tau).collect::<Vec<_>>()),
            ("deviation", points.iter().map(|p| p.deviation).collect()),
        ] {
            let need = "it must be finite and positive";
            check_each(FIGURE, &what(column), &values, need, |v| v.is_finite() && v > 0.0)?;
        }
    }
    let Some(first) = axes.first().map(|axis| &axis.fit.points) else {
        return Err(FigureError::Empty { figure: FIGURE, what: format!("axis of the {sensor}") });
    };
    let (from, to) = (first[0].tau, first[first.len() - 1].tau);
    let (low, high) = extent(axes.iter().flat_map(|axis| &axis.fit.points).map(|p| p.deviation));
    let unit = style::unit(sensor);
    let x = Axis::log("averaging time τ [s]".into(), from, to);
    let y = Axis::log(format!("Allan deviation [{unit}]"), low / 1.6, high * 1.4);
    let along = |axis: &AxisFit, value: fn(&Point) -> f64| -> Vec<(f64, f64)> {
        axis.fit.points.iter().map(|p| (p.tau, value(p))).collect()
    };
    let coloured = || axes.iter().zip(PALETTE);
    let mut layers: Vec<Layer> = coloured()
        .map(|(axis, colour)| {
            Layer::band(along(axis, |p| p.high), along(axis, |p| p.low), pale(colour, 0.18))
        })
        .collect();
    layers.extend(
        coloured().map(|(axis, colour)| {
            Layer::Line(along(axis, |p| p.deviation), style::stroke(colour, style::LINE))
        }),
    );
    layers.extend(
        axes.iter()
            .map(|axis| Layer::Dashed(along(axis, |p| p.model), style::stroke(style::INK, style::THIN))),
    );
    // The upper right corner is free: a deviation begins above and falls.
    let shown = [Coefficient::White, Coefficient::Instability, Coefficient::Walk];
    for (row, (axis, colour)) in (0..).zip(coloured()) {
        let value = |c: Coefficient| match axis.fit.of(c) {
            of if of.seen => format!("{} {:.2e}", c.letter(), of.value),
            of => format!("{} below {:.1e}", c.letter(), of.high),
        };
        let words = format!("{}:  {}", axis.axis, shown.map(value).join("  "));
        layers.push(Layer::Words(words, style::CAPTION, colour, Anchor::East, (HALF, 20 + 34 * row)));
    }
    for (i, (axis, colour)) in coloured().enumerate() {
        let white = axis.fit.of(Coefficient::White).value;
        if white > 0.0 && (x.low()..=x.high()).contains(&1.0) {
            layers.push(Layer::Mark(i, (1.0, white), colour));
        }
    }
    Ok((style::title(sensor).to_owned(), x, y, layers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};
    use dpn_core::SampleRate;
    use dpn_core::random::Stream;
    use dpn_probe::allan::Planner;
    use rand::Rng;

    fn axes() -> Vec<AxisFit> {
        let planner = Planner::new(3000, SampleRate::HZ_200);
        let mut rng = Stream::new(1).named("plot").rng();
        let mut all = Vec::new();
        for sensor in Sensor::ALL {
            for axis in ["x", "y", "z"] {
                let signal: Vec<f64> = (0..3000).map(|_| rng.random::<f64>()).collect();
                all.push(AxisFit { sensor, axis, fit: planner.fit(&signal).unwrap() });
            }
        }
        all
    }

    #[test]
    fn the_csv_holds_what_is_drawn_and_the_axes_their_units() {
        let axes = axes();
        let plot = allan_plot(&axes, "Made-up.").unwrap();
        let csv = plot.csv();
        assert_eq!(csv.rows.len(), 6 * axes[0].fit.points.len());
        assert_eq!(csv.rows[0][3].parse::<f64>().unwrap(), axes[0].fit.points[0].tau);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["averaging time τ [s]", "Allan deviation [m/s²]", "Allan deviation [rad/s]", "Made-up."]
        {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn a_sensor_without_axes_is_refused() {
        let axes = axes();
        assert!(matches!(allan_plot(&axes[..3], ""), Err(FigureError::Empty { .. })));
    }
}
