//! Numbers that begin on a cache line.

use aligned_vec::{AVec, ConstAlign};
use std::ops::{Deref, DerefMut};

/// A vector of `f32` that begins on a cache line.
#[derive(Debug, Clone)]
pub(crate) struct Buffer(AVec<f32, ConstAlign<64>>);

impl Buffer {
    /// Cuts or lengthens it, the latter with zeros.
    pub(crate) fn resize(&mut self, len: usize) {
        self.0.resize(len, 0.0);
    }
}

impl Default for Buffer {
    fn default() -> Self {
        Self(AVec::new(64))
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.0
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}

/// `len` zeros.
pub(crate) fn zeros(len: usize) -> Buffer {
    let mut buffer = Buffer::default();
    buffer.resize(len);
    buffer
}
