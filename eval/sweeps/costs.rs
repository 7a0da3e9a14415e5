//! What cells are predicted to cost: shards are cut so that they last about equally long.

/// CPU seconds a second of recording \[s/s\] of a cell, and of what it shares (recording, tracks, rendered images), by camera: EuRoC on one core of a
/// server of 2023. Of a training, CPU seconds an update of the default network.
const TABLE: [(&str, CellTime); 4] = [
    ("tracks", CellTime { own_s: 0.013, shared_s: 0.008 }),
    ("images", CellTime { own_s: 0.018, shared_s: 0.06 }),
    ("rendered", CellTime { own_s: 0.018, shared_s: 0.29 }),
    ("train", CellTime { own_s: 0.1, shared_s: 0.0 }),
];

/// CPU seconds of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CellTime {
    /// For what other cells share.
    pub(super) shared_s: f64,
    /// For the cell itself.
    pub(super) own_s: f64,
}

impl CellTime {
    /// Of a cell over `amount` seconds of a recording, seen by a camera of this kind; or of `train` over so many updates.
    pub(super) fn predicted(kind: &str, amount: f64) -> Self {
        let of = TABLE.iter().find(|(of, _)| *of == kind).unwrap_or(&TABLE[0]).1;
        Self { shared_s: of.shared_s * amount, own_s: of.own_s * amount }
    }
}
