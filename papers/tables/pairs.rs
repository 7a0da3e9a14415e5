//! Noises against others than the study's reference.

use super::super::findings::Pair;
use super::super::specs;
use super::comparison::against;
use dpn_figures::{Cell, Column, Provenance, Table};

/// A line a pair.
pub(crate) fn pairs(pairs: &[Pair], made_by: Provenance) -> Table {
    let columns = Column::all(&["noise", "against"], &["ratio (95 %)", "better in", "p"]);
    let title = "One noise against another: the network against the usual constants, and controls";
    let mut table = Table::new("pairs", title, columns).made_by(made_by);
    for pair in pairs {
        let [ratio, better, _] = against(Some(&pair.comparison));
        let noises = [&pair.noise, &pair.against].map(specs::cell);
        table.row(noises.into_iter().chain([ratio, better, Cell::p(pair.comparison.p)]).collect());
    }
    table.note("Ratio: geometric mean over sequences of the ratio of errors, on the seeds that both noises have; p: two-sided signed-rank test over sequences, not corrected.");
    table
}
