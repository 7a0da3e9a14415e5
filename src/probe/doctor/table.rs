//! Many logs in one table, a row each.

use super::{Examination, LogFigures};
use crate::finding::{Finding, Weight};
use crate::text::aligned;
use serde::Serialize;

/// A log by its name, and what was found of it, or why it could not be read.
pub type Row = (String, Result<Examination, String>);

/// The gravest finding of a log that warns.
fn worst(examination: &Examination) -> Option<&Finding> {
    examination.findings.first().filter(|finding| finding.warns())
}

/// The gravest weight of all rows; a log that cannot be read is bad.
pub fn gravest(rows: &[Row]) -> Weight {
    let of =
        |(_, row): &Row| row.as_ref().map_or(Weight::Bad, |e| worst(e).map_or(Weight::Note, |f| f.weight));
    rows.iter().map(of).min().unwrap_or(Weight::Note)
}

/// The table: rate, length, losses, rest, gravity, noise at rest, how much was found and the worst of it.
pub fn page(rows: &[Row]) -> String {
    let head =
        ["log", "Hz", "s", "lost", "rest s", "gravity", "accel noise", "gyro noise", "bad", "warn", "worst"];
    let mut table = vec![head.map(str::to_owned)];
    for (name, row) in rows {
        let mut cells: [String; 11] = std::array::from_fn(|_| "-".to_owned());
        cells[0].clone_from(name);
        match row {
            Ok(examination) => {
                let LogFigures { lost, rest_s, gravity, accel_noise, gyro_noise } = examination.figures;
                let count =
                    |weight| examination.findings.iter().filter(|f| f.weight == weight).count().to_string();
                let density =
                    |noise: Option<f64>| noise.map_or_else(|| "-".to_owned(), |noise| format!("{noise:.2e}"));
                let worst = worst(examination).map_or("", |finding| finding.about);
                cells[1..].clone_from_slice(&[
                    format!("{:.1}", examination.rate_hz),
                    format!("{:.0}", examination.length_s),
                    format!("{lost:.0}"),
                    format!("{rest_s:.0}"),
                    format!("{gravity:.2}"),
                    density(accel_noise),
                    density(gyro_noise),
                    count(Weight::Bad),
                    count(Weight::Warning),
                    worst.to_owned(),
                ]);
            }
            Err(error) => cells[10] = format!("cannot be read: {error}"),
        }
        table.push(cells);
    }
    aligned(&table) + "noise: densities at rest, the largest of the axes, m/s^2/sqrt(Hz) and rad/s/sqrt(Hz)\n"
}

/// All rows for programs, each what was found of a log, or why it could not be read.
///
/// # Errors
/// None that numbers can make.
pub fn json<T: Serialize>(rows: &[(String, Result<T, String>)]) -> serde_json::Result<serde_json::Value> {
    let row = |(name, row): &(String, Result<T, String>)| {
        let mut json = match row {
            Ok(found) => serde_json::to_value(found)?,
            Err(error) => serde_json::json!({ "error": error }),
        };
        json["log"] = name.as_str().into();
        Ok(json)
    };
    let rows = rows.iter().map(row).collect::<serde_json::Result<Vec<_>>>()?;
    Ok(serde_json::json!({ "logs": rows }))
}
