//! The study's table.

use super::super::command::Provenance;
use super::super::input::Input;
use super::super::study::{Line, Study};
use super::super::table::{Cell, Table};

/// Data sheet, networks and controls in the words of a reader.
fn what(noise: &str) -> &'static str {
    match noise {
        "const(0.0283,0.0024)" => "data sheet",
        "dualpronet" => "DualProNet: conv-norm-act, sigma_inj",
        "dualpronet(order-s0)" => "DualProNet: conv-act-norm, sigma_inj",
        "dualpronet(total-s0)" => "DualProNet: conv-norm-act, sigma_tot",
        "dualpronet(paper-s0)" => "DualProNet: the paper as it reads",
        "dualpronet(wide-s0)" => "DualProNet: raw base, wide range",
        "oracle" => "the truth",
        noise if noise.starts_with("plus(dualpronet") => "DualProNet, wide, and a constant",
        noise if noise.starts_with("shuffled(") => "control: right values, wrong times",
        noise if noise.starts_with("mean-of-train(") => "control: one constant from training",
        noise if noise.starts_with("mean(") => "control: one constant a sequence",
        noise if noise.starts_with('x') => "constant",
        _ => "simple estimator",
    }
}

/// Every noise with its errors, its consistency and its test against the best constant.
pub(crate) fn study(input: &Input, study: &Study, made_by: Provenance) -> Table {
    let heads = [
        "noise",
        "what",
        "=accel told [m/s^2]",
        "=gyro told [rad/s]",
        "=ATE median [m] (95 %)",
        "=mean train [m]",
        "=mean test [m]",
        "=ratio to best constant (95 %)",
        "=better in",
        "=p (Holm)",
        "=p equal",
        "verdict",
        "=RPE 1 s [m]",
        "=NEES position",
        "=NEES orientation",
        "=whitened",
        "=failed",
        "=restarts",
        "=seeds",
    ];
    let best = study.best_constant.as_deref().unwrap_or("none");
    let title =
        format!("Every noise in the closed loop against {best}, the best constant on the training sequences");
    let mut table = Table::new("study", title, &heads, made_by);
    for line in &study.lines {
        table.row(cells(line, study));
    }
    table.note(format!(
        "Medians over seeds, then over sequences (one without any pose counts as worse than all; it is left out of ratios and tests), with the percentile bootstrap over sequences; ratio: geometric mean over sequences, on the seeds that both noises have. \
         p: two-sided signed-rank test over sequences, Holm's correction over all noises; p equal: two one-sided signed-rank tests \
         that the ratio lies within {:.0} %. Verdicts at .05.",
        100.0 * study.margin
    ));
    table.note("NEES: mean of 3 where the covariance is right; whitened: mean square of the whitened inertial residual, 1 where the noise \
                told is the noise there is. Told: root mean square over the runs. Times are in the table `timing`.");
    if study.at_edge {
        table.note(format!("{best} is the end of the sweep; a constant beyond it may be better."));
    }
    for note in input.notes_of_runs() {
        table.note(note);
    }
    table
}

fn cells(line: &Line, study: &Study) -> Vec<Cell> {
    let against = line.against.as_ref();
    let verdict = match against {
        None if Some(&line.noise) == study.best_constant.as_ref() => "reference",
        None => "-",
        Some(a) => match (a.p_holm, a.p_equal) {
            (None, _) => "too few sequences",
            (Some(p), _) if p < 0.05 && a.ratio < 1.0 => "better",
            (Some(p), _) if p < 0.05 => "worse",
            (_, Some(p)) if p < 0.05 => "equal",
            _ => "open",
        },
    };
    let better = against.map_or(Cell::text("-"), |a| Cell::text(format!("{} of {}", a.better, a.sequences)));
    let seeds = match line.seeds {
        [low, high] if low == high => low.to_string(),
        [low, high] => format!("{low} to {high}"),
    };
    vec![
        Cell::text(&line.noise),
        Cell::text(what(&line.noise)),
        Cell::number(line.told.map(|t| t[0]), 3),
        Cell::number(line.told.map(|t| t[1]), 4),
        Cell::interval(line.ate, line.ate_interval, 3),
        Cell::metres(line.means[1]),
        Cell::metres(line.means[2]),
        Cell::interval(against.map(|a| a.ratio), against.map(|a| a.ratio_interval), 2),
        better,
        Cell::p(against.and_then(|a| a.p_holm)),
        Cell::p(against.and_then(|a| a.p_equal)),
        Cell::text(verdict),
        Cell::number(line.rpe_1s, 4),
        Cell::number(line.nees[0], 1),
        Cell::number(line.nees[1], 1),
        Cell::number(line.whitened, 2),
        Cell::text(format!("{} of {}", line.failures, line.runs)),
        Cell::count(line.restarts),
        Cell::text(seeds),
    ]
}
