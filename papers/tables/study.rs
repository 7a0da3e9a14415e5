//! The study's table.

use super::super::input::Input;
use super::super::specs;
use super::super::verdict::Standing;
use super::comparison::against;
use dpn_eval::study::{NoiseSummary, Study};
use dpn_figures::{Cell, Column, Provenance, Table};

/// Every noise with its errors, its consistency and its test against the best constant.
pub(crate) fn study(input: &Input, study: &Study, made_by: Provenance) -> Table {
    let columns = Column::all(
        &["noise", "verdict"],
        &[
            "ratio to best constant (95 %)",
            "p (Holm)",
            "ATE median [m] (95 %)",
            "better in",
            "mean train [m]",
            "mean test [m]",
            "p equal",
            "accel given [m/s^2]",
            "gyro given [rad/s]",
            "RPE 1 s [m]",
            "NEES position",
            "NEES orientation",
            "whitened",
            "failed",
            "restarts",
            "seeds",
        ],
    );
    let title = match &study.reference {
        Some(reference) => format!("Every noise in the closed loop against {}", reference.words()),
        None => "Every noise in the closed loop; there is no constant to compare with".to_owned(),
    };
    let mut table = Table::new("study", title, columns).made_by(made_by);
    for line in &study.noises {
        let is_reference = study.is_reference(&line.noise);
        let said = verdict(study, line, is_reference);
        table.reference_row(cells(line, said), is_reference);
    }
    table.note(format!(
        "Medians over seeds, then over sequences (one without any pose counts as worse than all; it is left out of ratios and tests), with the percentile bootstrap over sequences; ratio: geometric mean over sequences, on the seeds that both noises have. \
         p: two-sided signed-rank test over sequences, Holm's correction over all noises; p equal: two one-sided signed-rank tests \
         that the ratio lies within {:.0} %. Verdicts at .05.",
        100.0 * study.margin
    ));
    table.note("NEES: mean of 3 where the covariance is right; whitened: mean square of the whitened inertial residual, 1 where the noise \
                given is the noise there is. Given: root mean square over the runs. Times are in a table of their own.");
    if let Some(reference) = study.reference.as_ref().filter(|reference| reference.at_edge) {
        table.note(format!(
            "{} is the end of the sweep; a constant beyond it may be better.",
            specs::name(&reference.noise)
        ));
    }
    table.notes(input.notes_of_runs());
    table
}

/// What the tests say of a noise against the reference, at .05; nothing where the reference is the end of the sweep.
fn verdict(study: &Study, line: &NoiseSummary, is_reference: bool) -> &'static str {
    match &line.comparison {
        None if is_reference => "reference",
        None => "-",
        Some(_) if study.reference.as_ref().is_some_and(|reference| reference.at_edge) => "not judged",
        Some(comparison) => Standing::of(comparison).word(),
    }
}

fn cells(line: &NoiseSummary, verdict: &'static str) -> Vec<Cell> {
    let comparison = line.comparison.as_ref();
    let [ratio, better, p] = against(comparison);
    let seeds = match line.seeds {
        [low, high] if low == high => low.to_string(),
        [low, high] => format!("{low} to {high}"),
    };
    vec![
        specs::cell(&line.noise),
        Cell::text(verdict),
        ratio,
        p,
        Cell::metres_within(line.ate, line.ate_interval),
        better,
        Cell::metres(line.means[1]),
        Cell::metres(line.means[2]),
        Cell::p(comparison.and_then(|c| c.p_equal)),
        Cell::number(line.noise_rms.map(|rms| rms[0]), 3),
        Cell::number(line.noise_rms.map(|rms| rms[1]), 4),
        Cell::metres(line.rpe_1s),
        Cell::number(line.nees[0], 1),
        Cell::number(line.nees[1], 1),
        Cell::number(line.whitened, 2),
        Cell::text(format!("{} of {}", line.failures, line.runs)),
        Cell::text(line.restarts),
        Cell::text(seeds),
    ]
}
