//! A log that is packed as a whole: gzip, zstd, xz or bzip2 around any kind, unpacked as it is read.
//!
//! What comes out is held to the [`Budget`] of bags' chunks, and what a head asks for as a window to a fixed size.

use crate::budget::Budget;
use crate::decompress::window;
use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::rc::Rc;

/// A window or dictionary may be as large as this \[bytes\]; zstd's levels up to 19 and xz's up to 8 want no more.
const WINDOW: u64 = 33 << 20;

/// How a file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    Gzip,
    Zstd,
    Xz,
    Bzip2,
}

impl Packing {
    /// By a file's first bytes.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        match head {
            [0x1f, 0x8b, ..] => Some(Self::Gzip),
            [0x28, 0xb5, 0x2f, 0xfd, ..] => Some(Self::Zstd),
            [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Some(Self::Xz),
            [b'B', b'Z', b'h', b'1'..=b'9', 0x31, 0x41, 0x59, 0x26, ..] => Some(Self::Bzip2),
            _ => None,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zstd => "zstd",
            Self::Xz => "xz",
            Self::Bzip2 => "bzip2",
        }
    }
}

/// The plain bytes; damage and a spent budget are an early end, and [`Unpacked::damage`] says so.
pub(crate) struct Unpacked<'a> {
    decoder: Box<dyn Read + 'a>,
    name: &'static str,
    /// Packed bytes taken since the last look.
    taken: Rc<Cell<usize>>,
    budget: Budget,
    damage: Option<String>,
}

impl<'a> Unpacked<'a> {
    /// With the caller's own limit to all that comes out, where there is one.
    pub(crate) fn new(packing: Packing, source: impl Read + 'a, most: Option<u64>) -> Self {
        let taken = Rc::new(Cell::new(0));
        let source = BufReader::new(Counted { inner: source, taken: Rc::clone(&taken) });
        let window = most.unwrap_or(WINDOW).max(WINDOW);
        let decoder: Box<dyn Read + 'a> = match packing {
            Packing::Gzip => Box::new(flate2::bufread::MultiGzDecoder::new(source)),
            Packing::Bzip2 => Box::new(bzip2::bufread::MultiBzDecoder::new(source)),
            Packing::Zstd => Box::new(Frames { source: Some(source), frame: None, window }),
            Packing::Xz => {
                let most_kb = u32::try_from(window >> 10).unwrap_or(u32::MAX);
                Box::new(lzma_rust2::XzReader::new_mem_limit(source, true, most_kb))
            }
        };
        Self { decoder, name: packing.name(), taken, budget: Budget::new(most), damage: None }
    }

    /// What was wrong where the bytes ended early.
    pub(crate) fn damage(self) -> Option<String> {
        self.damage
    }
}

impl Read for Unpacked<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.damage.is_some() || buffer.is_empty() {
            return Ok(0);
        }
        match self.decoder.read(buffer) {
            Ok(read) => {
                let room = self.budget.open(self.taken.take());
                if read as u64 > room {
                    self.damage = Some(self.budget.exceeded());
                    return Ok(0);
                }
                self.budget.unpacked(read);
                Ok(read)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => {
                self.damage = Some(match error.kind() {
                    io::ErrorKind::UnexpectedEof => format!("its {} data is cut off", self.name),
                    // Some decoders tell their own fields behind the words.
                    _ => {
                        let words = error.to_string();
                        let words =
                            words.split(['(', '{']).next().expect("a split has a first part").trim_end();
                        format!("bad {} data: {}", self.name, dpn_io::printable(words))
                    }
                });
                Ok(0)
            }
        }
    }
}

/// Counts what is taken.
struct Counted<R> {
    inner: R,
    taken: Rc<Cell<usize>>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.taken.set(self.taken.get() + read);
        Ok(read)
    }
}

type Frame<R> = ruzstd::decoding::StreamingDecoder<R, ruzstd::decoding::FrameDecoder>;

/// zstd's frames one after the other: parallel compressors write many.
struct Frames<R: Read> {
    /// Between two frames.
    source: Option<R>,
    frame: Option<Frame<R>>,
    window: u64,
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if let Some(frame) = &mut self.frame {
                match frame.read(buffer)? {
                    0 => self.source = self.frame.take().map(Frame::into_inner),
                    read => return Ok(read),
                }
            }
            let Some(mut source) = self.source.take() else { return Ok(0) };
            let head = source.fill_buf()?;
            if head.is_empty() {
                return Ok(0);
            }
            if window(head) > self.window {
                let text = format!("a frame wants a window of {} MB", window(head) >> 20);
                return Err(io::Error::new(io::ErrorKind::InvalidData, text));
            }
            self.frame = Some(Frame::new(source).map_err(io::Error::other)?);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn all(packing: Packing, packed: &[u8], most: Option<u64>) -> (Vec<u8>, Option<String>) {
        let mut unpacked = Unpacked::new(packing, packed, most);
        let mut bytes = Vec::new();
        unpacked.read_to_end(&mut bytes).unwrap();
        (bytes, unpacked.damage())
    }

    #[test]
    fn what_is_cut_off_or_damaged_gives_all_before_it() {
        let plain: Vec<u8> = (0..200_000u32).flat_map(|i| i.wrapping_mul(i).to_le_bytes()).collect();
        let packed = gzip(&plain);
        assert_eq!(all(Packing::Gzip, &packed, None), (plain.clone(), None));
        let (bytes, damage) = all(Packing::Gzip, &packed[..packed.len() / 2], None);
        assert!(!bytes.is_empty() && plain.starts_with(&bytes));
        assert_eq!(damage.unwrap(), "its gzip data is cut off");
        let twice = [packed.clone(), packed].concat();
        assert_eq!(all(Packing::Gzip, &twice, None).0.len(), 2 * plain.len());
    }

    #[test]
    fn a_bomb_is_cut_off_unless_a_limit_is_given() {
        let bomb = gzip(&vec![0; 40 << 20]);
        let (bytes, damage) = all(Packing::Gzip, &bomb, None);
        assert!(bytes.len() < 35 << 20 && damage.unwrap().contains("--max-uncompressed"));
        assert_eq!(all(Packing::Gzip, &bomb, Some(1 << 30)).1, None);
        let (_, damage) = all(Packing::Zstd, b"\x28\xb5\x2f\xfd\x00\x80\x03\x00\x10\x00", None);
        assert_eq!(damage.unwrap(), "bad zstd data: a frame wants a window of 64 MB");
    }
}
