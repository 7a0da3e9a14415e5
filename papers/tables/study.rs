//! The study's table.

use super::super::input::Input;
use super::super::specs::{self, DATA_SHEET};
use dpn_core::estimate::{DEFAULT_TAG, NoiseSpec};
use dpn_eval::study::{NoiseSummary, Study};
use dpn_figures::{Cell, Column, Provenance, Table};

/// What a noise is, in the words of a reader.
fn what(noise: &NoiseSpec) -> String {
    let words = match noise {
        NoiseSpec::DualProNet { accel, gyro } if accel == gyro => match accel.as_str() {
            DEFAULT_TAG => "DualProNet: conv-norm-act, sigma_inj",
            "order-s0" => "DualProNet: conv-act-norm, sigma_inj",
            "total-s0" => "DualProNet: conv-norm-act, sigma_tot",
            "paper-s0" => "DualProNet: the paper as it reads",
            "wide-s0" => "DualProNet: raw base, wide range",
            _ => "DualProNet: other networks",
        },
        NoiseSpec::DualProNet { .. } => "DualProNet: other networks",
        NoiseSpec::Oracle => "the truth",
        NoiseSpec::File(_) => "a noise track on disk",
        NoiseSpec::Shuffled(_) => "control: right values, wrong times",
        NoiseSpec::MeanOfTrain(_) => "control: one constant from training",
        NoiseSpec::Mean(_) => "control: one constant a sequence",
        NoiseSpec::Plus { of, .. } if **of == specs::noise("dualpronet(wide-s0)") => {
            "DualProNet, wide, and a constant"
        }
        NoiseSpec::Learned(_) => "learned while it runs",
        NoiseSpec::Plus { of, .. } => return format!("{}, and a constant", what(of)),
        _ if *noise == specs::noise(DATA_SHEET) => "data sheet",
        NoiseSpec::Sensors(_) if noise.is_constant() => "constant",
        NoiseSpec::Sensors(_) => "simple estimator",
    };
    words.to_owned()
}

/// Every noise with its errors, its consistency and its test against the best constant.
pub(crate) fn study(input: &Input, study: &Study, made_by: Provenance) -> Table {
    let mut columns = Column::all(
        &["noise", "what"],
        &[
            "accel told [m/s^2]",
            "gyro told [rad/s]",
            "ATE median [m] (95 %)",
            "mean train [m]",
            "mean test [m]",
            "ratio to best constant (95 %)",
            "better in",
            "p (Holm)",
            "p equal",
        ],
    );
    columns.push(Column::text("verdict"));
    let more =
        ["RPE 1 s [m]", "NEES position", "NEES orientation", "whitened", "failed", "restarts", "seeds"];
    columns.extend(more.map(Column::number));
    let title = match &study.reference {
        Some(reference) => format!("Every noise in the closed loop against {}", reference.words()),
        None => "Every noise in the closed loop; there is no constant to compare with".to_owned(),
    };
    let mut table = Table::new("study", title, columns).made_by(made_by);
    for line in &study.noises {
        let is_reference = study.is_reference(&line.noise);
        table.reference_row(cells(line, is_reference), is_reference);
    }
    table.note(format!(
        "Medians over seeds, then over sequences (one without any pose counts as worse than all; it is left out of ratios and tests), with the percentile bootstrap over sequences; ratio: geometric mean over sequences, on the seeds that both noises have. \
         p: two-sided signed-rank test over sequences, Holm's correction over all noises; p equal: two one-sided signed-rank tests \
         that the ratio lies within {:.0} %. Verdicts at .05.",
        100.0 * study.margin
    ));
    table.note("NEES: mean of 3 where the covariance is right; whitened: mean square of the whitened inertial residual, 1 where the noise \
                told is the noise there is. Told: root mean square over the runs. Times are in the table `timing`.");
    if let Some(reference) = study.reference.as_ref().filter(|reference| reference.at_edge) {
        table.note(format!(
            "{} is the end of the sweep; a constant beyond it may be better.",
            reference.noise
        ));
    }
    table.notes(input.notes_of_runs());
    table
}

fn cells(line: &NoiseSummary, is_reference: bool) -> Vec<Cell> {
    let against = line.comparison.as_ref();
    let verdict = match against {
        None if is_reference => "reference",
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
        Cell::number(line.noise_rms.map(|rms| rms[0]), 3),
        Cell::number(line.noise_rms.map(|rms| rms[1]), 4),
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
        Cell::text(line.restarts),
        Cell::text(seeds),
    ]
}
