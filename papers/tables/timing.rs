//! Times, apart from all other figures: they are the only ones that differ from run to run.

use super::super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::study::Study;
use dpn_figures::{Cell, Column, Provenance, Table};

/// CPU of the odometry a second of data, given each noise.
pub(crate) fn timing(study: &Study, windows: &[(NoiseSpec, f64)], made_by: Provenance) -> Table {
    let columns =
        Column::all(&["noise"], &["odometry [CPU s / s of data]", "six windows of the noise model [ms]"]);
    let title = "CPU time: the one table that differs from run to run";
    let mut table = Table::new("timing", title, columns).made_by(made_by);
    for line in &study.noises {
        let window = windows.iter().find(|(noise, _)| *noise == line.noise).map(|(_, ms)| *ms);
        table.row(vec![
            specs::cell(&line.noise),
            Cell::number(line.cpu_per_data_s, 4),
            Cell::number(window, 4),
        ]);
    }
    table.note("Median over runs, thread CPU time, other programs on the machine and the caches they spoil included. The odometry's figure does not \
                hold the noise model's. Six windows: one answer for all axes of both sensors, mean over a recording.");
    table
}
