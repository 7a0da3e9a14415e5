//! The paper's table of the closed loop, ours beside it.

use super::super::input::Input;
use super::super::specs;
use super::ate::{Ates, rate};
use dpn_eval::published::PublishedAte;
use dpn_eval::study::RowSet;
use dpn_figures::{Provenance, Table};
use dpn_train::split::Side;

/// The paper's columns, as far as they were run, with the improvement of DualProNet over x1.
pub(crate) fn closed_loop(input: &Input, rows: &RowSet<'_>, made_by: Provenance) -> Table {
    let columns = specs::PAPER.map(specs::noise);
    let [x1, dualpronet, ..] = &columns;
    let beside = input.is_papers();
    let missing =
        input.not_run().filter_map(|missing| Some((missing.name.as_str(), input.side(&missing.name)?)));
    let ates = Ates {
        rows,
        noises: columns.iter().filter(|noise| rows.noises().contains(noise)).collect(),
        peers: if beside { vec![PublishedAte::paper()] } else { Vec::new() },
        missing: missing.collect(),
        improvement: Some([x1, dualpronet]),
        called: specs::name,
    };
    let title = "Sequence by sequence: what DualProNet improves on the usual constant x1, and absolute trajectory errors [m]";
    let mut table = ates.table("closed_loop", title).made_by(made_by);
    let of_means = |side| rate([x1, dualpronet].map(|noise| rows.mean(noise, side)));
    if let Some(rate) = of_means(None) {
        let test = of_means(Some(Side::Test))
            .map_or(String::new(), |rate| format!(", {rate:.1} % on the test sequences alone"));
        table.note(format!("DualProNet's mean error is {rate:.1} % below that of x1{test}. The column's means are, as the paper's, means of the sequences' rates."));
    }
    table.note("A cell is the median over seeds after SE(3) alignment; ! and a number: failed runs. The networks that come with the \
                program were trained on EuRoC's training sequences; x1 is .08 m/s^2 and .004 rad/s.");
    if beside {
        table.note(format!(
            "The paper's runs are on EuRoC's images, ours on {}: compare columns, not single cells. Its means are recomputed here from its rows.",
            input.camera()
        ));
    }
    table.notes(input.notes_of_runs());
    table
}
