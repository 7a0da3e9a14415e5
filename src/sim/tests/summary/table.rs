//! Two sets of recordings side by side, as a Markdown table.

use super::recording::{Activity, AxisSummary, Line, RecordingSummary};
use dpn_core::Sensor;
use dpn_core::signal::Peak;
use dpn_core::signal::stats::median;
use std::fmt::Write;

/// A figure of an axis; none where the recording has nothing to take it from.
type Figure = fn(&AxisSummary) -> Option<f64>;

fn activity(axis: &AxisSummary, which: Activity) -> Option<f64> {
    let index = Activity::ALL.iter().position(|&a| a == which)?;
    axis.by_activity[index]
}

fn peak(axis: &AxisSummary, of: fn(&Line) -> Option<Peak>) -> Option<f64> {
    axis.line.as_ref().and_then(of).map(|peak| peak.hz)
}

fn kurtosis(axis: &AxisSummary) -> Option<f64> {
    axis.excess_kurtosis.is_finite().then_some(axis.excess_kurtosis)
}

const FIGURES: [(&str, Figure); 9] = [
    ("residual deviation, at rest", |a| activity(a, Activity::Quiet)),
    ("residual deviation, motors idling or handled", |a| activity(a, Activity::Stirring)),
    ("residual deviation, in flight", |a| activity(a, Activity::Running)),
    ("highest of 60-100 Hz [Hz]", |a| peak(a, |l| l.high)),
    ("highest of 20-45 Hz [Hz]", |a| peak(a, |l| l.low)),
    ("share of 60-100 Hz in 20-100 Hz", |a| a.line.as_ref().map(|l| l.high_share)),
    ("99 % of abs(residual) / deviation", |a| a.quantiles.get(2).copied()),
    ("99.9 % of abs(residual) / deviation", |a| a.quantiles.get(3).copied()),
    ("excess kurtosis of the residual", kurtosis),
];

/// A Markdown table: a row for each axis and figure, a column for each set, each cell the median over the set's
/// recordings with the lowest and highest. A set without a figure shows a dash.
pub(crate) fn compare(sets: &[(&str, &[RecordingSummary])]) -> String {
    let mut table = String::from("| axis | figure |");
    for (name, recordings) in sets {
        // Writing to a string cannot fail.
        let _ = write!(table, " {name} (n = {}) |", recordings.len());
    }
    table.push_str("\n|---|---|");
    table.push_str(&"---|".repeat(sets.len()));
    table.push('\n');
    for sensor in Sensor::ALL {
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            for (what, figure) in FIGURES {
                let _ = write!(table, "| {sensor} {letter} | {what} |");
                for (_, recordings) in sets {
                    let values: Vec<f64> =
                        recordings.iter().filter_map(|r| figure(&r.of(sensor)[axis])).collect();
                    let _ = write!(table, " {} |", cell(&values));
                }
                table.push('\n');
            }
        }
    }
    table
}

fn cell(values: &[f64]) -> String {
    if values.is_empty() {
        return "-".to_owned();
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{} ({} to {})", short(median(values)), short(low), short(high))
}

/// Three significant digits, and no more than four decimals.
fn short(value: f64) -> String {
    let decimals = match value.abs() {
        v if v >= 10.0 => 1,
        v if v >= 0.1 => 2,
        v if v >= 0.01 => 3,
        _ => 4,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::super::recording::summarise;
    use super::*;
    use dpn_sim::imu::WhiteConfig;
    use dpn_sim::{Flight, FlightConfig, simulate};

    #[test]
    fn a_row_for_every_figure_and_a_dash_where_a_set_has_none() {
        let config = FlightConfig { white: WhiteConfig::default(), ..FlightConfig::ideal() };
        let flight = simulate(Flight::Hover, 1, &config).unwrap();
        let summary = [summarise(&flight.recording).unwrap()];
        let table = compare(&[("white only", &summary), ("nothing", &[])]);
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines[0], "| axis | figure | white only (n = 1) | nothing (n = 0) |");
        assert_eq!(lines.len(), 2 + 2 * 3 * FIGURES.len());
        assert_eq!(lines[2], "| accel x | residual deviation, at rest | 0.028 (0.028 to 0.028) | - |");
        assert!(lines[4].ends_with("in flight | - | - |"));
    }

    #[test]
    fn a_cell_is_median_lowest_highest() {
        assert_eq!(cell(&[3.0, 0.012_34, 91.26]), "3.00 (0.012 to 91.3)");
    }
}
