//! Numbers that begin on a cache line.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line.
const LINE: usize = 64;
/// Numbers a line.
const SLACK: usize = LINE / size_of::<f32>();

/// A vector of `f32` that begins on a cache line, as far as the allocator lets see where it begins.
#[derive(Debug, Default)]
pub(crate) struct Buffer {
    /// The numbers behind `begin` others.
    room: Vec<f32>,
    begin: usize,
    len: usize,
}

impl Buffer {
    /// Cuts or lengthens it, the latter with zeros.
    pub(crate) fn resize(&mut self, len: usize) {
        if len <= self.len {
            self.len = len;
        } else if self.begin + len <= self.room.len() {
            self.room[self.begin + self.len..self.begin + len].fill(0.0);
            self.len = len;
        } else {
            let mut room = vec![0.0; len + SLACK];
            // Nothing depends on it but speed.
            let begin = room.as_ptr().align_offset(LINE).min(SLACK);
            room[begin..begin + self.len].copy_from_slice(self);
            *self = Self { room, begin, len };
        }
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        let mut copy = zeros(self.len);
        copy.copy_from_slice(self);
        copy
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.room[self.begin..self.begin + self.len]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.room[self.begin..self.begin + self.len]
    }
}

/// `len` zeros.
pub(crate) fn zeros(len: usize) -> Buffer {
    let mut buffer = Buffer::default();
    buffer.resize(len);
    buffer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_begins_on_a_line_and_keeps_what_it_has_when_it_grows() {
        let mut buffer = Buffer::default();
        assert!(buffer.is_empty());
        for (len, sum) in [(3, 0.0), (7, 3.0), (1000, 7.0), (5, 5.0), (900, 5.0)] {
            buffer.resize(len);
            assert_eq!((buffer.len(), buffer.iter().sum::<f32>()), (len, sum), "what is new is zero");
            assert_eq!(buffer.as_ptr().align_offset(LINE), 0);
            buffer.fill(1.0);
            let copy = buffer.clone();
            assert_eq!(*copy, *buffer);
            assert_eq!(copy.as_ptr().align_offset(LINE), 0);
        }
    }
}
