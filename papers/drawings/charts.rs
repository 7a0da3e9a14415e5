//! RMSE against true deviation, and errors against the constant given.

use super::super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::open_loop;
use dpn_eval::study::{NoiseSummary, Study};
use dpn_figures::{Chart, FigureError, SweepPoint, rmse_vs_sigma, sweep_curve};
use dpn_train::label::Label;
use dpn_train::split::Side;
use dpn_train::windows::WINDOW;

/// Estimators drawn over the bound.
const SHOWN: [&str; 5] = ["pronet", "pronet-paper", "kernel-svr", "diff2", "sg(11,2)"];

/// Of the test windows on the paper's grid over SG(11,2), else over the first base there is; of the training windows where there are no others.
pub(crate) fn rmse(rows: &[open_loop::Row], data: &str) -> Result<Chart, FigureError> {
    let wanted = |row: &&open_loop::Row| {
        row.levels == "grid"
            && row.label == Label::Injected
            && row.data == data
            && SHOWN.contains(&row.estimator.as_str())
    };
    let rows: Vec<&open_loop::Row> = rows.iter().filter(wanted).collect();
    let split = if rows.iter().any(|row| row.split == Side::Test) { Side::Test } else { Side::Train };
    let of_split = || rows.iter().copied().filter(|row| row.split == split);
    let base = of_split()
        .find(|row| row.base == "sg(11,2)")
        .or(of_split().next())
        .map_or_else(String::new, |row| row.base.clone());
    let named = |row: &open_loop::Row| open_loop::Row {
        estimator: specs::estimator_name(&row.estimator),
        ..row.clone()
    };
    let of_base: Vec<open_loop::Row> = of_split().filter(|row| row.base == base).map(named).collect();
    rmse_vs_sigma(&of_base.iter().collect::<Vec<_>>(), WINDOW)
}

/// Where a noise stands among multiples of the baseline: its own, or the geometric mean of both sensors' given.
fn multiple(line: &NoiseSummary) -> Option<f64> {
    line.noise.multiple().or_else(|| {
        let [accel, gyro] = line.noise_rms?;
        Some((accel / 0.08 * gyro / 0.004).sqrt())
    })
}

fn point(line: &NoiseSummary) -> Option<SweepPoint> {
    Some(SweepPoint {
        // A constant's place says the rest.
        name: line
            .noise
            .multiple()
            .map_or_else(|| specs::name(&line.noise), |multiple| format!("x{multiple}")),
        multiple: multiple(line)?,
        error: line.ate?,
        interval: line.ate_interval,
    })
}

/// The multiples of the baseline among the noises.
fn multiples(study: &Study) -> impl Iterator<Item = &NoiseSummary> {
    study.noises.iter().filter(|line| line.noise.multiple().is_some())
}

/// Whether any multiple of the baseline has an error, so that there is a curve to draw.
pub(crate) fn has_curve(study: &Study) -> bool {
    multiples(study).any(|line| line.ate.is_some())
}

fn curve(study: &Study, marks: &[NoiseSpec], caption: &str) -> Result<Chart, FigureError> {
    let mut constants: Vec<SweepPoint> = multiples(study).filter_map(point).collect();
    constants.sort_by(|a, b| a.multiple.total_cmp(&b.multiple));
    let marks: Vec<SweepPoint> = marks.iter().filter_map(|noise| study.of(noise).and_then(point)).collect();
    sweep_curve(&constants, &marks, "ATE, median over sequences", caption)
}

/// Errors by what a noise says, of whatever was run: a curve through the multiples of the baseline, the first five other noises as marks.
///
/// # Errors
/// [`FigureError::Empty`] where no multiple was run.
pub fn loop_curve(study: &Study) -> Result<Chart, FigureError> {
    let others = study.noises.iter().filter(|line| line.noise.multiple().is_none() && line.ate.is_some());
    curve(study, &others.take(5).map(|line| line.noise.clone()).collect::<Vec<_>>(), "")
}

/// The sweep of the study.
pub(crate) fn sweep(study: &Study, caption: &str) -> Result<Chart, FigureError> {
    let marks =
        ["dualpronet", "mean(dualpronet)", "shuffled(dualpronet)", "mean-of-train(dualpronet)", "diff2"];
    curve(study, &specs::noises(marks), caption)
}

/// The sweep under injected noise.
pub(crate) fn injected_sweep(study: &Study, caption: &str) -> Result<Chart, FigureError> {
    let [oracle, adaptive, dualpronet] = specs::noises([specs::ORACLE, specs::WIDE_PLUS, specs::DUALPRONET]);
    let (mean, shuffled) =
        (NoiseSpec::Mean(Box::new(adaptive.clone())), NoiseSpec::Shuffled(Box::new(adaptive.clone())));
    curve(study, &[oracle, adaptive, mean, shuffled, dualpronet], caption)
}
