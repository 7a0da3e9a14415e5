//! What stands in a table of a comparison.

use dpn_eval::study::Comparison;
use dpn_figures::Cell;

/// Ratio with its interval, on how many sequences it is better, and p after Holm's correction.
pub(super) fn against(comparison: Option<&Comparison>) -> [Cell; 3] {
    let better = |c: &Comparison| Cell::text(format!("{} of {}", c.better, c.sequences));
    [
        Cell::interval(comparison.map(|c| c.ratio), comparison.map(|c| c.ratio_interval), 2),
        comparison.map_or(Cell::text("-"), better),
        Cell::p(comparison.and_then(|c| c.p_holm)),
    ]
}
