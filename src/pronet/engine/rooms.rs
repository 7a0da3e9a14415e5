//! Room for passes over batches, used again.

use super::backward::Gradients;
use super::buffer::Buffer;
use super::chunk::Chunk;
use std::sync::{Mutex, PoisonError};

/// Rooms of finished passes, kept for the next: fresh memory would be paid for page by page at every step.
#[derive(Debug, Default)]
pub(super) struct Rooms(Mutex<Vec<Room>>);

impl Rooms {
    pub(super) fn take(&self) -> Room {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(super) fn give_back(&self, room: Room) {
        let mut rooms = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if rooms.len() < 2 {
            rooms.push(room);
        }
    }
}

/// Room for one pass over a batch, forth and back.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) packed: Buffer,
    pub(super) chunks: Vec<Chunk>,
    pub(super) gradients: Vec<Gradients>,
}
