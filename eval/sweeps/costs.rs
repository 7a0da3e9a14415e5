//! What cells cost: measured by the shards of earlier sweeps, by a small table where nothing was.

use super::error::SweepError;
use super::shard_files::{COSTS, text_of};
use crate::closed_loop::CellTime;
use dpn_core::signal::stats::median_of;
use dpn_io::IoError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// CPU seconds a second of recording \[s/s\] of a cell, and of what it shares (recording, tracks, rendered images), by camera: EuRoC on one core of a
/// server of 2023. Of a training, CPU seconds an update of the default network.
const DEFAULTS: [(&str, f64, f64); 4] =
    [("tracks", 0.013, 0.008), ("images", 0.018, 0.06), ("rendered", 0.018, 0.29), ("train", 0.1, 0.0)];

/// What one cell took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellCost {
    /// What the odometry saw, as in rows; `train` for a training.
    pub kind: String,
    /// The sequence; of a training, the sensor.
    pub on: String,
    /// The noise; of a training, the base.
    pub what: String,
    /// The seed.
    pub seed: u64,
    /// How much there was to do: seconds of the recording; updates.
    pub amount: f64,
    /// CPU seconds for what other cells share, where this one made it.
    pub shared_s: f64,
    /// CPU seconds for the cell itself.
    pub own_s: f64,
}

impl CellCost {
    pub(super) fn new(cell: &CostOf<'_>, seed: u64, time: CellTime) -> Self {
        let CostOf { kind, on, what, amount } = *cell;
        let (kind, on, what) = (kind.to_owned(), on.to_owned(), what.to_owned());
        Self { kind, on, what, seed, amount, shared_s: time.shared_s, own_s: time.own_s }
    }
}

/// A cell whose cost is asked for: the same words as in [`CellCost`].
#[derive(Debug, Clone, Copy)]
pub struct CostOf<'a> {
    /// What the odometry sees, or `train`.
    pub kind: &'a str,
    /// Sequence or sensor.
    pub on: &'a str,
    /// Noise or base.
    pub what: &'a str,
    /// Seconds or updates.
    pub amount: f64,
}

/// Measured costs.
#[derive(Debug, Default)]
pub struct Costs {
    /// A unit's cost by kind, sequence, noise; the latter two empty for all.
    own: BTreeMap<[String; 3], f64>,
    /// A unit's shared cost by kind and sequence.
    shared: BTreeMap<[String; 2], f64>,
}

impl Costs {
    /// From the shards of a sweep's folder, as far as they were run.
    ///
    /// # Errors
    /// A folder that cannot be listed; a file that cannot be read.
    pub fn measured(dir: &Path) -> Result<Self, SweepError> {
        let shards = dir.join("shards");
        let failed = |source| IoError::Read { path: shards.clone(), source };
        let mut cells = Vec::new();
        for entry in std::fs::read_dir(&shards).map_err(failed)? {
            cells.extend(read(&entry.map_err(failed)?.path().join(COSTS))?);
        }
        Ok(Self::of(&cells))
    }

    fn of(cells: &[CellCost]) -> Self {
        let mut own: BTreeMap<[String; 3], Vec<f64>> = BTreeMap::new();
        // What is shared was made once a shard that had a part of it: the dearest is the whole.
        let mut shared: BTreeMap<[String; 2], BTreeMap<(String, u64), f64>> = BTreeMap::new();
        for cell in cells.iter().filter(|cell| cell.amount > 0.0) {
            let (all, kind) = (String::new, || cell.kind.clone());
            let keys = [
                [kind(), cell.on.clone(), cell.what.clone()],
                [kind(), all(), cell.what.clone()],
                [kind(), all(), all()],
            ];
            for key in keys {
                own.entry(key).or_default().push(cell.own_s / cell.amount);
            }
            for key in [[kind(), cell.on.clone()], [kind(), all()]] {
                let seen = shared.entry(key).or_default().entry((cell.on.clone(), cell.seed)).or_default();
                *seen = seen.max(cell.shared_s / cell.amount);
            }
        }
        // What was taken from a cache says nothing of what it costs.
        for seen in shared.values_mut() {
            seen.retain(|_, cost| *cost > 0.0);
        }
        shared.retain(|_, seen| !seen.is_empty());
        let middle = |values: Vec<f64>| median_of(values).expect("an entry was made with its first value");
        Self {
            own: own.into_iter().map(|(key, values)| (key, middle(values))).collect(),
            shared: shared
                .into_iter()
                .map(|(key, seen)| (key, middle(seen.into_values().collect())))
                .collect(),
        }
    }

    /// What a cell takes, and what it shares with its neighbours: as measured of the same sequence and noise, else of the noise, else of all, else
    /// by the table.
    pub fn of_cell(&self, cell: &CostOf<'_>) -> CellTime {
        let (kind, all) = (cell.kind.to_owned(), String::new());
        let table = DEFAULTS.iter().find(|(kind, ..)| *kind == cell.kind).unwrap_or(&DEFAULTS[0]);
        let own = [[cell.on, cell.what], ["", cell.what], ["", ""]]
            .into_iter()
            .find_map(|[on, what]| self.own.get(&[kind.clone(), on.to_owned(), what.to_owned()]));
        let shared =
            [cell.on.to_owned(), all].into_iter().find_map(|on| self.shared.get(&[kind.clone(), on]));
        CellTime {
            own_s: own.unwrap_or(&table.1) * cell.amount,
            shared_s: shared.unwrap_or(&table.2) * cell.amount,
        }
    }
}

/// The lines of a file, none where it is not there. What a process that was killed left of a line is no measurement.
fn read(path: &Path) -> Result<Vec<CellCost>, SweepError> {
    Ok(text_of(path)?.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_measurement_is_taken_and_the_table_where_there_is_none() {
        let cell = |on: &str, what: &str, seed, shared_s, own_s| CellCost {
            kind: "tracks".into(),
            on: on.into(),
            what: what.into(),
            seed,
            amount: 10.0,
            shared_s,
            own_s,
        };
        let costs = Costs::of(&[
            cell("a", "x1", 0, 5.0, 1.0),
            cell("a", "x1", 1, 7.0, 3.0),
            cell("a", "net", 0, 0.0, 8.0),
            cell("b", "x1", 0, 1.0, 4.0),
        ]);
        let of = |kind: &str, on: &str, what: &str| {
            let time = costs.of_cell(&CostOf { kind, on, what, amount: 100.0 });
            (time.shared_s, time.own_s)
        };
        assert_eq!(of("tracks", "a", "x1"), (60.0, 20.0));
        assert_eq!(of("tracks", "b", "net"), (10.0, 80.0));
        assert_eq!(of("tracks", "c", "x1"), (50.0, 30.0));
        assert_eq!(of("tracks", "c", "other"), (50.0, 35.0));
        assert_eq!(of("train", "c", "other"), (0.0, 10.0));
    }
}
