//! Text as other systems write it, as lines of UTF-8: UTF-16, which Windows' shell makes of what it is given, and lines that end with a carriage return alone.

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;
use std::io::{self, Read};

/// What is to be done with the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    /// UTF-16, its lower byte first or last.
    Utf16(&'static Encoding),
    /// Lines end with a carriage return.
    Returns,
}

impl Coding {
    /// By the first bytes; `None` where they are as they should be.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        let is_zero = |first: usize| head.iter().skip(first).step_by(2).take(32).all(|byte| *byte == 0);
        match head {
            [0xff, 0xfe, ..] => Some(Self::Utf16(UTF_16LE)),
            [0xfe, 0xff, ..] => Some(Self::Utf16(UTF_16BE)),
            _ if head.len() < 64 => None,
            _ if is_zero(1) && !is_zero(0) => Some(Self::Utf16(UTF_16LE)),
            _ if is_zero(0) && !is_zero(1) => Some(Self::Utf16(UTF_16BE)),
            _ if head.contains(&b'\r') && !head.contains(&b'\n') => Some(Self::Returns),
            _ => None,
        }
    }

    /// `source` as lines of UTF-8.
    pub(crate) fn plain<'a>(self, source: impl Read + 'a) -> Box<dyn Read + 'a> {
        match self {
            Self::Utf16(encoding) => {
                Box::new(DecodeReaderBytesBuilder::new().encoding(Some(encoding)).build(source))
            }
            Self::Returns => Box::new(Returns(source)),
        }
    }
}

/// A source whose lines end with a carriage return.
struct Returns<R>(R);

impl<R: Read> Read for Returns<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let read = self.0.read(out)?;
        out[..read].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(read)
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
                coding.plain(parts).read_to_string(&mut read).unwrap();
                assert_eq!(read, text);
            }
        }
        let ascii: Vec<u8> = "time,gx\n0,1\n".repeat(10).encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(Coding::of(&ascii), Some(Coding::Utf16(UTF_16LE)));
        assert_eq!(Coding::of(text.as_bytes()), None);
        assert_eq!(Coding::of(&[0; 100]), None);
    }
}
