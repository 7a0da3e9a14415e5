//! RMSE against true deviation, both logarithmic: one panel a sensor, one line an estimator, and the Cramer-Rao bound
//! sigma / sqrt(2 n) below which no unbiased estimator gets.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::{FigureError, check_count, check_each};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use dpn_core::Sensor;
use dpn_core::bounds::cramer_rao_sigma;
use dpn_eval::open_loop::Row;

const FIGURE: &str = "RMSE against sigma";
const MOST: usize = 6;

/// Lines from the bins of `rows`: one row an estimator and sensor, all of one base, split, kind of level and label; at
/// most six estimators. `window` is the number of samples an estimate is made from, which the bound depends on.
///
/// # Errors
/// [`FigureError`] when there is nothing to draw, there are two rows for one line, or a value is not finite or a true
/// deviation not positive.
pub fn rmse_vs_sigma(rows: &[&Row], window: usize) -> Result<Chart, FigureError> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.estimator.as_str()) {
            names.push(&row.estimator);
        }
    }
    check_count(FIGURE, "estimators", names.len(), MOST)?;
    let header = vec!["sensor", "unit", "estimator", "true_sigma", "rmse", "bias", "n"];
    let (mut panels, mut drawn) = (Vec::new(), Drawn { header, rows: Vec::new() });
    for sensor in Sensor::ALL {
        let of: Vec<&Row> = rows.iter().filter(|row| row.sensor == sensor).copied().collect();
        if !of.is_empty() {
            panels.push(panel(sensor, &of, &names, window, &mut drawn)?);
        }
    }
    let Some(first) = rows.first().filter(|_| !panels.is_empty()) else {
        return Err(FigureError::Empty { figure: FIGURE, what: "row".into() });
    };
    let mut legend = legend::marked(names.iter().copied());
    legend.push(Entry { key: Key::Line, colour: style::INK, words: "Cramér-Rao bound".into() });
    let caption = format!(
        "Data {}, base {}, split {}, levels {}, label {}. Bound: σ / √(2·{window}), for unbiased estimates from \
         {window} samples of white noise.",
        first.data, first.base, first.split, first.levels, first.label,
    );
    Ok(Chart::side_by_side(legend, caption, panels, drawn))
}

