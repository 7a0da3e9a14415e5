//! Parts of what a window has measured.

/// Which measurements enter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// All of them.
    All,
    /// Those that would be lost with so many of the oldest frames.
    Oldest(usize),
}
