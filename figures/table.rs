//! Rows of the open loop as a table for people (plain or Markdown) and as CSV, with the paper's figures beside them.
//!
//! The paper gives one RMSE a sensor and split, without its filter; what it shows is nearest to base SG(5,2) on its own grid with
//! label `sigma_inj`, so its row stands under those rows alone, marked `paper`, with every cell empty that it does not fill.

use dpn_core::Sensor;
use dpn_eval::open_loop::Row;
use std::fmt::Write;
use thiserror::Error;

/// The paper's table "RMSE of the inertial uncertainty".
const PAPER: &str = include_str!("../papers/open_loop.csv");

/// Columns of the CSV, in order.
pub const COLUMNS: [&str; 14] = [
    "sensor",
    "data",
    "base",
    "split",
    "levels",
    "label",
    "estimator",
    "rmse",
    "rmse_spread",
    "bias",
    "crb",
    "ratio",
    "n",
    "seeds",
];

/// How a table looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Columns aligned by spaces, for terminals.
    Plain,
    /// A Markdown table, aligned as well.
    Markdown,
}

/// Why a table could not be written.
#[derive(Debug, Error)]
pub enum TableError {
    /// The writer failed; its path is known to the caller.
    #[error("cannot write the table: {source}; check that there is room and that the place is writable")]
    Write {
        /// What the writer says.
        source: csv::Error,
    },
    /// `papers/open_loop.csv`, built into the program, does not read.
    #[error(
        "papers/open_loop.csv, line {line}: `{text}` is not `sensor,unit,train_rmse,test_rmse`; mend it and build again"
    )]
    Paper {
        /// Line in the file, from 1.
        line: usize,
        /// The line.
        text: String,
    },
}

