//! The seam between a bag's reader and whoever wants its messages.

use crate::budget::Budget;
use crate::fields::Encoding;

/// Takes what a bag's reader finds, in the file's order.
pub(crate) trait Messages {
    /// Forgets the numbers of connections: the next file of a bag has its own.
    fn next_file(&mut self);

    /// A connection, channel or row of a topic table. Returns whether its messages are wanted.
    fn declare(&mut self, number: u32, name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool;

    /// A message on a declared number; `received_ns` is the bag's own stamp.
    fn message(&mut self, number: u32, received_ns: i64, data: &[u8]);

    /// What the bag may unpack to.
    fn budget(&mut self) -> &mut Budget;

    /// Whether nothing more is wanted: the reader ends.
    fn is_done(&self) -> bool {
        false
    }
}
