//! Predicted against true deviation: one panel a sensor, the identity as a line, for each estimator and true level the
//! median and the 5, 25, 75 and 95 % quantiles of what it predicted.

use super::axis::Axis;
use super::error::{FigureError, check_column, check_count, check_each};
use super::frame::{Frame, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::{BINS, Level, MOST_LEVELS, by_level, levels};
use dpn_core::Sensor;
use plotters_backend::DrawingBackend;

const FIGURE: &str = "predicted against true";
const MOST: usize = 4;

/// What some estimators predicted for windows of one sensor.
#[derive(Debug, Clone)]
pub struct Predicted<'a> {
    /// Sensor the windows are from.
    pub sensor: Sensor,
    /// True deviation of each window \[unit of the sensor\]; up to 16 distinct values are levels, more are binned.
    pub truth: &'a [f64],
    /// Name of each estimator and its prediction for each window.
    pub estimates: Vec<(&'a str, &'a [f64])>,
}

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct PredictedVsTrue {
    panels: Vec<Panel>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Panel {
    sensor: Sensor,
    x: Axis,
    y: Axis,
    series: Vec<(usize, String, Vec<Level>)>,
}

impl PredictedVsTrue {
    /// Summarises what is predicted; one panel an entry, one to four estimators in all.
    ///
    /// # Errors
    /// [`FigureError`] when there is nothing to draw, a column is of another length, a value is not finite or a true
    /// deviation is negative.
    pub fn new(predicted: &[Predicted<'_>]) -> Result<Self, FigureError> {
        let mut names: Vec<String> = Vec::new();
        let mut panels = Vec::new();
        for one in predicted {
            panels.push(Panel::new(one, &mut names)?);
        }
        if panels.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: "sensor".into() });
        }
        check_count(FIGURE, "estimators", names.len(), MOST)?;
        let mut legend = legend::entries(Key::Patch, names.iter().map(String::as_str));
        legend.push(Entry { key: Key::Line, colour: style::MUTED, words: "predicted = true".into() });
        let binned = predicted.iter().any(|one| levels(one.truth).len() > MOST_LEVELS);
        let counts: Vec<String> = predicted
            .iter()
            .map(|one| format!("{} windows ({})", grouped(one.truth.len()), one.sensor))
            .collect();
        let caption = format!(
            "White mark: median. Box: 25 to 75 %. Whisker: 5 to 95 %. {}Estimators of one level stand side by side. {}.",
            if binned {
                format!("Continuous levels in {BINS} bins of equal width, at their mean. ")
            } else {
                String::new()
            },
            counts.join(", "),
        );
        Ok(Self { panels, sheet: Sheet::of_panels(legend, caption) })
    }
}

/// Digits in groups of three.
pub(super) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

impl Panel {
    fn new(one: &Predicted<'_>, names: &mut Vec<String>) -> Result<Self, FigureError> {
        let sensor = one.sensor;
        if one.truth.is_empty() || one.estimates.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: format!("{sensor} window or estimator") });
        }
        let what = format!("true sigma of {sensor}");
        check_each(FIGURE, &what, one.truth, "it must be finite and not negative", |v| {
            v.is_finite() && v >= 0.0
        })?;
        let mut series = Vec::new();
        for (name, estimate) in &one.estimates {
            check_column(FIGURE, &format!("{sensor} {name}"), estimate, one.truth.len())?;
            let index = names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push((*name).to_owned());
                names.len() - 1
            });
            series.push((index, (*name).to_owned(), by_level(one.truth, estimate)));
        }
        series.sort_by_key(|(index, ..)| *index);
        let levels = || series.iter().flat_map(|(_, _, levels)| levels);
        let truth = levels().map(|level| level.truth).fold(0.0, f64::max);
        let spacing = truth / levels().count().max(1) as f64 * series.len() as f64;
        let top = levels().map(|level| level.quantiles[4]).fold(truth, f64::max);
        let bottom = levels().map(|level| level.quantiles[0]).fold(0.0, f64::min);
        let unit = style::unit(sensor);
        Ok(Self {
            sensor,
            x: Axis::linear(format!("true σ [{unit}]"), 0.0, truth + 0.7 * spacing, 6),
            y: Axis::linear(format!("predicted σ [{unit}]"), bottom * 1.05, top * 1.05, 8),
            series,
        })
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, rect: Rect) -> Painted<DB> {
        let frame = Frame::new(area, rect, &self.x, &self.y);
        frame.grid()?;
        let end = self.x.high().min(self.y.high());
        let line = vec![frame.at(0.0, 0.0), frame.at(end, end)];
        frame.path(line, style::stroke(style::MUTED, style::THIN + 1))?;
        // Boxes share 80 % of the narrowest distance between levels.
        let count = self.series.len() as i32;
        let nearest = self
            .series
            .iter()
            .flat_map(|(_, _, levels)| levels.windows(2))
            .map(|pair| frame.x_at(pair[1].truth) - frame.x_at(pair[0].truth))
            .min()
            .unwrap_or(80);
        let step = (nearest * 8 / 10 / count).clamp(5, 26);
        let half = (step / 2 - 1).clamp(2, 9);
        for (place, (index, _, levels)) in self.series.iter().enumerate() {
            let colour = PALETTE[index % PALETTE.len()];
            for level in levels {
                let x = frame.x_at(level.truth) + (2 * place as i32 - count + 1) * step / 2;
                let [y05, y25, y50, y75, y95] = level.quantiles.map(|q| frame.y_at(q));
                frame.path(vec![(x, y05), (x, y95)], style::stroke(colour, style::THIN + 1))?;
                // A box of no height is still seen: at least the median's mark and a rim.
                let (top, bottom) = (y75.min(y50 - 4), y25.max(y50 + 4));
                frame.block((x - half, top), (x + half, bottom), colour)?;
                frame.block((x - half, y50 - 1), (x + half, y50 + 2), plotters::style::WHITE)?;
            }
        }
        frame.axes(true)?;
        frame.title(style::title(self.sensor))
    }
}