/// One line of a table: a row of ours, or the paper's.
enum Line<'a> {
    Ours(&'a Row),
    Paper { beside: &'a Row, rmse: f64 },
}

/// Renders `rows` in their order; a line of the paper follows the last row it belongs to.
///
/// # Errors
/// [`TableError::Paper`].
pub fn render(rows: &[Row], layout: Layout) -> Result<String, TableError> {
    const HEADER: [&str; 12] = [
        "sensor",
        "data",
        "base",
        "split",
        "levels",
        "label",
        "estimator",
        "RMSE",
        "bias",
        "CRB",
        "ratio",
        "n (seeds)",
    ];
    const FIRST_NUMBER: usize = 7;
    let mut cells = vec![HEADER.map(str::to_owned)];
    cells.extend(lines(rows)?.iter().map(Line::words));
    let widths: Vec<usize> = (0..HEADER.len())
        .map(|column| cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let mut out = String::new();
    for (i, row) in cells.iter().enumerate() {
        let padded: Vec<String> =
            row.iter()
                .zip(&widths)
                .enumerate()
                .map(|(column, (cell, &width))| {
                    if column < FIRST_NUMBER { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                })
                .collect();
        let rule: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
        match layout {
            Layout::Plain => {
                let line = padded.join("  ");
                out.push_str(line.trim_end());
                out.push('\n');
                if i == 0 {
                    let _ = writeln!(out, "{}", rule.join("  "));
                }
            }
            Layout::Markdown => {
                let _ = writeln!(out, "| {} |", padded.join(" | "));
                if i == 0 {
                    let ends = |column: usize| if column < FIRST_NUMBER { "-" } else { ":" };
                    let rule: Vec<String> =
                        (0..rule.len()).map(|column| format!("-{}{}", rule[column], ends(column))).collect();
                    let _ = writeln!(out, "|{}|", rule.join("|"));
                }
            }
        }
    }
    Ok(out)
}

/// Writes `rows` as CSV with [`COLUMNS`], numbers in full; lines of the paper as in [`render`].
///
/// # Errors
/// [`TableError::Write`], [`TableError::Paper`].
pub fn write_csv(rows: &[Row], writer: impl std::io::Write) -> Result<(), TableError> {
    let failed = |source| TableError::Write { source };
    let lines = lines(rows)?;
    let mut writer = csv::Writer::from_writer(writer);
    writer.write_record(COLUMNS).map_err(failed)?;
    for line in lines {
        writer.write_record(line.fields()).map_err(failed)?;
    }
    writer.flush().map_err(|error| failed(error.into()))
}

fn lines(rows: &[Row]) -> Result<Vec<Line<'_>>, TableError> {
    let paper = paper()?;
    let mut lines = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        lines.push(Line::Ours(row));
        if rows[i + 1..].iter().any(|later| same_case(row, later)) {
            continue;
        }
        let figure = paper.iter().find(|p| p.matches(row));
        if let Some(rmse) = figure.and_then(|p| p.of_split(&row.split)) {
            lines.push(Line::Paper { beside: row, rmse });
        }
    }
    Ok(lines)
}

/// Whether two rows differ in nothing but the estimator.
fn same_case(a: &Row, b: &Row) -> bool {
    let case = |row: &Row| {
        let words = [&row.base, &row.data, &row.split, &row.levels, &row.label].map(String::clone);
        (row.sensor, words)
    };
    case(a) == case(b)
}

impl Line<'_> {
    /// Cells for people: rounded.
    fn words(&self) -> [String; 12] {
        match self {
            Self::Ours(row) => {
                let rmse = match row.rmse_spread {
                    Some(spread) => {
                        format!("{} ± {}", decimal(row.sensor, row.rmse), decimal(row.sensor, spread))
                    }
                    None => decimal(row.sensor, row.rmse),
                };
                let n = if row.seeds > 0 { format!("{} ({})", row.n, row.seeds) } else { row.n.to_string() };
                [
                    row.sensor.name().into(),
                    row.data.clone(),
                    row.base.clone(),
                    row.split.clone(),
                    row.levels.clone(),
                    row.label.clone(),
                    row.estimator.clone(),
                    rmse,
                    decimal(row.sensor, row.bias),
                    decimal(row.sensor, row.crb),
                    format!("{:.2}", row.ratio),
                    n,
                ]
            }
            Self::Paper { beside, rmse } => {
                let mut cells = ["-"; 12].map(str::to_owned);
                cells[0] = beside.sensor.name().into();
                cells[1] = "euroc".into();
                cells[3].clone_from(&beside.split);
                cells[4].clone_from(&beside.levels);
                cells[6] = "paper".into();
                cells[7] = rmse.to_string();
                cells
            }
        }
    }

    /// Fields of the CSV: numbers in full.
    fn fields(&self) -> [String; 14] {
        match self {
            Self::Ours(row) => [
                row.sensor.name().into(),
                row.data.clone(),
                row.base.clone(),
                row.split.clone(),
                row.levels.clone(),
                row.label.clone(),
                row.estimator.clone(),
                row.rmse.to_string(),
                row.rmse_spread.map_or_else(String::new, |spread| spread.to_string()),
                row.bias.to_string(),
                row.crb.to_string(),
                row.ratio.to_string(),
                row.n.to_string(),
                row.seeds.to_string(),
            ],
            Self::Paper { beside, rmse } => {
                let mut fields: [String; 14] = Default::default();
                fields[0] = beside.sensor.name().into();
                fields[1] = "euroc".into();
                fields[3].clone_from(&beside.split);
                fields[4].clone_from(&beside.levels);
                fields[6] = "paper".into();
                fields[7] = rmse.to_string();
                fields
            }
        }
    }
}

/// `value` in decimals that hold three digits or more of the sensor's errors; the same for all rows, so that points align.
fn decimal(sensor: Sensor, value: f64) -> String {
    let decimals = match sensor {
        Sensor::Accel => 5,
        Sensor::Gyro => 6,
    };
    format!("{value:.decimals$}")
}

/// The paper's figures of one sensor.
struct Paper {
    sensor: Sensor,
    train: f64,
    test: f64,
}

impl Paper {
    fn matches(&self, row: &Row) -> bool {
        let base = row.base.replace(' ', "");
        self.sensor == row.sensor && base == "sg(5,2)" && row.levels == "grid" && row.label == "sigma_inj"
    }

    fn of_split(&self, split: &str) -> Option<f64> {
        match split {
            "train" => Some(self.train),
            "test" => Some(self.test),
            _ => None,
        }
    }
}

