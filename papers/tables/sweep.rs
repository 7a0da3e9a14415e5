//! What `dpn eval --closed-loop` prints: absolute errors beside other people's, figures by noise, comparisons, consistency.

use super::ate::Ates;
use dpn_eval::closed_loop::Consistency;
use dpn_eval::published::PublishedAte;
use dpn_eval::study::{NoiseSummary, RowSet, Study};
use dpn_figures::{Cell, Column, Table};

/// Absolute errors by sequence and noise, VINS-Mono's and the paper's beside them where they have the sequence.
pub fn ate(rows: &RowSet<'_>) -> Table {
    let ates = Ates {
        rows,
        noises: rows.noises().to_vec(),
        peers: vec![PublishedAte::vins_mono(rows.truth()), PublishedAte::paper()],
        missing: Vec::new(),
        improvement: None,
        called: ToString::to_string,
    };
    ates.table("ate", "Absolute error [m] after SE(3) alignment, median over seeds; !: failed runs")
}

/// A line of other figures a noise.
pub fn summaries(study: &Study) -> Table {
    let heads = [
        "runs",
        "failed",
        "ATE mean [m]",
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
    let mut table = Table::new("summaries", "Over the sequences, by noise", Column::all(&["noise"], &heads));
    for line in &study.noises {
        table.row(vec![
            Cell::text(&line.noise),
            Cell::text(line.runs),
            Cell::text(line.failures),
            Cell::metres(line.means[0]),
            Cell::percent(line.scale_error, 1),
            Cell::percent(line.lowest_completion, 1),
            Cell::number(line.longest_init_s, 1),
            Cell::text(line.restarts),
            Cell::number(line.whitened, 2),
            Cell::number(line.nees[0], 2),
            Cell::number(line.nees[1], 2),
            Cell::number(line.iterations, 1),
            Cell::number(line.cpu_per_data_s, 4),
            Cell::number(line.p95_update_ms, 1),
        ]);
    }
    table
}

/// Every noise against the reference; nothing where there is nothing to compare.
pub fn comparisons(study: &Study) -> Option<Table> {
    let reference = study.reference.as_ref()?;
    let heads = ["sequences", "better in", "ratio (95 %)", "p", "p (Holm)", "p equal"];
    let title = format!("Against {}", reference.words());
    let mut table = Table::new("comparisons", title, Column::all(&["noise"], &heads));
    for NoiseSummary { noise, comparison, .. } in &study.noises {
        let Some(c) = comparison else { continue };
        table.row(vec![
            Cell::text(noise),
            Cell::text(c.sequences),
            Cell::text(c.better),
            Cell::interval(Some(c.ratio), Some(c.ratio_interval), 3),
            Cell::p(c.p),
            Cell::p(c.p_holm),
            Cell::p(c.p_equal),
        ]);
    }
    (!table.lines.is_empty()).then_some(table)
}

/// What spectra have against the noises told, a line a sequence, noise and sensor; nothing where they have nothing.
pub fn doubts(rows: &RowSet<'_>) -> Option<Table> {
    let title = "Noises that the spectrum of the samples contradicts, or nothing confirms";
    let mut table = Table::new("doubts", title, Column::all(&["sequence", "noise", "what is said"], &[]));
    for sequence in rows.sequences(None) {
        for noise in rows.noises() {
            // Another seed's samples are as doubtful.
            let doubted = rows.cell(sequence, noise).find(|row| !row.noise_doubts.is_empty());
            for words in doubted.iter().flat_map(|row| &row.noise_doubts) {
                table.row(vec![Cell::text(sequence), Cell::text(noise), Cell::text(words)]);
            }
        }
    }
    (!table.lines.is_empty()).then_some(table)
}

/// NEES over seeds; nothing without any.
pub fn consistency(reports: &[Consistency]) -> Option<Table> {
    let heads = ["runs", "bounds", "position", "inside", "above", "orientation", "inside", "above"];
    let title = "NEES over seeds: 3 where the covariance is right";
    let mut table = Table::new("consistency", title, Column::all(&["sequence", "noise"], &heads));
    for Consistency { sequence, noise, nees } in reports {
        let mut cells = vec![
            Cell::text(sequence),
            Cell::text(noise),
            Cell::text(nees.runs),
            Cell::text(format!("{:.2} to {:.2}", nees.bounds[0], nees.bounds[1])),
        ];
        for part in [&nees.position, &nees.orientation] {
            cells.push(Cell::number(part.mean, 2));
            cells.extend([Cell::percent(part.share_inside, 0), Cell::percent(part.share_above, 0)]);
        }
        table.row(cells);
    }
    (!table.lines.is_empty()).then_some(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_eval::closed_loop::testing::row;
    use dpn_eval::study::MARGIN;
    use dpn_train::split::Side;

    #[test]
    fn cells_are_medians_over_seeds_and_failures_stand_beside_them() {
        let rows = [
            row("MH_01_easy", "x1", 0, Some(0.1)),
            row("MH_01_easy", "x1", 1, Some(0.3)),
            row("MH_01_easy", "x1", 2, Some(0.2)),
            row("MH_02_easy", "x1", 0, Some(0.4)),
            row("MH_02_easy", "x1", 1, None),
            row("MH_02_easy", "x1", 2, None),
        ];
        let set = RowSet::new(&rows);
        let expected = "\
Absolute error [m] after SE(3) alignment, median over seeds; !: failed runs
sequence         side   x1, ours  x1, vins  x1, paper
---------------  -----  --------  --------  ---------
MH_01_easy       train     0.200     0.115       0.20
---------------  -----  --------  --------  ---------
MH_02_easy       test    0.400!2     0.126       0.17
---------------  -----  --------  --------  ---------
mean, train (1)  train     0.200     0.115      0.200
mean, test (1)   test      0.400     0.126      0.170
mean, all (2)    both      0.300     0.120      0.185
";
        assert_eq!(ate(&set).console(), expected, "\n{}", ate(&set).console());
        let study = Study::new(&set, MARGIN).unwrap();
        let text = summaries(&study).console();
        assert!(text.ends_with("x1        6       2         0.300  1.0 %      80.0 %       2.0         6      0.90       -       -         2.0   0.0200       3.0\n"), "\n{text}");
        assert_eq!(comparisons(&study), None);
    }

    #[test]
    fn what_is_doubted_is_said_once_a_sequence_and_noise() {
        let mut rows = [0, 1, 2].map(|seed| row("MH_01_easy", "diff2", seed, Some(0.1)));
        assert_eq!(doubts(&RowSet::new(&rows)), None);
        for row in &mut rows[1..] {
            row.noise_doubts = ["accel", "gyro"].map(|sensor| format!("NOT KNOWN: the {sensor}'s")).into();
        }
        // As a row is written and read again; one that was written before there were doubts has none.
        let rows = rows.map(|row| serde_json::from_str(&serde_json::to_string(&row).unwrap()).unwrap());
        let text = doubts(&RowSet::new(&rows)).unwrap().console();
        let line = |sensor: &str| format!("\nMH_01_easy  diff2  NOT KNOWN: the {sensor}'s\n");
        assert!(text.contains(&line("accel")) && text.ends_with(&line("gyro")[1..]), "\n{text}");
        assert_eq!(text.lines().count(), 5, "\n{text}");
    }

    #[test]
    fn flights_have_no_peers_and_the_comparison_says_what_it_was_chosen_on() {
        let mut rows = Vec::new();
        for i in 0..8 {
            for (noise, ate) in [("x1", 0.4), ("x4,x1", 0.2), ("oracle", 0.1)] {
                let mut row = row(&format!("f{i:02}-hover"), noise, 0, Some(ate + 0.01 * f64::from(i)));
                row.split = if i % 2 == 0 { Side::Train } else { Side::Test };
                rows.push(row);
            }
        }
        let text = ate(&RowSet::new(&rows)).console();
        assert!(text.contains("sequence         side   x1, ours  x4,x1, ours  oracle, ours\n"), "\n{text}");
        let of =
            |rows: &[_]| comparisons(&Study::new(&RowSet::new(rows), MARGIN).unwrap()).unwrap().console();
        let text = of(&rows);
        assert!(
            text.starts_with("Against x4,x1, the best constant on the training sequences\nnoise "),
            "\n{text}"
        );
        assert!(text.contains("\noracle          8          8  0."), "\n{text}");
        rows.retain(|row| row.split == Side::Test);
        let text = of(&rows);
        assert!(
            text.starts_with("Against x1, the usual constants (no constant is chosen without"),
            "\n{text}"
        );
    }
}
