//! Words and columns for a terminal.

use dpn_core::Sensor;

/// Items that a line lists at most.
const MOST: usize = 8;

/// What the sensor is called in a headline.
pub(crate) fn instrument(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Accel => "accelerometer",
        Sensor::Gyro => "gyroscope",
    }
}

/// The first items, and how many more there are.
pub(crate) fn listed(items: &[String]) -> String {
    let listed = items[..items.len().min(MOST)].join(", ");
    match items.len().saturating_sub(MOST) {
        0 => listed,
        more => format!("{listed} and {more} more"),
    }
}

/// Three significant digits.
#[cfg(feature = "formats")]
pub(crate) fn three(value: f64) -> String {
    format!("{value:.2e}")
}

/// A line a row, each column as wide as its widest cell, two blanks between.
pub(crate) fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|c| rows.iter().fold(0, |most, row| most.max(row[c].chars().count())));
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}
