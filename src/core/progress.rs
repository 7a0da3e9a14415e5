//! How a library tells that long work moves on. The command line draws it; libraries print nothing.

/// Receives progress of one piece of long work.
pub trait Progress {
    /// Work of `total` steps starts; `what` is one short phrase.
    fn start(&mut self, what: &str, total: u64);
    /// `done` of the total steps are behind us; `note` carries figures worth showing (a loss, an epoch).
    fn step(&mut self, done: u64, note: &str);
    /// The work is over.
    fn finish(&mut self, note: &str);
}

/// Says nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn start(&mut self, _what: &str, _total: u64) {}
    fn step(&mut self, _done: u64, _note: &str) {}
    fn finish(&mut self, _note: &str) {}
}
