//! Rows of the closed loop as text: absolute errors by sequence and noise with the paper's and VINS-Mono's beside them, means over the
//! split, and a line of other figures a noise.
//!
//! A cell is the median over seeds of the absolute error after SE(3) alignment; `!` and a number behind it count failed runs. Runs
//! without an error are left out of medians and means, diverged ones are not: a mean is that of what is there, and failures stand beside it.

use super::compare::Comparison;
use super::consistency::Consistency;
use super::error::ClosedLoopError;
use super::paper::Peer;
use super::row::Row;
use dpn_train::split::Side;
use std::fmt::Write as _;

/// Figures of one noise over all its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The noise spec.
    pub noise: String,
    /// Runs.
    pub runs: usize,
    /// Failed ones.
    pub failures: usize,
    /// Mean over sequences of the median error over seeds \[m\].
    pub mean_ate: Option<f64>,
    /// Lowest share of frames since initialisation with a pose.
    pub lowest_completion: Option<f64>,
    /// Longest initialisation since the first motion \[s\].
    pub longest_init_s: Option<f64>,
    /// Median relative scale error, without its sign.
    pub scale_error: Option<f64>,
    /// Restarts in all.
    pub restarts: usize,
    /// Median mean square of the whitened inertial residual.
    pub whitened: Option<f64>,
    /// Median NEES of position and orientation.
    pub nees: [Option<f64>; 2],
    /// Median iterations a frame.
    pub iterations: Option<f64>,
    /// Median CPU seconds a second of data.
    pub cpu_per_data_s: Option<f64>,
    /// Highest 95th percentile of an update's CPU time \[ms\].
    pub p95_update_ms: Option<f64>,
}

/// The table and the lines below it.
///
/// # Errors
/// [`ClosedLoopError::Paper`].
pub fn render(rows: &[Row]) -> Result<String, ClosedLoopError> {
    let mut out = ate_table(rows)?;
    out.push('\n');
    out.push_str(&summary_table(rows));
    Ok(out)
}

/// Figures by noise, in the order in which noises come.
pub fn summaries(rows: &[Row]) -> Vec<Summary> {
    distinct(rows.iter().map(|r| r.noise.as_str())).into_iter().map(|noise| summary(rows, noise)).collect()
}

fn summary(rows: &[Row], noise: &str) -> Summary {
    let of: Vec<&Row> = rows.iter().filter(|r| r.noise == noise).collect();
    let values = |f: &dyn Fn(&Row) -> Option<f64>| of.iter().filter_map(|r| f(r)).collect::<Vec<f64>>();
    let lowest = |v: Vec<f64>| v.into_iter().min_by(f64::total_cmp);
    let highest = |v: Vec<f64>| v.into_iter().max_by(f64::total_cmp);
    let sequences = distinct(of.iter().map(|r| r.sequence.as_str()));
    Summary {
        noise: noise.to_owned(),
        runs: of.len(),
        failures: of.iter().filter(|r| r.failure.is_some()).count(),
        mean_ate: mean(&sequences.iter().filter_map(|s| cell(rows, s, noise).ate).collect::<Vec<_>>()),
        lowest_completion: lowest(values(&|r| r.completion)),
        longest_init_s: highest(values(&|r| r.init_in_motion_s.or(r.init_s))),
        scale_error: median(values(&|r| r.scale_error.map(f64::abs))),
        restarts: of.iter().map(|r| r.restarts).sum(),
        whitened: median(values(&|r| r.whitened)),
        nees: [median(values(&|r| r.nees_position)), median(values(&|r| r.nees_orientation))],
        iterations: median(values(&|r| r.iterations)),
        cpu_per_data_s: median(values(&|r| Some(r.cpu_per_data_s))),
        p95_update_ms: highest(values(&|r| Some(r.p95_update_ms))),
    }
}

/// One noise's column and those of the peers that have it.
struct Column {
    noise: String,
    peers: Vec<Peer>,
}

