//! The split with its true minutes.

use super::super::input::Input;
use dpn_eval::published;
use dpn_figures::{Cell, Column, Provenance, Table};
use dpn_train::split::Side;

/// Sequences, sides, samples and minutes, with the paper's totals.
pub(crate) fn split(input: &Input, made_by: Provenance) -> Table {
    let title = format!("Split of the {} sequences and their minutes of IMU", input.name);
    let mut table = Table::new("split", title, Column::all(&["sequence", "side"], &["samples", "minutes"]))
        .made_by(made_by);
    for (name, side, samples, minutes) in &input.lengths {
        table.row(vec![Cell::text(name), Cell::text(side), Cell::text(samples), Cell::number(*minutes, 2)]);
    }
    table.rule();
    let printed = input.is_papers().then(published::printed_minutes);
    for (i, side) in [Some(Side::Train), Some(Side::Test), None].into_iter().enumerate() {
        let of = || input.lengths.iter().filter(|(_, s, _, _)| side.is_none_or(|side| side == *s));
        let name = side.map_or("all".to_owned(), |side| format!("all {side}"));
        let samples: usize = of().map(|(_, _, samples, _)| samples).sum();
        let minutes: f64 = of().map(|(_, _, _, minutes)| minutes).sum();
        let sides = side.map_or_else(|| "both".to_owned(), |side| side.to_string());
        table.row(vec![Cell::text(&name), Cell::text(sides), Cell::text(samples), Cell::number(minutes, 2)]);
        if let Some(printed) = printed {
            table.note(format!("{name}: the paper prints {} min.", printed[i]));
        }
    }
    table.notes(input.notes());
    table
}
