//! The paper's table of the closed loop, ours beside it.

use super::super::command::Provenance;
use super::super::error::PaperError;
use super::super::input::Input;
use super::super::published;
use super::super::study::Rows;
use super::super::table::{Cell, Table};
use dpn_eval::closed_loop::Peer;
use dpn_train::split::Side;

/// The paper's columns.
const NOISES: [&str; 4] = ["x0.5", "x1", "x2", "dualpronet"];

/// Rate of improvement over the baseline \[%\].
fn improvement(baseline: f64, ours: f64) -> f64 {
    100.0 * (baseline - ours) / baseline
}

/// Sequence by sequence, training and test rows told apart, means below.
pub(crate) fn closed_loop(input: &Input, rows: &Rows<'_>, made_by: Provenance) -> Result<Table, PaperError> {
    let paper = Peer::paper()?;
    let beside = input.is_papers();
    let noises: Vec<&str> =
        NOISES.into_iter().filter(|noise| rows.noises.iter().any(|n| n == noise)).collect();
    let mut heads = vec!["sequence".to_owned(), "side".to_owned()];
    for noise in &noises {
        heads.push(format!("={noise}, ours"));
        if beside {
            heads.push(format!("={noise}, paper"));
        }
    }
    heads.push("=improvement [%], ours".into());
    if beside {
        heads.push("=improvement [%], paper".into());
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let title =
        "Absolute trajectory error [m] with constant noise and with DualProNet's; improvement over x1";
    let mut table = Table::new("closed_loop", title, &heads, made_by);
    for side in [Side::Train, Side::Test] {
        for (name, _) in rows.sequences.iter().filter(|(_, s)| *s == side) {
            let ours = |noise: &str| rows.ate(name, noise);
            let theirs = |noise: &str| paper.ate(name, noise);
            let mut cells = vec![Cell::text(name), Cell::text(side.to_string())];
            for noise in &noises {
                let failures = rows.failures(name, noise);
                let mark = if failures > 0 { format!("!{failures}") } else { String::new() };
                cells.push(Cell::metres(ours(noise)).marked(&mark));
                if beside {
                    cells.push(Cell::number(theirs(noise), 2));
                }
            }
            let rate = ours("x1").zip(ours("dualpronet")).map(|(a, b)| improvement(a, b));
            cells.push(Cell::number(rate, 1));
            if beside {
                cells.push(Cell::number(published::printed_improvement(name)?, 1));
            }
            table.row(cells);
        }
        for missing in input.not_run().filter(|m| input.side(&m.name) == Some(side)) {
            let mut cells = vec![Cell::text(&missing.name), Cell::text(side.to_string())];
            for noise in &noises {
                cells.push(Cell::text("missing"));
                if beside {
                    cells.push(Cell::number(paper.ate(&missing.name, noise), 2));
                }
            }
            cells.push(Cell::text("missing"));
            if beside {
                cells.push(Cell::number(published::printed_improvement(&missing.name)?, 1));
            }
            table.row(cells);
        }
        table.rule();
    }
    for (label, side) in
        [("mean, train", Some(Side::Train)), ("mean, test", Some(Side::Test)), ("mean, all", None)]
    {
        let names: Vec<&str> = rows
            .sequences
            .iter()
            .filter(|(_, s)| side.is_none_or(|side| side == *s))
            .map(|(name, _)| name.as_str())
            .collect();
        let mean =
            |values: Vec<f64>| (values.len() == names.len() && !values.is_empty()).then(|| average(&values));
        let mut cells = vec![
            Cell::text(format!("{label} ({})", names.len())),
            Cell::text(side.map_or("both".into(), |s| s.to_string())),
        ];
        for noise in &noises {
            cells.push(Cell::metres(rows.mean(noise, side)));
            if beside {
                cells.push(Cell::number(mean(names.iter().filter_map(|n| paper.ate(n, noise)).collect()), 3));
            }
        }
        let rates =
            names.iter().filter_map(|n| Some(improvement(rows.ate(n, "x1")?, rows.ate(n, "dualpronet")?)));
        cells.push(Cell::number(mean(rates.collect()), 1));
        if beside {
            let rates = names
                .iter()
                .filter_map(|n| Some(improvement(paper.ate(n, "x1")?, paper.ate(n, "dualpronet")?)));
            cells.push(Cell::number(mean(rates.collect()), 1));
        }
        table.row(cells);
    }
    let of_means = |side| Some(improvement(rows.mean("x1", side)?, rows.mean("dualpronet", side)?));
    if let Some(rate) = of_means(None) {
        let test = of_means(Some(Side::Test))
            .map_or(String::new(), |rate| format!(", {rate:.1} % on the test sequences alone"));
        table.note(format!("DualProNet's mean error is {rate:.1} % below that of x1{test}. The column's means are, as the paper's, means of the sequences' rates."));
    }
    table.note("A cell is the median over seeds after SE(3) alignment; ! and a number: failed runs. The networks that come with the \
                program were trained on EuRoC's training sequences, those of --train on the training sequences here; x1 is .08 m/s^2 and .004 rad/s.");
    if beside {
        table.note(format!(
            "The paper's runs are on EuRoC's images, ours on {}: compare columns, not single cells. Its means are recomputed here from its rows.",
            input.camera()
        ));
    }
    for note in input.notes_of_runs() {
        table.note(note);
    }
    Ok(table)
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