fn ate_table(rows: &[Row]) -> Result<String, ClosedLoopError> {
    let peers = [Peer::vins_mono()?, Peer::paper()?];
    let sequences = distinct(rows.iter().map(|r| r.sequence.as_str()));
    let knows = |peer: &&Peer, noise: &str| sequences.iter().any(|s| peer.ate(s, noise).is_some());
    let columns: Vec<Column> = distinct(rows.iter().map(|r| r.noise.as_str()))
        .into_iter()
        .map(|noise| Column {
            noise: noise.to_owned(),
            peers: peers.iter().filter(|peer| knows(peer, noise)).cloned().collect(),
        })
        .collect();
    let mut names = vec!["ATE SE(3) [m]".to_owned()];
    let mut heads = vec![String::new()];
    for column in &columns {
        names.push(column.noise.clone());
        heads.push("ours".into());
        for peer in &column.peers {
            names.push(String::new());
            heads.push(peer.name.into());
        }
    }
    let mut table = vec![names, heads];
    for sequence in &sequences {
        let side = rows.iter().find(|r| r.sequence == *sequence).map(|r| r.split);
        let mark = if side == Some(Side::Test) { "*" } else { "" };
        let mut line = vec![format!("{sequence}{mark}")];
        for column in &columns {
            line.push(cell(rows, sequence, &column.noise).to_string());
            line.extend(column.peers.iter().map(|peer| metres(peer.ate(sequence, &column.noise))));
        }
        table.push(line);
    }
    table.push(Vec::new());
    let side_of = |s: &str| rows.iter().find(|r| r.sequence == s).map(|r| r.split);
    for (name, side) in [("mean train", Some(Side::Train)), ("mean test *", Some(Side::Test)), ("mean", None)]
    {
        let of: Vec<&str> =
            sequences.iter().filter(|s| side.is_none() || side_of(s) == side).copied().collect();
        if of.is_empty() {
            continue;
        }
        let mut line = vec![name.to_owned()];
        for column in &columns {
            let cells: Vec<AteCell> = of.iter().map(|s| cell(rows, s, &column.noise)).collect();
            let ates: Vec<f64> = cells.iter().filter_map(|c| c.ate).collect();
            let failures = cells.iter().map(|c| c.failures).sum();
            line.push(AteCell { ate: mean(&ates), failures }.to_string());
            for peer in &column.peers {
                let theirs: Vec<f64> = of.iter().filter_map(|s| peer.ate(s, &column.noise)).collect();
                line.push(metres(mean(&theirs)));
            }
        }
        table.push(line);
    }
    Ok(aligned(&table))
}

fn summary_table(rows: &[Row]) -> String {
    let heads = [
        "noise",
        "runs",
        "failed",
        "ATE [m]",
        "scale",
        "completion",
        "init [s]",
        "restarts",
        "whitened",
        "NEES p",
        "NEES r",
        "iterations",
        "CPU s/s",
        "p95 [ms]",
    ];
    let mut table = vec![heads.map(str::to_owned).to_vec()];
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
    };
    let percent =
        |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{:.1} %", 100.0 * v));
    for s in summaries(rows) {
        table.push(vec![
            s.noise,
            s.runs.to_string(),
            s.failures.to_string(),
            number(s.mean_ate, 3),
            percent(s.scale_error),
            percent(s.lowest_completion),
            number(s.longest_init_s, 1),
            s.restarts.to_string(),
            number(s.whitened, 2),
            number(s.nees[0], 2),
            number(s.nees[1], 2),
            number(s.iterations, 1),
            number(s.cpu_per_data_s, 4),
            number(s.p95_update_ms, 1),
        ]);
    }
    aligned(&table)
}

/// NEES over seeds; empty without any.
pub fn render_consistency(reports: &[Consistency]) -> String {
    if reports.is_empty() {
        return String::new();
    }
    let heads = [
        "NEES (3 if right)",
        "noise",
        "runs",
        "bounds",
        "position",
        "inside",
        "above",
        "orientation",
        "inside",
        "above",
    ];
    let mut table = vec![heads.map(str::to_owned).to_vec()];
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    for Consistency { sequence, noise, nees } in reports {
        let mut line = vec![
            sequence.clone(),
            noise.clone(),
            nees.runs.to_string(),
            format!("{:.2} to {:.2}", nees.bounds[0], nees.bounds[1]),
        ];
        for part in [&nees.position, &nees.orientation] {
            line.extend([format!("{:.2}", part.mean), percent(part.share_inside), percent(part.share_above)]);
        }
        table.push(line);
    }
    aligned(&table)
}