impl Plot for PredictedVsTrue {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.side_by_side(area, &self.panels, |panel, rect| panel.draw(area, rect))
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        for panel in &self.panels {
            for (_, name, levels) in &panel.series {
                for level in levels {
                    let (sensor, unit) = (panel.sensor.name(), panel.sensor.unit());
                    let mut row = row![sensor, unit, name, level.truth, level.n];
                    row.extend(level.quantiles.map(|q| q.to_string()));
                    rows.push(row);
                }
            }
        }
        Drawn {
            header: vec!["sensor", "unit", "estimator", "true_sigma", "n", "q05", "q25", "q50", "q75", "q95"],
            rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    fn case(sensor: Sensor) -> (Vec<f64>, Vec<f64>) {
        let scale = if sensor == Sensor::Accel { 1.0 } else { 0.1 };
        let truth: Vec<f64> = (0..220).map(|i| scale * (0.01 + 0.02 * f64::from(i % 11))).collect();
        let estimate = (0..220).map(|i| truth[i] * (0.9 + 0.01 * (i / 11) as f64)).collect();
        (truth, estimate)
    }

    #[test]
    fn the_csv_holds_the_quantiles_of_the_input() {
        let (truth, estimate) = case(Sensor::Accel);
        let plot = PredictedVsTrue::new(&[Predicted {
            sensor: Sensor::Accel,
            truth: &truth,
            estimates: vec![("network", &estimate), ("copy", &truth)],
        }])
        .unwrap();
        let csv = plot.csv();
        assert_eq!(csv.rows.len(), 22);
        let row: Vec<f64> = csv.rows[3][3..].iter().map(|v| v.parse().unwrap()).collect();
        assert_eq!((row[0], row[1]), (truth[3], 20.0));
        // 20 equal steps from 0.9 to 1.09: the median is 0.995 of the truth.
        assert!((row[4] - 0.995 * truth[3]).abs() < 1e-12);
        assert!(csv.rows[14][3..].iter().skip(2).all(|q| *q == truth[3].to_string()));
    }

    #[test]
    fn both_sensors_have_their_unit_on_both_axes() {
        let (accel, gyro) = (case(Sensor::Accel), case(Sensor::Gyro));
        let panel = |sensor, case: &'static str, data: &(Vec<f64>, Vec<f64>)| -> PredictedVsTrue {
            PredictedVsTrue::new(&[Predicted { sensor, truth: &data.0, estimates: vec![(case, &data.1)] }])
                .unwrap()
        };
        for (sensor, data, unit) in [(Sensor::Accel, &accel, "m/s²"), (Sensor::Gyro, &gyro, "rad/s")] {
            let text = String::from_utf8(svg(&panel(sensor, "a & b", data)).unwrap()).unwrap();
            for words in [format!("true σ [{unit}]"), format!("predicted σ [{unit}]"), "a &amp; b".into()] {
                assert!(text.contains(&words), "{words}");
            }
        }
    }

    #[test]
    fn faults_of_the_input_are_named() {
        let of = |truth: &[f64], estimate: &[f64]| {
            PredictedVsTrue::new(&[Predicted {
                sensor: Sensor::Gyro,
                truth,
                estimates: vec![("mad2", estimate)],
            }])
            .unwrap_err()
            .to_string()
        };
        assert!(of(&[0.1, 0.2], &[0.1]).contains("gyro mad2 has 1 values where 2"));
        assert!(of(&[0.1, -0.2], &[0.1, 0.2]).contains("is -0.2 at index 1"));
        assert!(of(&[], &[]).contains("no gyro window"));
        assert!(PredictedVsTrue::new(&[]).is_err());
        assert_eq!([grouped(7), grouped(1234), grouped(20_427_000)], ["7", "1,234", "20,427,000"]);
    }
}
