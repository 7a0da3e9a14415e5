//! Memory on the card, which remembers how many numbers it holds.

use cubecl::prelude::*;
use cubecl::server::Handle;

/// Numbers of four bytes on the card.
#[derive(Clone)]
pub(crate) struct Room {
    pub(crate) handle: Handle,
    len: usize,
}

impl Room {
    /// Room for `len` numbers, at least one: no card binds nothing.
    pub(crate) fn empty(client: &Client, len: usize) -> Self {
        let len = len.max(1);
        Self { handle: client.empty(4 * len), len }
    }

    pub(crate) fn of<T: CubeElement>(client: &Client, numbers: &[T]) -> Self {
        assert!(size_of::<T>() == 4 && !numbers.is_empty(), "numbers of four bytes");
        Self { handle: client.create_from_slice(T::as_bytes(numbers)), len: numbers.len() }
    }

    /// What a kernel is handed.
    #[allow(unsafe_code, reason = "the one door between numbers on the card and a kernel's slices")]
    pub(crate) fn arg(&self) -> BufferArg {
        // SAFETY: the handle was made for `len` numbers of four bytes, here, and every kernel of this crate reads it as such.
        unsafe { BufferArg::from_raw_parts(self.handle.clone(), self.len) }
    }
}
