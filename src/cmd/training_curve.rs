//! The curve of a finished training.

use anyhow::Result;
use dpn_core::Sensor;
use dpn_figures::{save, training_curve};
use dpn_io::ResultPath;
use dpn_train::run::{RunSummary, history};

/// Draws the curve of the finished training in `out`, beside its weights.
pub(super) fn draw_curve(sensor: Sensor, summary: &RunSummary, out: &ResultPath) -> Result<()> {
    let words = format!("{} on {}, seed {}.", summary.name, summary.data, summary.seed);
    let history = history(out)?;
    save(&training_curve(sensor, &history, Some(summary.best_epoch), &words)?, out.join("training"))?;
    Ok(())
}
