//! What becomes of a sweep when one of its sequences cannot be seen, or one of its cells not be run.

use super::cell::Cell;
use super::error::ClosedLoopError;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A sequence that nothing could be seen of.
#[derive(Debug)]
pub struct UntrackedSequence {
    /// Its place in the source.
    pub place: usize,
    /// Why: its files, tracks or images cannot be had, or not enough of them.
    pub error: ClosedLoopError,
}

/// A cell that could not be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailedCell {
    /// Checksum of its content.
    pub cell: String,
    /// Why, in words.
    pub reason: String,
}

/// The first error of every sequence that cannot be seen, by its place.
#[derive(Debug, Default)]
pub(super) struct UnseenSequences(Mutex<BTreeMap<usize, ClosedLoopError>>);

impl UnseenSequences {
    fn found(&self) -> MutexGuard<'_, BTreeMap<usize, ClosedLoopError>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn into_list(self) -> Vec<UntrackedSequence> {
        let found = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        found.into_iter().map(|(place, error)| UntrackedSequence { place, error }).collect()
    }
}

/// What becomes of the other cells.
pub(super) enum OnFault<'a> {
    /// Nothing: that is an error.
    Fail,
    /// They go on where a sequence cannot be seen; whatever else is wrong with a cell is an error.
    LeaveOut(&'a UnseenSequences),
    /// They go on whatever is wrong with a cell, which is kept here.
    Note { unseen: &'a UnseenSequences, failed: &'a Mutex<Vec<FailedCell>> },
}

impl OnFault<'_> {
    /// Whether a cell has no row, and that is known.
    pub(super) fn leaves_out(&self, cell: &Cell<'_>) -> bool {
        match self {
            Self::Fail => false,
            Self::LeaveOut(unseen) => unseen.found().contains_key(&cell.place),
            Self::Note { failed, .. } => {
                let failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.iter().any(|failed| failed.cell == cell.content)
            }
        }
    }

    /// The same before the cell is run: what is known of its sequence is noted of it.
    pub(super) fn passes_over(&self, cell: &Cell<'_>) -> bool {
        match self {
            Self::Fail => false,
            Self::LeaveOut(unseen) => unseen.found().contains_key(&cell.place),
            Self::Note { unseen, failed } => {
                let reason = unseen.found().get(&cell.place).map(ClosedLoopError::in_full);
                let known = reason.is_some();
                note(failed, cell, reason);
                known
            }
        }
    }

    /// An error of seeing a cell's sequence: given back, or kept.
    pub(super) fn unseen(&self, cell: &Cell<'_>, error: ClosedLoopError) -> Result<(), ClosedLoopError> {
        if let Self::Note { failed, .. } = self {
            note(failed, cell, Some(error.in_full()));
        }
        self.of_training(cell.place, error)
    }

    /// An error of reading a sequence that a mean is taken over.
    pub(super) fn of_training(&self, place: usize, error: ClosedLoopError) -> Result<(), ClosedLoopError> {
        match self {
            Self::Fail => return Err(error),
            Self::LeaveOut(unseen) | Self::Note { unseen, .. } => {
                unseen.found().entry(place).or_insert(error);
            }
        }
        Ok(())
    }

    /// Any other error of a cell: given back, or kept.
    pub(super) fn of_cell(&self, cell: &Cell<'_>, error: ClosedLoopError) -> Result<(), ClosedLoopError> {
        match self {
            Self::Fail | Self::LeaveOut(_) => Err(error),
            Self::Note { failed, .. } => {
                note(failed, cell, Some(error.in_full()));
                Ok(())
            }
        }
    }
}

fn note(failed: &Mutex<Vec<FailedCell>>, cell: &Cell<'_>, reason: Option<String>) {
    let failed_cell = |reason| FailedCell { cell: cell.content.clone(), reason };
    failed.lock().unwrap_or_else(PoisonError::into_inner).extend(reason.map(failed_cell));
}
