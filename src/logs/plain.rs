//! Text as other systems write it, as lines of UTF-8: UTF-16, which Windows' shell makes of what it is given, and lines that end with a carriage return alone.

use std::io::{self, Read};

/// What is to be done with the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    /// UTF-16, its lower byte first or last.
    Utf16 { is_little: bool },
    /// Lines end with a carriage return.
    Returns,
}

impl Coding {
    /// By the first bytes; `None` where they are as they should be.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        let is_zero = |first: usize| head.iter().skip(first).step_by(2).take(32).all(|byte| *byte == 0);
        match head {
            [0xff, 0xfe, ..] => Some(Self::Utf16 { is_little: true }),
            [0xfe, 0xff, ..] => Some(Self::Utf16 { is_little: false }),
            _ if head.len() < 64 => None,
            _ if is_zero(1) && !is_zero(0) => Some(Self::Utf16 { is_little: true }),
            _ if is_zero(0) && !is_zero(1) => Some(Self::Utf16 { is_little: false }),
            _ if head.contains(&b'\r') && !head.contains(&b'\n') => Some(Self::Returns),
            _ => None,
        }
    }
}

/// A source of such text, read as lines of UTF-8.
pub(crate) struct Plain<R> {
    source: R,
    coding: Coding,
    /// Bytes of half a character.
    rest: Vec<u8>,
    ready: Vec<u8>,
    at: usize,
}

impl<R: Read> Plain<R> {
    pub(crate) fn new(source: R, coding: Coding) -> Self {
        Self { source, coding, rest: Vec::new(), ready: Vec::new(), at: 0 }
    }

    fn take(&mut self, bytes: &[u8]) {
        self.ready.clear();
        self.at = 0;
        match self.coding {
            Coding::Returns => self.ready.extend(bytes.iter().map(|b| if *b == b'\r' { b'\n' } else { *b })),
            Coding::Utf16 { is_little } => {
                self.rest.extend_from_slice(bytes);
                let unit = |pair: &[u8]| {
                    let pair = [pair[0], pair[1]];
                    if is_little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) }
                };
                let units = self.rest.chunks_exact(2).map(unit);
                let is_half = units.clone().next_back().is_some_and(|last| (0xd800..0xdc00).contains(&last));
                let whole = units.len() - usize::from(is_half);
                let text =
                    char::decode_utf16(units.take(whole)).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
                // The mark before the text is none of it.
                let text: String = text.filter(|c| *c != '\u{feff}').collect();
                self.ready.extend_from_slice(text.as_bytes());
                self.rest.drain(..2 * whole);
            }
        }
    }
}

impl<R: Read> Read for Plain<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut bytes = [0; 8192];
        while self.at == self.ready.len() {
            match self.source.read(&mut bytes)? {
                0 => return Ok(0),
                read => self.take(&bytes[..read]),
            }
        }
        let many = out.len().min(self.ready.len() - self.at);
        out[..many].copy_from_slice(&self.ready[self.at..self.at + many]);
        self.at += many;
        Ok(many)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_other_systems_is_the_same_text_however_it_is_cut() {
        let text = "time [µs],gx [°/s] 😀\n0,1\n".repeat(20);
        let bytes = |is_little: bool| -> Vec<u8> {
            let unit = |u: u16| if is_little { u.to_le_bytes() } else { u.to_be_bytes() };
            text.encode_utf16().flat_map(unit).collect()
        };
        let (little, big) = (bytes(true), bytes(false));
        let returns = text.replace('\n', "\r").into_bytes();
        for raw in [[&b"\xff\xfe"[..], &little].concat(), [&b"\xfe\xff"[..], &big].concat(), returns] {
            let coding = Coding::of(&raw).unwrap();
            for size in [1, 3, 8192] {
                let parts = raw
                    .chunks(size)
                    .fold(Box::new(io::empty()) as Box<dyn Read>, |all, part| Box::new(all.chain(part)));
                let mut read = String::new();
                Plain::new(parts, coding).read_to_string(&mut read).unwrap();
                assert_eq!(read, text);
            }
        }
        let ascii: Vec<u8> = "time,gx\n0,1\n".repeat(10).encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(Coding::of(&ascii), Some(Coding::Utf16 { is_little: true }));
        assert_eq!(Coding::of(text.as_bytes()), None);
        assert_eq!(Coding::of(&[0; 100]), None);
    }
}
