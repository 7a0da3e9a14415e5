//! MCAP files from front to back; the summary at the end is not needed.
//!
//! Source: mcap.dev/spec, version 0. A record is an opcode, a length of 64 bits, content. Of the records, schemas, channels, messages and
//! chunks count here; a chunk's checksum is held against its content.

use crate::budget::Budget;
use crate::bytes::Bytes;
use crate::decompress::{LARGEST, decompress};
use crate::fields::Encoding;
use crate::messages::Messages;
use crate::rosbag1::CountedReader;
use std::collections::BTreeMap;
use std::io::{self, Read};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
#[cfg(feature = "write")]
pub(crate) const HEADER: u8 = 0x01;
pub(crate) const SCHEMA: u8 = 0x03;
pub(crate) const CHANNEL: u8 = 0x04;
pub(crate) const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
#[cfg(feature = "write")]
pub(crate) const ATTACHMENT: u8 = 0x09;
#[cfg(feature = "write")]
pub(crate) const METADATA: u8 = 0x0c;
const DATA_END: u8 = 0x0f;

/// Takes a file's records in its order, those in chunks one by one.
pub(crate) trait RecordSink {
    /// One record; `None` when it is too short to be one.
    fn record(&mut self, op: u8, content: &[u8]) -> Option<()>;

    /// What the file may unpack to.
    fn budget(&mut self) -> &mut Budget;

    /// Whether nothing more is wanted.
    fn is_done(&self) -> bool;
}

/// Reads a whole file; returns what was wrong where it ended early.
///
/// # Errors
/// The operating system's; a damaged file is none.
pub(crate) fn read(source: impl Read, topics: &mut dyn Messages) -> io::Result<Option<String>> {
    walk(source, &mut Reader { schemas: BTreeMap::new(), topics })
}

/// The same for all of the file's records before its summary.
///
/// # Errors
/// As [`read`].
pub(crate) fn walk(source: impl Read, sink: &mut dyn RecordSink) -> io::Result<Option<String>> {
    let mut source = CountedReader { inner: source, at: 0 };
    let Some(magic) = source.exactly(MAGIC.len() as u64)? else {
        return Ok(Some("ends within its first line".to_owned()));
    };
    if magic != MAGIC {
        return Ok(Some("does not begin as an MCAP file does".to_owned()));
    }
    loop {
        if sink.is_done() {
            return Ok(None);
        }
        let begin = source.at;
        let head = source.up_to(9)?;
        let mut bytes = Bytes::new(&head);
        let (Some(op), Some(length)) = (bytes.u8(), bytes.u64()) else {
            let words = if head.is_empty() {
                "was never closed (recording was interrupted)".to_owned()
            } else {
                format!("cut off at byte {begin}")
            };
            return Ok(Some(words));
        };
        if op == DATA_END {
            return Ok(None);
        }
        if op == 0 || length > 2 * LARGEST {
            return Ok(Some(format!("no record at byte {begin}")));
        }
        let content = source.up_to(length)?;
        let is_whole = content.len() as u64 == length;
        if op == CHUNK {
            let damage = chunk(&content, is_whole, sink);
            if !is_whole {
                return Ok(Some(format!("cut off in the chunk at byte {begin}")));
            }
            if let Some(damage) = damage {
                return Ok(Some(format!("the chunk at byte {begin}: {damage}")));
            }
            continue;
        }
        if !is_whole {
            return Ok(Some(format!("cut off in the record at byte {begin}")));
        }
        if sink.record(op, &content).is_none() {
            return Ok(Some(format!("the record at byte {begin} is too short")));
        }
    }
}

/// A chunk's records; returns what is wrong with it.
fn chunk(content: &[u8], is_whole: bool, sink: &mut dyn RecordSink) -> Option<String> {
    let mut bytes = Bytes::new(content);
    let header = (|| {
        let _times = bytes.take(16)?;
        Some((bytes.u64()?, bytes.u32()?, bytes.text()?, bytes.u64()?))
    })();
    let Some((size, sum, compression, length)) = header else {
        return Some("its header is cut off".to_owned());
    };
    let packed = bytes.rest();
    let packed = &packed[..packed.len().min(usize::try_from(length).unwrap_or(usize::MAX))];
    let plain = decompress(&compression, packed.to_vec(), size, sink.budget());
    if is_whole && plain.damage.is_none() && sum != 0 && crc32fast::hash(&plain.bytes) != sum {
        return Some("its content does not have its checksum".to_owned());
    }
    let mut records = Bytes::new(&plain.bytes);
    while !records.is_empty() && !sink.is_done() {
        let parts = (|| {
            let op = records.u8()?;
            let length = records.u64()?;
            Some((op, records.take(usize::try_from(length).ok()?)?))
        })();
        let Some((op, content)) = parts else {
            return plain.damage.or_else(|| Some("ends within a record".to_owned()));
        };
        if sink.record(op, content).is_none() {
            return Some("holds a record that is too short".to_owned());
        }
    }
    plain.damage
}

/// Hands messages on.
struct Reader<'a> {
    /// Schemas' names by their numbers.
    schemas: BTreeMap<u16, String>,
    topics: &'a mut dyn Messages,
}

impl RecordSink for Reader<'_> {
    fn record(&mut self, op: u8, content: &[u8]) -> Option<()> {
        let mut bytes = Bytes::new(content);
        match op {
            SCHEMA => {
                let number = bytes.u16()?;
                self.schemas.insert(number, bytes.text()?);
            }
            CHANNEL => {
                let (number, schema) = (bytes.u16()?, bytes.u16()?);
                let (topic, encoding) = (bytes.text()?, bytes.text()?);
                let kind = self.schemas.get(&schema).map_or("", String::as_str);
                self.topics.declare(u32::from(number), &topic, kind, Encoding::named(&encoding));
            }
            MESSAGE => {
                let channel = bytes.u16()?;
                let _sequence = bytes.u32()?;
                let logged = bytes.u64()?;
                let _published = bytes.u64()?;
                self.topics.message(u32::from(channel), logged.cast_signed(), bytes.rest());
            }
            _ => {}
        }
        Some(())
    }

    fn budget(&mut self) -> &mut Budget {
        self.topics.budget()
    }

    fn is_done(&self) -> bool {
        self.topics.is_done()
    }
}
