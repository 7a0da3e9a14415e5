//! NEES of many runs of one sequence with one noise, instant by instant.
//!
//! Every cell whose poses have covariances (`covariance = true` in the estimator's settings) leaves a file `nees/CELL.csv`: stamp, NEES of
//! position, NEES of orientation. [`consistency`] puts the seeds of one sequence and one noise together.

use super::error::{ClosedLoopError, OfSequence};
use super::row::Row;
use super::sweep_plan::nees_path;
use crate::metrics::{NeesReport, PoseNees, nees_report};
use dpn_core::Stamp;
use dpn_core::estimate::NoiseSpec;
use dpn_io::{IoError, ResultPath, atomic_write};
use serde::Serialize;

const HEADER: &str = "#timestamp [ns],nees_position,nees_orientation";
/// Probability between the bounds.
const CONFIDENCE: f64 = 0.95;

/// NEES over the seeds of one sequence and one noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Consistency {
    /// The sequence.
    pub sequence: String,
    /// The noise spec.
    pub noise: NoiseSpec,
    /// The report.
    pub nees: NeesReport,
}

/// Writes the NEES of one run.
pub(super) fn write_nees(path: &ResultPath, nees: &[PoseNees]) -> Result<(), IoError> {
    atomic_write(path, |out| {
        writeln!(out, "{HEADER}")?;
        for pose in nees {
            writeln!(out, "{},{:?},{:?}", pose.t.ns(), pose.position, pose.orientation)?;
        }
        Ok(())
    })
}

/// Reads what [`write_nees`] wrote; nothing where there is no file.
fn read_nees(path: &ResultPath) -> Result<Vec<PoseNees>, ClosedLoopError> {
    let text = path.text()?;
    let bad = |line: usize, text: &str| ClosedLoopError::BadRow {
        path: path.path().to_path_buf(),
        line,
        message: format!("`{text}` is not stamp, NEES, NEES"),
    };
    let of = |text: &str| {
        let mut fields = text.split(',');
        Some(PoseNees {
            t: Stamp::from_ns(fields.next()?.parse().ok()?),
            position: fields.next()?.parse().ok()?,
            orientation: fields.next()?.parse().ok()?,
        })
    };
    let lines = (1..).zip(text.lines()).filter(|(_, text)| !text.starts_with('#'));
    lines.map(|(line, text)| of(text).ok_or_else(|| bad(line, text))).collect()
}

/// NEES over seeds, by sequence and noise in the order of `rows`; nothing where runs left none.
///
/// # Errors
/// A file of a cell that does not read.
pub fn consistency(dir: &ResultPath, rows: &[Row]) -> Result<Vec<Consistency>, ClosedLoopError> {
    let mut found: Vec<(String, NoiseSpec, Vec<Vec<PoseNees>>)> = Vec::new();
    for row in rows {
        let run = read_nees(&nees_path(dir, &row.key()))?;
        if run.is_empty() {
            continue;
        }
        match found.iter_mut().find(|(s, n, _)| *s == row.sequence && *n == row.noise) {
            Some((_, _, runs)) => runs.push(run),
            None => found.push((row.sequence.clone(), row.noise.clone(), vec![run])),
        }
    }
    let mut reports = Vec::new();
    for (sequence, noise, runs) in found {
        let report = nees_report(&runs, CONFIDENCE).of_sequence(&sequence)?;
        reports.extend(report.map(|nees| Consistency { sequence, noise, nees }));
    }
    Ok(reports)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nees_is_read_back_bit_by_bit_and_a_broken_line_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("nees/a.csv");
        let nees: Vec<_> = (0..5)
            .map(|i| PoseNees {
                t: Stamp::from_ns(1_400_000_000_000_000_000 + i),
                position: 1.0 / (i + 3) as f64,
                orientation: 1e-17 * i as f64,
            })
            .collect();
        write_nees(&ResultPath::from(&path), &nees).unwrap();
        assert_eq!(read_nees(&ResultPath::from(&path)).unwrap(), nees);
        assert_eq!(read_nees(&ResultPath::from(dir.path()).join("none.csv")).unwrap(), []);
        std::fs::write(&path, format!("{HEADER}\n1,2,3\n1,2\n")).unwrap();
        assert!(read_nees(&ResultPath::from(&path)).unwrap_err().to_string().contains("a.csv:3: not a row"));
    }
}
