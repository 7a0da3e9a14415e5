//! Predicted against true deviation: one panel a sensor, the identity as a line, for each estimator and true level the
//! median and the 5, 25, 75 and 95 % quantiles of what it predicted.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::{FigureError, check_column, check_count, check_each};
use super::frame::{LEFT, RIGHT};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use super::summary::{BINS, MOST_LEVELS, by_level, levels};
use dpn_core::Sensor;

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

/// Summarises what is predicted; one panel an entry, one to four estimators in all.
///
/// # Errors
/// [`FigureError`] when there is nothing to draw, a column is of another length, a value is not finite or a true
/// deviation is negative.
pub fn predicted_vs_true(predicted: &[Predicted<'_>]) -> Result<Chart, FigureError> {
    let (mut names, mut panels, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let room = style::WIDTH as i32 / predicted.len().max(1) as i32 - LEFT - RIGHT;
    for one in predicted {
        panels.push(panel(one, &mut names, room, &mut rows)?);
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
    let header = vec!["sensor", "unit", "estimator", "true_sigma", "n", "q05", "q25", "q50", "q75", "q95"];
    Ok(Chart::side_by_side(legend, caption, panels, Drawn { header, rows }))
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

/// A panel of `room` pixels.
fn panel(
    one: &Predicted<'_>,
    names: &mut Vec<String>,
    room: i32,
    rows: &mut Vec<Vec<String>>,
) -> Result<(String, Axis, Axis, Vec<Layer>), FigureError> {
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
    let x = Axis::linear(format!("true σ [{unit}]"), 0.0, truth + 0.7 * spacing, 6);
    let y = Axis::linear(format!("predicted σ [{unit}]"), bottom * 1.05, top * 1.05, 8);
    let end = x.high().min(y.high());
    let identity = vec![(0.0, 0.0), (end, end)];
    let mut layers = vec![Layer::Line(identity, style::stroke(style::MUTED, style::THIN + 1))];
    // Boxes share 80 % of the narrowest distance between levels.
    let count = series.len() as i32;
    let x_at = |value: f64| (x.fraction(value) * f64::from(room)).round() as i32;
    let pairs = series.iter().flat_map(|(_, _, levels)| levels.windows(2));
    let nearest = pairs.map(|pair| x_at(pair[1].truth) - x_at(pair[0].truth)).min().unwrap_or(80);
    let step = (nearest * 8 / 10 / count).clamp(5, 26);
    let half = (step / 2 - 1).clamp(2, 9);
    for (place, (index, name, levels)) in series.iter().enumerate() {
        let colour = PALETTE[index % PALETTE.len()];
        let shift = (2 * place as i32 - count + 1) * step / 2;
        for level in levels {
            layers.push(Layer::Quantiles { at: level.truth, shift, half, of: level.quantiles, colour });
            let mut row = row![sensor.name(), sensor.unit(), name, level.truth, level.n];
            row.extend(level.quantiles.map(|q| q.to_string()));
            rows.push(row);
        }
    }
    Ok((style::title(sensor).to_owned(), x, y, layers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn case(sensor: Sensor) -> (Vec<f64>, Vec<f64>) {
        let scale = if sensor == Sensor::Accel { 1.0 } else { 0.1 };
        let truth: Vec<f64> = (0..220).map(|i| scale * (0.01 + 0.02 * f64::from(i % 11))).collect();
        let estimate = (0..220).map(|i| truth[i] * (0.9 + 0.01 * (i / 11) as f64)).collect();
        (truth, estimate)
    }

    #[test]
    fn the_csv_holds_the_quantiles_of_the_input() {
        let (truth, estimate) = case(Sensor::Accel);
        let plot = predicted_vs_true(&[Predicted {
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
        let panel = |sensor, case: &'static str, data: &(Vec<f64>, Vec<f64>)| -> Chart {
            predicted_vs_true(&[Predicted { sensor, truth: &data.0, estimates: vec![(case, &data.1)] }])
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
            predicted_vs_true(&[Predicted {
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
        assert!(predicted_vs_true(&[]).is_err());
        assert_eq!([grouped(7), grouped(1234), grouped(20_427_000)], ["7", "1,234", "20,427,000"]);
    }
}