fn panel(
    sensor: Sensor,
    rows: &[&Row],
    names: &[&str],
    window: usize,
    drawn: &mut Drawn,
) -> Result<(String, Axis, Axis, Vec<Layer>), FigureError> {
    let place = |row: &Row| names.iter().position(|name| *name == row.estimator);
    let mut rows = rows.to_vec();
    rows.sort_by_key(|row| place(row));
    if rows.windows(2).any(|pair| pair[0].estimator == pair[1].estimator) {
        let what = "rows for one sensor and estimator";
        return Err(FigureError::TooMany { figure: FIGURE, what, found: 2, most: 1 });
    }
    for row in &rows {
        let what = |column: &str| format!("{column} of {sensor} {}", row.estimator);
        if row.by_sigma.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: what("bin") });
        }
        let sigma: Vec<f64> = row.by_sigma.iter().map(|bin| bin.sigma).collect();
        let rmse: Vec<f64> = row.by_sigma.iter().map(|bin| bin.rmse).collect();
        let need = "it must be finite and positive";
        check_each(FIGURE, &what("true sigma"), &sigma, need, |v| v.is_finite() && v > 0.0)?;
        let need = "it must be finite and not negative";
        check_each(FIGURE, &what("RMSE"), &rmse, need, |v| v.is_finite() && v >= 0.0)?;
    }
    let bins = || rows.iter().flat_map(|row| &row.by_sigma);
    let low = bins().map(|bin| bin.sigma).fold(f64::INFINITY, f64::min);
    let high = bins().map(|bin| bin.sigma).fold(0.0, f64::max);
    let bound = [low, high].map(|sigma| (sigma, cramer_rao_sigma(sigma, window)));
    // An RMSE of 0 cannot be placed; it is held at the lower edge.
    let least = bins().map(|bin| bin.rmse).filter(|v| *v > 0.0).fold(bound[0].1, f64::min);
    let most = bins().map(|bin| bin.rmse).fold(bound[1].1, f64::max);
    let unit = style::unit(sensor);
    let x = Axis::log(format!("true σ [{unit}]"), low / 1.12, high * 1.12);
    let y = Axis::log(format!("RMSE of predicted σ [{unit}]"), least / 1.25, most * 1.25);

    let mut layers = vec![Layer::Line(bound.to_vec(), style::stroke(style::INK, style::LINE - 1))];
    let (name, unit) = (sensor.name(), sensor.unit());
    for row in &rows {
        let index = place(row).expect("names are those of the rows");
        let colour = PALETTE[index % PALETTE.len()];
        let points: Vec<(f64, f64)> = row.by_sigma.iter().map(|bin| (bin.sigma, bin.rmse)).collect();
        layers.push(Layer::Line(points.clone(), style::stroke(colour, style::LINE)));
        layers.extend(points.into_iter().map(|point| Layer::Mark(index, point, colour)));
        let bins = row.by_sigma.iter();
        drawn
            .rows
            .extend(bins.map(|bin| row![name, unit, row.estimator, bin.sigma, bin.rmse, bin.bias, bin.n]));
    }
    drawn.rows.extend(bound.map(|(sigma, bound)| row![name, unit, "cramer-rao", sigma, bound, "", ""]));
    Ok((style::title(sensor).to_owned(), x, y, layers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};
    use dpn_eval::open_loop::SigmaBin;
    use dpn_train::label::Label;
    use dpn_train::split::Side;

    fn row(sensor: Sensor, estimator: &str, rmse: &[f64]) -> Row {
        let by_sigma = (0..)
            .zip(rmse)
            .map(|(i, &rmse)| SigmaBin { sigma: 0.01 + 0.02 * f64::from(i), rmse, bias: -0.1 * rmse, n: 7 })
            .collect();
        Row {
            sensor,
            base: "sg(5,2)".into(),
            data: "euroc".into(),
            split: Side::Test,
            estimator: estimator.into(),
            levels: "grid".into(),
            label: Label::Injected,
            rmse: 0.1,
            rmse_spread: None,
            bias: 0.0,
            crb: 0.05,
            ratio: 2.0,
            n: 21,
            seeds: 0,
            outside: None,
            by_sigma,
        }
    }

    #[test]
    fn the_csv_holds_the_bins_and_the_bound() {
        let accel = row(Sensor::Accel, "a", &[0.011, 0.012, 0.013]);
        let gyro = row(Sensor::Gyro, "a", &[0.001, 0.1 + 0.2, 0.003]);
        let csv = rmse_vs_sigma(&[&accel, &gyro], 200).unwrap().csv();
        assert_eq!(csv.rows.len(), 10);
        let read = |row: usize, column: usize| csv.rows[row][column].parse::<f64>().unwrap();
        for (i, bin) in accel.by_sigma.iter().enumerate() {
            assert_eq!([read(i, 3), read(i, 4), read(i, 5)], [bin.sigma, bin.rmse, bin.bias]);
        }
        assert_eq!(csv.rows[6][4], "0.30000000000000004");
        assert!((read(4, 4) - 0.05 / 20.0).abs() < 1e-15);
    }

    #[test]
    fn axes_carry_units_and_the_caption_the_set_up() {
        let rows = [row(Sensor::Accel, "a", &[0.01, 0.02]), row(Sensor::Gyro, "b", &[0.0, 0.02])];
        let plot = rmse_vs_sigma(&[&rows[0], &rows[1]], 200).unwrap();
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in
            ["true σ [m/s²]", "RMSE of predicted σ [rad/s]", "base sg(5,2), split test", "Cramér-Rao bound"]
        {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn faults_of_the_input_are_named() {
        let one = row(Sensor::Accel, "a", &[0.01]);
        assert!(matches!(rmse_vs_sigma(&[], 200), Err(FigureError::Empty { .. })));
        let twice = rmse_vs_sigma(&[&one, &one], 200).unwrap_err();
        assert!(matches!(twice, FigureError::TooMany { most: 1, .. }));
        let nan = row(Sensor::Accel, "a", &[0.01, f64::NAN]);
        let error = rmse_vs_sigma(&[&nan], 200).unwrap_err().to_string();
        assert!(error.contains("RMSE of accel a is NaN at index 1"), "{error}");
    }
}
