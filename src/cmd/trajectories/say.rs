//! What is said of trajectories: a table, or JSON.

use super::judged::{Judged, Versus};
use dpn_core::signal::stats::mean;
use dpn_eval::metrics::{Comparing, ErrorSummary};
use dpn_eval::stats::sign_test;
use dpn_eval::study::FEWEST_SEQUENCES;
use dpn_figures::{Cell, Column, Table};
use serde_json::{Value, json};

/// The figure and its unit.
pub(super) fn what(metric: &str, by: &Comparing) -> String {
    match by.relation.unit() {
        "" => format!("{metric}, {}", by.relation),
        unit => format!("{metric}, {} [{unit}]", by.relation),
    }
}

/// How the estimates were brought to the truth.
pub(super) fn how(by: &Comparing, judged: &[Judged]) -> String {
    let way = match (by.align, by.correct_scale, by.align_origin) {
        (true, true, _) => "aligned in Sim(3)",
        (true, false, _) => "aligned in SE(3)",
        (false, true, true) => "scale corrected, first pose put on the truth's",
        (false, true, false) => "scale corrected, not aligned",
        (false, false, true) => "first pose put on the truth's",
        (false, false, false) => "not aligned",
    };
    // More than there are is all of them.
    let first = by.n_to_align.filter(|n| judged.iter().any(|one| *n < one.compared.pairs.len()));
    first.map_or(format!("{way}."), |n| format!("{way} by the first {n} poses."))
}

fn head(metric: &str, by: &Comparing, judged: &[Judged]) -> String {
    format!("{}; {}", what(metric, by), how(by, judged))
}

/// One truth: a row an estimate.
pub(super) fn one(metric: &str, by: &Comparing, names: &[String], judged: &[Judged]) -> Table {
    let mut numbers = vec!["errors", "rmse", "median", "max"];
    if by.correct_scale {
        numbers.push("scale");
    }
    let mut table =
        Table::new("trajectories", head(metric, by, judged), Column::all(&["estimate"], &numbers));
    for one in judged {
        let ErrorSummary { count, rmse, median, max, .. } = one.compared.summary;
        let mut cells = vec![Cell::text(&names[one.case.number]), Cell::text(count)];
        cells.extend([rmse, median, max].map(|error| Cell::significant(error, 3)));
        if by.correct_scale {
            cells.push(Cell::number(one.compared.alignment.scale, 4));
        }
        table.row(cells);
    }
    table
}

/// Several sequences: a row an estimate, each against the first.
pub(super) fn sequences(
    metric: &str,
    by: &Comparing,
    names: &[String],
    judged: &[Judged],
    versus: &[Option<Versus>],
) -> Table {
    let ratio = format!("ratio to {}", names[0]);
    let numbers = ["sequences", "mean rmse", ratio.as_str(), "better in", "p"];
    let mut table =
        Table::new("trajectories", head(metric, by, judged), Column::all(&["estimate"], &numbers));
    // Means over other sequences would not be comparable.
    let of_all: Vec<&Judged> = judged
        .chunk_by(|a, b| a.case.sequence == b.case.sequence)
        .filter(|sequence| sequence.len() == names.len())
        .flatten()
        .collect();
    for (number, name) in names.iter().enumerate() {
        let count = judged.iter().filter(|one| one.case.number == number).count();
        let errors: Vec<f64> = of_all
            .iter()
            .filter(|one| one.case.number == number)
            .map(|one| one.compared.summary.rmse)
            .collect();
        let mut cells = vec![Cell::text(name), Cell::text(count), Cell::significant(mean(&errors), 3)];
        cells.extend(match versus.get(number).and_then(Option::as_ref) {
            None => [Cell::none(), Cell::none(), Cell::none()],
            Some(of) => {
                let ends = interval(of);
                let better = format!("{} of {}", of.comparison.better, of.comparison.sequences);
                [
                    Cell::interval(Some(of.comparison.ratio), ends, 2),
                    Cell::text(better),
                    Cell::p(of.comparison.p_holm),
                ]
            }
        });
        table.reference_row(cells, number == 0);
    }
    let common = of_all.len() / names.len();
    table.note(format!(
        "mean rmse: over the {common} sequences that all have; ratio: geometric mean over the sequences that both have, with its 95 % interval from {FEWEST_SEQUENCES} sequences on; p: signed ranks, by Holm"
    ));
    table
}

/// Fewer sequences have no interval.
fn interval(of: &Versus) -> Option<[f64; 2]> {
    (of.comparison.sequences >= FEWEST_SEQUENCES).then_some(of.comparison.ratio_interval)
}

/// All of it.
pub(super) fn json(
    metric: &str,
    by: &Comparing,
    names: &[String],
    judged: &[Judged],
    versus: &[Option<Versus>],
) -> Value {
    let pair = |one: &Judged| {
        let ErrorSummary { count, rmse, mean, median, max } = one.compared.summary;
        json!({
            "sequence": one.case.sequence, "estimate": names[one.case.number],
            "truth": one.case.truth, "file": one.case.estimate,
            "poses": one.poses, "pairs": one.compared.pairs.len(), "scale": one.compared.alignment.scale,
            "count": count, "rmse": rmse, "mean": mean, "median": median, "max": max,
        })
    };
    let compared = |(of, name): (&Option<Versus>, &String)| {
        let of = of.as_ref()?;
        let comparison = &of.comparison;
        let sign = comparison.p.map(|_| sign_test(comparison.better, of.worse));
        Some(json!({
            "estimate": name, "against": names[0],
            "sequences": comparison.sequences, "better": comparison.better, "worse": of.worse,
            "ratio": comparison.ratio, "ratio_interval": interval(of),
            "p_signed_rank": comparison.p, "p_holm": comparison.p_holm, "p_sign": sign,
        }))
    };
    json!({
        "metric": metric, "relation": by.relation.name(), "unit": by.relation.unit(), "alignment": how(by, judged),
        "pairs": judged.iter().map(pair).collect::<Vec<_>>(),
        "comparisons": versus.iter().zip(names).filter_map(compared).collect::<Vec<_>>(),
    })
}
