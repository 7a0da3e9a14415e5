//! What this machine can do at once.

/// How many threads this machine runs at a time.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
