//! Allan plot: deviation over averaging time, both logarithmic, a panel a sensor, a line an axis with its 95 % band, the fitted model dashed
//! below it, and white noise N marked where its slope crosses one second.

use super::axis::Axis;
use super::error::{FigureError, check_each};
use super::frame::{Frame, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_probe::allan::{AxisFit, Coefficient, Point};
use plotters::style::Color;
use plotters_backend::DrawingBackend;

const FIGURE: &str = "Allan plot";

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct AllanPlot {
    panels: Vec<Panel>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Panel {
    sensor: Sensor,
    x: Axis,
    y: Axis,
    lines: Vec<Line>,
}

#[derive(Debug, Clone)]
struct Line {
    axis: &'static str,
    points: Vec<Point>,
    white: f64,
}

impl AllanPlot {
    /// The axes of a log; `words` end the small print, for example with the log's name and length.
    ///
    /// # Errors
    /// [`FigureError`] where an axis has no point, or a value is not finite and positive.
    pub fn new(axes: &[AxisFit], words: &str) -> Result<Self, FigureError> {
        let panels = Sensor::ALL
            .into_iter()
            .map(|sensor| {
                let of: Vec<&AxisFit> = axes.iter().filter(|a| a.sensor == sensor).collect();
                Panel::new(sensor, &of)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut legend = legend::marked(["x", "y", "z"]);
        legend.push(Entry { key: Key::Dashed, colour: style::INK, words: "fitted model".into() });
        let caption = format!(
            "Overlapping Allan deviation with 95 % bands; dashed: Q, N, B, K, R fitted to it; markers: the fitted white noise N \
             at 1 s, which is its density. {words}"
        );
        Ok(Self { panels, sheet: Sheet::of_panels(legend, caption) })
    }
}

impl Panel {
    fn new(sensor: Sensor, axes: &[&AxisFit]) -> Result<Self, FigureError> {
        let mut lines = Vec::new();
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
            lines.push(Line {
                axis: axis.axis,
                points: points.clone(),
                white: axis.fit.of(Coefficient::White).value,
            });
        }
        let Some(first) = lines.first() else {
            return Err(FigureError::Empty { figure: FIGURE, what: format!("axis of the {sensor}") });
        };
        let (from, to) = (first.points[0].tau, first.points[first.points.len() - 1].tau);
        let all = lines.iter().flat_map(|l| &l.points).map(|p| p.deviation);
        let (low, high) = extent(all);
        let unit = style::unit(sensor);
        Ok(Self {
            sensor,
            x: Axis::log("averaging time τ [s]".into(), from, to),
            y: Axis::log(format!("Allan deviation [{unit}]"), low / 1.6, high * 1.4),
            lines,
        })
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, rect: Rect) -> Painted<DB> {
        let frame = Frame::new(area, rect, &self.x, &self.y);
        frame.grid()?;
        for (line, colour) in self.lines.iter().zip(PALETTE) {
            let upper = line.points.iter().map(|p| frame.at(p.tau, p.high));
            let lower = line.points.iter().rev().map(|p| frame.at(p.tau, p.low));
            frame.polygon(upper.chain(lower).collect(), colour.mix(0.18))?;
        }
        for (line, colour) in self.lines.iter().zip(PALETTE) {
            let points = line.points.iter().map(|p| frame.at(p.tau, p.deviation)).collect();
            frame.path(points, style::stroke(colour, style::LINE))?;
        }
        for line in &self.lines {
            let model = line.points.iter().map(|p| frame.at(p.tau, p.model)).collect();
            frame.dashed(model, style::stroke(style::INK, style::THIN))?;
        }
        for (i, (line, colour)) in self.lines.iter().zip(PALETTE).enumerate() {
            if line.white > 0.0 && (self.x.low()..=self.x.high()).contains(&1.0) {
                legend::marker(area, i, frame.at(1.0, line.white), colour)?;
            }
        }
        frame.axes(true)?;
        frame.title(style::title(self.sensor))
    }
}

impl Plot for AllanPlot {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.side_by_side(area, &self.panels, |panel, rect| panel.draw(area, rect))
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        for panel in &self.panels {
            for line in &panel.lines {
                for p in &line.points {
                    let (name, unit) = (panel.sensor.name(), panel.sensor.unit());
                    rows.push(row![name, line.axis, unit, p.tau, p.deviation, p.low, p.high, p.model]);
                }
            }
        }
        Drawn { header: vec!["sensor", "axis", "unit", "tau_s", "deviation", "low", "high", "model"], rows }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;
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
        let plot = AllanPlot::new(&axes, "Made-up.").unwrap();
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
        assert!(matches!(AllanPlot::new(&axes[..3], ""), Err(FigureError::Empty { .. })));
    }
}