/// Every noise against the best constant; empty without any.
pub fn render_comparisons(comparisons: &[Comparison]) -> String {
    let Some(first) = comparisons.first() else {
        return String::new();
    };
    let heads = [
        &format!("against {}, the best constant", first.constant),
        "sequences",
        "better",
        "ratio",
        "p",
        "p (Holm)",
    ];
    let mut table = vec![heads.map(str::to_owned).to_vec()];
    for c in comparisons {
        table.push(vec![
            c.noise.clone(),
            c.sequences.to_string(),
            c.better.to_string(),
            format!("{:.3}", c.ratio),
            format!("{:.4}", c.p),
            format!("{:.4}", c.p_holm),
        ]);
    }
    aligned(&table)
}

/// What stands in a cell of the table of errors.
pub(super) struct AteCell {
    pub(super) ate: Option<f64>,
    failures: usize,
}

impl std::fmt::Display for AteCell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&metres(self.ate))?;
        if self.failures > 0 { write!(f, "!{}", self.failures) } else { Ok(()) }
    }
}

pub(super) fn cell(rows: &[Row], sequence: &str, noise: &str) -> AteCell {
    let of = || rows.iter().filter(|r| r.sequence == sequence && r.noise == noise);
    AteCell {
        ate: median(of().filter_map(|r| r.ate_se3).collect()),
        failures: of().filter(|r| r.failure.is_some()).count(),
    }
}

fn metres(value: Option<f64>) -> String {
    match value {
        Some(value) if value >= 10.0 => format!("{value:.1}"),
        Some(value) if value >= 1.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.3}"),
        None => "-".to_owned(),
    }
}

/// Each once, in the order in which they come.
pub(super) fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found: Vec<&str> = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

/// Columns aligned, the first to the left, the others to the right; an empty row is a rule.
fn aligned(table: &[Vec<String>]) -> String {
    let columns = table.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |c: usize| table.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let total = widths.iter().sum::<usize>() + 2 * columns.saturating_sub(1);
    let mut out = String::new();
    for row in table {
        if row.is_empty() {
            let _ = writeln!(out, "{}", "-".repeat(total));
            continue;
        }
        let cells = row.iter().zip(&widths).enumerate();
        let cells =
            cells.map(|(c, (text, &w))| if c == 0 { format!("{text:<w$}") } else { format!("{text:>w$}") });
        let line = cells.collect::<Vec<_>>().join("  ");
        let _ = writeln!(out, "{}", line.trim_end());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::row::testing::row;

    #[test]
    fn cells_are_medians_over_seeds_and_failures_stand_beside_the_mean_of_what_is_there() {
        let rows = [
            row("MH_01_easy", "x1", 0, Some(0.1)),
            row("MH_01_easy", "x1", 1, Some(0.3)),
            row("MH_01_easy", "x1", 2, Some(0.2)),
            row("MH_02_easy", "x1", 0, Some(0.4)),
            row("MH_02_easy", "x1", 1, None),
            row("MH_02_easy", "x1", 2, None),
        ];
        let text = render(&rows).unwrap();
        let expected = "\
ATE SE(3) [m]       x1
                  ours   vins  paper
MH_01_easy       0.200  0.115  0.200
MH_02_easy*    0.400!2  0.126  0.170
------------------------------------
mean train       0.200  0.115  0.200
mean test *    0.400!2  0.126  0.170
mean           0.300!2  0.120  0.185

noise  runs  failed  ATE [m]  scale  completion  init [s]  restarts  whitened  NEES p  NEES r  iterations  CPU s/s  p95 [ms]
x1        6       2    0.300  1.0 %      80.0 %       2.0         6      0.90       -       -         2.0   0.0200       3.0
";
        assert_eq!(text, expected, "\n{text}");
    }

    #[test]
    fn flights_have_no_peers_and_several_noises_their_columns() {
        let rows = [row("f09-hover", "x4,x1", 0, Some(12.3)), row("f09-hover", "oracle", 0, Some(1.234))];
        let text = ate_table(&rows).unwrap();
        assert!(text.contains("f09-hover*      12.3    1.23\n") && !text.contains("vins"), "\n{text}");
    }
}
