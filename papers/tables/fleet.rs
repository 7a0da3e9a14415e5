//! The fleet: scores over all platforms, and each platform by itself.

use super::comparison::against;
use dpn_eval::fleet::{FleetScore, NoiseScore};
use dpn_figures::{Cell, Column, Table};

/// A line a noise: its score over the fleet. The answer.
pub fn fleet(score: &FleetScore) -> Table {
    let columns = Column::all(
        &["noise"],
        &["score", "worst", "ratio to the single constant (95 %)", "better in", "p (Holm)"],
    );
    let title = "Error over that of each platform's best constant, geometric mean over platforms";
    let mut table = Table::new("fleet", title, columns);
    let mut line = |name: String, line: &NoiseScore| {
        let [ratio, better, p] = against(line.comparison.as_ref());
        let worst = line.worst.as_ref();
        table.row(vec![
            Cell::text(name),
            Cell::number(line.score, 2),
            worst.map_or_else(Cell::none, |(platform, score)| Cell::text(format!("{score:.2} ({platform})"))),
            ratio,
            line.comparison.as_ref().map_or_else(Cell::none, |_| better),
            p,
        ]);
    };
    for noise in &score.noises {
        line(noise.noise.as_ref().map(ToString::to_string).unwrap_or_default(), noise);
    }
    if let Some(single) = &score.single {
        line("single constant".into(), single);
    }
    table.note(
        "Score 1: as good as the best constant of each platform, found on the very sequences that are judged. Single constant: on each platform the one with the best \
         score on all others. A noise without a score lost a sequence.",
    );
    table
}

/// A line a platform: errors of every noise.
pub fn fleet_platforms(score: &FleetScore) -> Table {
    let noises: Vec<String> =
        score.noises.iter().filter_map(|line| Some(line.noise.as_ref()?.to_string())).collect();
    let heads: Vec<&str> = noises.iter().map(String::as_str).collect();
    let mut columns = Column::all(&["platform"], &["sequences", "best constant"]);
    columns.extend(heads.iter().map(|head| Column::number(*head)));
    let mut table = Table::new("platforms", "Mean absolute error by platform [m]", columns);
    for platform in &score.platforms {
        let best = platform.best.as_ref().map_or_else(
            || "none".to_owned(),
            |best| format!("{best}{}", if platform.at_edge { " (end of the sweep)" } else { "" }),
        );
        let mut cells = vec![Cell::text(&platform.name), Cell::text(platform.sequences), Cell::text(best)];
        cells.extend(platform.noises.iter().map(|line| match line.ate {
            Some(ate) => Cell::metres(ate),
            None => Cell::text("lost"),
        }));
        table.row(cells);
    }
    table
}
