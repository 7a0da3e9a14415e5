//! Batches forth and back, for training: windows on all threads.
//!
//! Windows are split into a number of chunks that depends on their count alone; chunks run on rayon's threads and are summed in
//! their order, so that results are the same bits for any number of threads.

use super::Engine;
use super::backward::{Backward, Gradients};
use super::buffer::zeros;
use super::chunk::Chunk;
use super::forward::Forward;
use super::rooms::Room;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// At most this many chunks a batch.
const CHUNKS: usize = 4;
/// Below this many windows a chunk is not worth a thread.
const CHUNK_LEAST: usize = 8;

/// What a forward pass leaves behind for its backward pass; returns its room to the engine when dropped.
#[derive(Debug)]
pub(crate) struct Saved {
    engine: Arc<Engine>,
    room: Mutex<Room>,
    count: usize,
}

impl Drop for Saved {
    fn drop(&mut self) {
        let room = std::mem::take(self.room.get_mut().unwrap_or_else(PoisonError::into_inner));
        self.engine.rooms.give_back(room);
    }
}

impl Engine {
    /// Answers to `windows` (`[count, window]`), `[count, outputs]`, and what the backward pass needs.
    pub(crate) fn forward(self: &Arc<Self>, flat: &[f32], windows: &[f32]) -> (Vec<f32>, Saved) {
        let mut room = self.rooms.take();
        self.pack(flat, &mut room.packed);
        let count = windows.len() / self.of.window;
        let outputs = self.of.head.outputs();
        let mut answers = vec![0.0; count * outputs];
        let size = chunk_size(count);
        room.chunks.resize_with(count.div_ceil(size), Chunk::default);
        let packed = &room.packed;
        room.chunks
            .par_iter_mut()
            .zip(answers.par_chunks_mut(size * outputs))
            .zip(windows.par_chunks(size * self.of.window))
            .for_each(|((chunk, answers), windows)| {
                chunk.fit(&self.of, windows.len() / self.of.window, true);
                self.arch.dispatch(Forward { of: &self.of, packed, windows, keep: true, chunk, answers });
            });
        let saved = Saved { engine: Arc::clone(self), room: Mutex::new(room), count };
        (answers, saved)
    }

    /// The flat gradient of something whose gradient with respect to the answers is `d_answers`.
    pub(crate) fn backward(&self, saved: &Saved, d_answers: &[f32]) -> Vec<f32> {
        let plan = &self.of.plan;
        let outputs = self.of.head.outputs();
        let size = chunk_size(saved.count) * outputs;
        let mut room = saved.room.lock().unwrap_or_else(PoisonError::into_inner);
        let Room { packed, chunks, gradients } = &mut *room;
        gradients.resize_with(chunks.len(), Gradients::default);
        gradients.par_iter_mut().zip(chunks.par_iter()).zip(d_answers.par_chunks(size)).for_each(
            |((gradients, chunk), d_answers)| {
                gradients.fit(plan, d_answers.len() / outputs);
                self.arch.dispatch(Backward { of: &self.of, packed, chunk, d_answers, gradients });
            },
        );
        let mut sums = zeros(plan.gradient_len);
        for chunk in gradients {
            for (sum, part) in sums.iter_mut().zip(chunk.sums.iter()) {
                *sum += part;
            }
        }
        plan.gradient.iter().map(|place| sums[*place as usize]).collect()
    }
}

/// Windows a chunk: a function of their count alone.
fn chunk_size(count: usize) -> usize {
    count.div_ceil(CHUNKS).max(CHUNK_LEAST)
}
