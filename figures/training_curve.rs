//! A training: loss and error on the validation windows over epochs, a panel each, the error logarithmic; the epoch whose weights were kept.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::FigureError;
use super::legend::{Entry, Key};
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_train::state::EpochRecord;

const FIGURE: &str = "training curve";

/// Of a run's epochs; `kept` is the epoch whose weights were kept, `words` end the small print.
///
/// # Errors
/// [`FigureError::Empty`] without an epoch.
pub fn training_curve(
    sensor: Sensor,
    history: &[EpochRecord],
    kept: Option<u64>,
    words: &str,
) -> Result<Chart, FigureError> {
    let loss: Vec<_> = history.iter().map(|record| (record.epoch, record.loss)).collect();
    let validated: Vec<_> =
        history.iter().filter_map(|record| Some((record.epoch, record.validation_rmse?))).collect();
    let error = format!("RMSE of predicted σ [{}]", style::unit(sensor));
    let panels: Vec<_> =
        [panel("Training", "loss", &loss, None), panel("Validation", &error, &validated, kept)]
            .into_iter()
            .flatten()
            .collect();
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "epoch with a positive loss".into() });
    }
    let entry = |key, colour, words: &str| Entry { key, colour, words: words.to_owned() };
    let mut legend = vec![entry(Key::Line, PALETTE[0], "by epoch")];
    let is_mark = |layer: &Layer| matches!(layer, Layer::Mark(..));
    if panels.iter().any(|(.., layers)| layers.iter().any(is_mark)) {
        legend.push(entry(Key::Marked(0), PALETTE[1], "weights that were kept"));
    }
    let caption = format!(
        "{} sensor, {} epochs. Loss: of the weights as the optimiser moves them; validation: of their running mean. {words}",
        style::title(sensor),
        history.len()
    );
    let record = |r: &EpochRecord| {
        let rmse = r.validation_rmse.map_or_else(String::new, |rmse| rmse.to_string());
        row![r.epoch, r.loss, rmse, r.learning_rate]
    };
    let header = vec!["epoch", "loss", "validation_rmse", "learning_rate"];
    let drawn = Drawn { header, rows: history.iter().map(record).collect() };
    Ok(Chart::side_by_side(legend, caption, panels, drawn))
}

/// Of what can be placed on a logarithmic axis; nothing where nothing can.
fn panel(
    title: &str,
    label: &str,
    all: &[(u64, f64)],
    kept: Option<u64>,
) -> Option<(String, Axis, Axis, Vec<Layer>)> {
    let placed = |(_, value): &(u64, f64)| value.is_finite() && *value > 0.0;
    let line: Vec<(f64, f64)> =
        all.iter().copied().filter(placed).map(|(epoch, value)| (epoch as f64, value)).collect();
    let (first, last) = (line.first()?.0, line.last()?.0);
    let (low, high) = extent(line.iter().map(|point| point.1));
    let kept = kept.and_then(|kept| line.iter().copied().find(|point| point.0 == kept as f64));
    let x = Axis::linear("epoch".into(), first.min(1.0), last.max(first + 1.0), 8);
    let y = Axis::log(label.to_owned(), low / 1.15, high * 1.15);
    let line = Layer::Line(line, style::stroke(PALETTE[0], style::LINE));
    let mark = kept.map(|kept| Layer::Mark(0, kept, PALETTE[1]));
    Some((title.to_owned(), x, y, std::iter::once(line).chain(mark).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};

    fn record(epoch: u64, loss: f64, validation_rmse: Option<f64>) -> EpochRecord {
        EpochRecord { epoch, loss, validation_rmse, learning_rate: 1e-3, calibration: None }
    }

    #[test]
    fn a_training_has_a_panel_for_its_loss_and_one_for_its_validation() {
        let history = [record(1, 0.5, None), record(2, 0.2, Some(0.05)), record(3, 0.1, Some(0.06))];
        let plot = training_curve(Sensor::Accel, &history, Some(2), "Run: here.").unwrap();
        let validation = panel("Validation", "", &[(2, 0.05), (3, 0.06)], Some(2)).unwrap();
        assert!(matches!(validation.3[1], Layer::Mark(0, (2.0, 0.05), _)));
        assert_eq!(plot.csv().rows[0], ["1", "0.5", "", "0.001"]);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["Training", "Validation", "epoch", "m/s²", "weights that were kept", "Run: here."] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn one_epoch_without_validation_is_drawn_and_none_is_refused() {
        let plot = training_curve(Sensor::Gyro, &[record(1, 0.5, None)], None, "").unwrap();
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        assert!(text.contains("Training") && !text.contains("Validation"));
        assert!(matches!(training_curve(Sensor::Gyro, &[], None, ""), Err(FigureError::Empty { .. })));
        let zero = training_curve(Sensor::Gyro, &[record(1, 0.0, Some(0.0))], None, "");
        assert!(matches!(zero, Err(FigureError::Empty { .. })));
    }
}
