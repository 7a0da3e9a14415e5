//! A training: loss and error on the validation windows over epochs, a panel each, the error logarithmic; the epoch whose weights were kept.

use super::axis::Axis;
use super::error::FigureError;
use super::frame::{Frame, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_train::state::EpochRecord;
use plotters_backend::DrawingBackend;

const FIGURE: &str = "training curve";

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct TrainingCurve {
    history: Vec<EpochRecord>,
    panels: Vec<Panel>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Panel {
    title: &'static str,
    x: Axis,
    y: Axis,
    line: Vec<(f64, f64)>,
    kept: Option<(f64, f64)>,
}

impl TrainingCurve {
    /// Of a run's epochs; `kept` is the epoch whose weights were kept, `words` end the small print.
    ///
    /// # Errors
    /// [`FigureError::Empty`] without an epoch.
    pub fn new(
        sensor: Sensor,
        history: &[EpochRecord],
        kept: Option<u64>,
        words: &str,
    ) -> Result<Self, FigureError> {
        let loss: Vec<_> = history.iter().map(|record| (record.epoch, record.loss)).collect();
        let validated: Vec<_> =
            history.iter().filter_map(|record| Some((record.epoch, record.validation_rmse?))).collect();
        let error = format!("RMSE of predicted σ [{}]", style::unit(sensor));
        let panels: Vec<Panel> =
            [Panel::new("Training", "loss", &loss, None), Panel::new("Validation", &error, &validated, kept)]
                .into_iter()
                .flatten()
                .collect();
        if panels.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: "epoch with a positive loss".into() });
        }
        let mut legend = vec![Entry { key: Key::Line, colour: PALETTE[0], words: "by epoch".into() }];
        if panels.iter().any(|panel| panel.kept.is_some()) {
            legend.push(Entry {
                key: Key::Marked(0),
                colour: PALETTE[1],
                words: "weights that were kept".into(),
            });
        }
        let caption = format!(
            "{} sensor, {} epochs. Loss: of the weights as the optimiser moves them; validation: of their running mean. {words}",
            style::title(sensor),
            history.len()
        );
        Ok(Self { history: history.to_vec(), panels, sheet: Sheet::of_panels(legend, caption) })
    }
}

impl Panel {
    /// Of what can be placed on a logarithmic axis; nothing where nothing can.
    fn new(title: &'static str, label: &str, all: &[(u64, f64)], kept: Option<u64>) -> Option<Self> {
        let placed = |(_, value): &(u64, f64)| value.is_finite() && *value > 0.0;
        let line: Vec<(f64, f64)> =
            all.iter().copied().filter(placed).map(|(epoch, value)| (epoch as f64, value)).collect();
        let (first, last) = (line.first()?.0, line.last()?.0);
        let (low, high) = extent(line.iter().map(|point| point.1));
        let kept = kept.and_then(|kept| line.iter().copied().find(|point| point.0 == kept as f64));
        Some(Self {
            title,
            x: Axis::linear("epoch".into(), first.min(1.0), last.max(first + 1.0), 8),
            y: Axis::log(label.to_owned(), low / 1.15, high * 1.15),
            line,
            kept,
        })
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, rect: Rect) -> Painted<DB> {
        let frame = Frame::new(area, rect, &self.x, &self.y);
        frame.grid()?;
        let line = self.line.iter().map(|&(epoch, value)| frame.at(epoch, value)).collect();
        frame.path(line, style::stroke(PALETTE[0], style::LINE))?;
        if let Some((epoch, value)) = self.kept {
            legend::marker(area, 0, frame.at(epoch, value), PALETTE[1])?;
        }
        frame.axes(true)?;
        frame.title(self.title)
    }
}

impl Plot for TrainingCurve {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.side_by_side(area, &self.panels, |panel, rect| panel.draw(area, rect))
    }

    fn csv(&self) -> Drawn {
        let record = |r: &EpochRecord| {
            let rmse = r.validation_rmse.map_or_else(String::new, |rmse| rmse.to_string());
            row![r.epoch, r.loss, rmse, r.learning_rate]
        };
        let header = vec!["epoch", "loss", "validation_rmse", "learning_rate"];
        Drawn { header, rows: self.history.iter().map(record).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    fn record(epoch: u64, loss: f64, validation_rmse: Option<f64>) -> EpochRecord {
        EpochRecord { epoch, loss, validation_rmse, learning_rate: 1e-3, calibration: None }
    }

    #[test]
    fn a_training_has_a_panel_for_its_loss_and_one_for_its_validation() {
        let history = [record(1, 0.5, None), record(2, 0.2, Some(0.05)), record(3, 0.1, Some(0.06))];
        let plot = TrainingCurve::new(Sensor::Accel, &history, Some(2), "Run: here.").unwrap();
        assert_eq!((plot.panels.len(), plot.panels[1].kept), (2, Some((2.0, 0.05))));
        assert_eq!(plot.csv().rows[0], ["1", "0.5", "", "0.001"]);
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in ["Training", "Validation", "epoch", "m/s²", "weights that were kept", "Run: here."] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn one_epoch_without_validation_is_drawn_and_none_is_refused() {
        let plot = TrainingCurve::new(Sensor::Gyro, &[record(1, 0.5, None)], None, "").unwrap();
        assert_eq!(plot.panels.len(), 1);
        assert!(svg(&plot).is_ok());
        assert!(matches!(TrainingCurve::new(Sensor::Gyro, &[], None, ""), Err(FigureError::Empty { .. })));
        let zero = TrainingCurve::new(Sensor::Gyro, &[record(1, 0.0, Some(0.0))], None, "");
        assert!(matches!(zero, Err(FigureError::Empty { .. })));
    }
}
