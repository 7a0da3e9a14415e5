//! Absolute errors by sequence and noise, with other people's beside them and means below.

use dpn_core::estimate::NoiseSpec;
use dpn_eval::published::{self, PublishedAte};
use dpn_eval::study::RowSet;
use dpn_figures::{Cell, Column, Table};
use dpn_train::split::Side;

/// What stands in a table of absolute errors.
#[derive(Debug)]
pub(super) struct Ates<'a> {
    pub(super) rows: &'a RowSet<'a>,
    /// A column each.
    pub(super) noises: Vec<&'a NoiseSpec>,
    /// A column more for every one of these that has the noise.
    pub(super) peers: Vec<PublishedAte>,
    /// Sequences without any row.
    pub(super) missing: Vec<(&'a str, Side)>,
    /// The two noises of which the second improves on the first: in columns of its own, before all others.
    pub(super) improvement: Option<[&'a NoiseSpec; 2]>,
    /// What a noise is called in the head of its columns.
    pub(super) called: fn(&NoiseSpec) -> String,
}

const SIDES: [Side; 2] = [Side::Train, Side::Test];

impl Ates<'_> {
    /// Training and test sequences told apart, their means below.
    pub(super) fn table(&self, name: &'static str, title: &str) -> Table {
        let mut table = Table::new(name, title, self.columns());
        for side in SIDES {
            let missing = || self.missing.iter().filter(|(_, of)| *of == side);
            for name in self.rows.sequences(Some(side)) {
                table.row(self.sequence(name, side, false));
            }
            for (name, _) in missing() {
                table.row(self.sequence(name, side, true));
            }
            if self.rows.count(Some(side)) + missing().count() > 0 {
                table.rule();
            }
        }
        let sides =
            [("mean, train", Some(Side::Train)), ("mean, test", Some(Side::Test)), ("mean, all", None)];
        for (label, side) in sides.into_iter().filter(|(_, side)| self.rows.count(*side) > 0) {
            table.row(self.means(label, side));
        }
        table
    }

    /// The peers that have a noise.
    fn peers_of<'s>(&'s self, noise: &'s NoiseSpec) -> impl Iterator<Item = &'s PublishedAte> {
        let knows = |peer: &&PublishedAte| self.names(None).any(|name| peer.ate(name, noise).is_some());
        self.peers.iter().filter(knows)
    }

    /// Sequences of one side or of both, the missing ones too.
    fn names(&self, side: Option<Side>) -> impl Iterator<Item = &str> {
        let missing = self.missing.iter().filter(move |(_, of)| side.is_none_or(|side| side == *of));
        self.rows.sequences(side).chain(missing.map(|(name, _)| *name))
    }

    fn columns(&self) -> Vec<Column> {
        let mut columns = Column::all(&["sequence", "side"], &[]);
        if self.improvement.is_some() {
            columns.push(Column::number("improvement [%], ours"));
            columns.extend(
                self.peers.iter().map(|peer| Column::number(format!("improvement [%], {}", peer.name))),
            );
        }
        for noise in &self.noises {
            let called = (self.called)(noise);
            columns.push(Column::number(format!("{called}, ours")));
            columns
                .extend(self.peers_of(noise).map(|peer| Column::number(format!("{called}, {}", peer.name))));
        }
        columns
    }

    fn sequence(&self, name: &str, side: Side, missing: bool) -> Vec<Cell> {
        let ours = |cell: Cell| if missing { Cell::text("missing") } else { cell };
        let mut cells = vec![Cell::text(name), Cell::text(side)];
        if let Some(pair) = self.improvement {
            cells.push(ours(Cell::number(rate(pair.map(|noise| self.rows.ate(name, noise))), 1)));
            cells.extend(self.peers.iter().map(|_| Cell::number(published::printed_improvement(name), 1)));
        }
        for noise in &self.noises {
            let failures = self.rows.failures(name, noise);
            let mark = if failures > 0 { format!("!{failures}") } else { String::new() };
            cells.push(ours(Cell::metres(self.rows.ate(name, noise)).marked(&mark)));
            cells.extend(self.peers_of(noise).map(|peer| Cell::number(peer.ate(name, noise), peer.decimals)));
        }
        cells
    }

    fn means(&self, label: &str, side: Option<Side>) -> Vec<Cell> {
        let names: Vec<&str> = self.rows.sequences(side).collect();
        // Of all of them or none; means of different sets mislead.
        let mean = |of: &dyn Fn(&str) -> Option<f64>| {
            let values: Option<Vec<f64>> = names.iter().map(|name| of(name)).collect();
            values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
        };
        let side_name = side.map_or("both".to_owned(), |side| side.to_string());
        let mut cells = vec![Cell::text(format!("{label} ({})", names.len())), Cell::text(side_name)];
        if let Some(pair) = self.improvement {
            let ours = |name: &str| rate(pair.map(|noise| self.rows.ate(name, noise)));
            cells.push(Cell::number(mean(&ours), 1));
            for peer in &self.peers {
                let theirs = |name: &str| rate(pair.map(|noise| peer.ate(name, noise)));
                cells.push(Cell::number(mean(&theirs), 1));
            }
        }
        for noise in &self.noises {
            cells.push(Cell::metres(self.rows.mean(noise, side)));
            cells.extend(
                self.peers_of(noise).map(|peer| Cell::number(mean(&|name| peer.ate(name, noise)), 3)),
            );
        }
        cells
    }
}

/// Rate of improvement of the second error over the first \[%\].
pub(super) fn rate([baseline, ours]: [Option<f64>; 2]) -> Option<f64> {
    Some(100.0 * (baseline? - ours?) / baseline?)
}