fn paper() -> Result<Vec<Paper>, TableError> {
    (1..)
        .zip(PAPER.lines())
        .skip(1)
        .filter(|(_, text)| !text.trim().is_empty())
        .map(|(line, text)| {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            let parsed = match cells[..] {
                [name, unit, train, test] => Sensor::ALL
                    .into_iter()
                    .find(|sensor| sensor.name() == name && sensor.unit() == unit)
                    .zip(train.parse().ok().zip(test.parse().ok())),
                _ => None,
            };
            parsed
                .map(|(sensor, (train, test))| Paper { sensor, train, test })
                .ok_or_else(|| TableError::Paper { line, text: text.to_owned() })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(sensor: Sensor, base: &str, estimator: &str, rmse: f64) -> Row {
        Row {
            sensor,
            base: base.into(),
            data: "euroc".into(),
            split: "test".into(),
            estimator: estimator.into(),
            levels: "grid".into(),
            label: "sigma_inj".into(),
            rmse,
            rmse_spread: None,
            bias: -0.00123,
            crb: 0.0063,
            ratio: rmse / 0.0063,
            n: 20427,
            seeds: 0,
            by_sigma: Vec::new(),
        }
    }

    #[test]
    fn the_papers_line_follows_its_rows_and_no_others() {
        let mut trained = row(Sensor::Accel, "sg(5,2)", "pronet", 0.02434);
        (trained.rmse_spread, trained.seeds) = (Some(0.000_312), 3);
        let rows = [
            row(Sensor::Accel, "sg(5,2)", "mad2", 0.1),
            trained,
            row(Sensor::Accel, "sg(11,2)", "pronet", 0.0138),
        ];
        let expected = "\
sensor  data   base      split  levels  label      estimator               RMSE      bias      CRB  ratio  n (seeds)
------  -----  --------  -----  ------  ---------  ---------  -----------------  --------  -------  -----  ---------
accel   euroc  sg(5,2)   test   grid    sigma_inj  mad2                 0.10000  -0.00123  0.00630  15.87      20427
accel   euroc  sg(5,2)   test   grid    sigma_inj  pronet     0.02434 ± 0.00031  -0.00123  0.00630   3.86  20427 (3)
accel   euroc  -         test   grid    -          paper                 0.0301         -        -      -          -
accel   euroc  sg(11,2)  test   grid    sigma_inj  pronet               0.01380  -0.00123  0.00630   2.19      20427
";
        assert_eq!(render(&rows, Layout::Plain).unwrap(), expected);
    }

    #[test]
    fn markdown_has_as_many_bars_in_every_line() {
        let rows = [row(Sensor::Gyro, "sg(5,2)", "pronet", 0.00114)];
        let text = render(&rows, Layout::Markdown).unwrap();
        assert_eq!(text.lines().count(), 4);
        let lengths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        assert!(lengths.windows(2).all(|w| w[0] == w[1]), "\n{text}");
        assert!(text.lines().all(|line| line.matches('|').count() == 13), "\n{text}");
        assert!(text.contains("| paper     |  0.00185 |"), "\n{text}");
    }

    #[test]
    fn the_csv_holds_numbers_in_full() {
        let rows = [row(Sensor::Accel, "sg(5,2)", "mad2", 0.1 + 0.2), row(Sensor::Gyro, "raw", "mad2", 0.5)];
        let mut bytes = Vec::new();
        write_csv(&rows, &mut bytes).unwrap();
        let mut reader = csv::Reader::from_reader(&bytes[..]);
        assert_eq!(reader.headers().unwrap(), &csv::StringRecord::from(COLUMNS.to_vec()));
        let read: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(read.len(), 3);
        assert_eq!(&read[0][7], "0.30000000000000004");
        assert_eq!((&read[1][6], &read[1][7], &read[1][2]), ("paper", "0.0301", ""));
        assert_eq!(&read[2][12], "20427");
    }

    #[test]
    fn a_writer_that_fails_is_an_error() {
        struct Full;
        impl std::io::Write for Full {
            fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
                Err(std::io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let rows = [row(Sensor::Gyro, "raw", "mad2", 0.5)];
        assert!(matches!(write_csv(&rows, Full), Err(TableError::Write { .. })));
    }
}
