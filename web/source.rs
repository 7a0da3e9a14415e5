//! A log's bytes, as the page hands them over: slices of a dropped file, or parts of one that `dpn page` serves.

use std::io::{self, Read};
use wasm_bindgen::prelude::wasm_bindgen;

#[wasm_bindgen]
extern "C" {
    /// Something of JavaScript with a method `read` that gives the next bytes, none at the end, and throws nothing.
    pub type Source;

    #[wasm_bindgen(method)]
    fn read(this: &Source) -> Vec<u8>;
}

/// The same for a reader.
pub(crate) struct Bytes<'a> {
    source: &'a Source,
    held: Vec<u8>,
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(crate) fn of(source: &'a Source) -> Self {
        Self { source, held: Vec::new(), at: 0 }
    }
}

impl Read for Bytes<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.at == self.held.len() {
            self.held = self.source.read();
            self.at = 0;
        }
        let count = into.len().min(self.held.len() - self.at);
        into[..count].copy_from_slice(&self.held[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}
