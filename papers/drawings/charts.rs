//! RMSE against true deviation, and errors against the constant told.

use super::super::study::{Line, Study};
use dpn_core::estimate::NoiseSpec;
use dpn_eval::open_loop;
use dpn_figures::{FigureError, RmseVsSigma, SweepCurve, SweepPoint};
use dpn_train::windows::WINDOW;

/// Estimators drawn over the bound.
const SHOWN: [&str; 5] = ["pronet", "pronet-paper", "kernel-svr", "diff2", "sg(11,2)"];

/// Of the test windows on the paper's grid over SG(11,2), else over the first base there is; of the training windows where there are no others.
pub(crate) fn rmse(rows: &[open_loop::Row], data: &str) -> Result<RmseVsSigma, FigureError> {
    let wanted = |row: &&open_loop::Row| {
        row.levels == "grid"
            && row.label == "sigma_inj"
            && row.data == data
            && SHOWN.contains(&row.estimator.as_str())
    };
    let rows: Vec<&open_loop::Row> = rows.iter().filter(wanted).collect();
    let split = if rows.iter().any(|row| row.split == "test") { "test" } else { "train" };
    let of_split = || rows.iter().copied().filter(|row| row.split == split);
    let base = of_split()
        .find(|row| row.base == "sg(11,2)")
        .or(of_split().next())
        .map_or_else(String::new, |row| row.base.clone());
    let of_base: Vec<&open_loop::Row> = of_split().filter(|row| row.base == base).collect();
    RmseVsSigma::new(&of_base, WINDOW)
}

/// What a noise says, in multiples of the baseline: the geometric mean of both sensors'.
fn multiple(line: &Line) -> Option<f64> {
    if let Some(multiple) = line.noise.parse::<NoiseSpec>().ok().and_then(|noise| noise.multiple()) {
        return Some(multiple);
    }
    let [accel, gyro] = line.told?;
    Some((accel / 0.08 * gyro / 0.004).sqrt())
}

fn point(line: &Line) -> Option<SweepPoint> {
    Some(SweepPoint {
        name: line.noise.clone(),
        multiple: multiple(line)?,
        error: line.ate?,
        interval: line.ate_interval,
    })
}

/// Whether any multiple of the baseline has an error, so that there is a curve to draw.
pub(crate) fn has_curve(study: &Study) -> bool {
    let is_multiple =
        |line: &&Line| line.noise.parse::<NoiseSpec>().is_ok_and(|noise| noise.multiple().is_some());
    study.lines.iter().filter(is_multiple).any(|line| line.ate.is_some())
}

fn curve(study: &Study, marks: &[&str], caption: &str) -> Result<SweepCurve, FigureError> {
    let is_multiple =
        |line: &&Line| line.noise.parse::<NoiseSpec>().is_ok_and(|noise| noise.multiple().is_some());
    let mut constants: Vec<SweepPoint> = study.lines.iter().filter(is_multiple).filter_map(point).collect();
    constants.sort_by(|a, b| a.multiple.total_cmp(&b.multiple));
    let of = |name: &&str| study.lines.iter().find(|line| line.noise == **name).and_then(point);
    let marks: Vec<SweepPoint> = marks.iter().filter_map(of).collect();
    SweepCurve::new(&constants, &marks, "ATE, median over sequences", caption)
}

/// The sweep of the study.
pub(crate) fn sweep(study: &Study, caption: &str) -> Result<SweepCurve, FigureError> {
    let marks =
        ["dualpronet", "mean(dualpronet)", "shuffled(dualpronet)", "mean-of-train(dualpronet)", "diff2"];
    curve(study, &marks, caption)
}

/// The sweep under injected noise.
pub(crate) fn injected_sweep(study: &Study, caption: &str) -> Result<SweepCurve, FigureError> {
    let adaptive = "plus(dualpronet(wide-s0),x4)";
    let marks =
        ["oracle", adaptive, &format!("mean({adaptive})"), &format!("shuffled({adaptive})"), "dualpronet"];
    curve(study, &marks, caption)
}
