//! ROS 1 bags, format 2.0, from front to back: the index is not needed, so a bag that was never closed reads like any other.
//!
//! Source: wiki.ros.org/Bags/Format/2.0. A record is a header and data, each behind its length; a header is fields `name=value`, each behind
//! its length. Of the records, chunks, connections and messages count here.

use crate::bytes::Bytes;
use crate::decompress::{LARGEST, decompress};
use crate::fields::Encoding;
use crate::messages::Messages;
use std::io::{self, Read};

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// A record's header is not larger than this: a connection's holds a topic and a few names.
const LARGEST_HEADER: u32 = 1 << 20;

const MESSAGE: u8 = 0x02;
const BAG_HEADER: u8 = 0x03;
const CHUNK: u8 = 0x05;
const CONNECTION: u8 = 0x07;

/// Reads a whole bag; returns what was wrong where it ended early.
///
/// # Errors
/// The operating system's; a damaged bag is none.
pub(crate) fn read(source: impl Read, topics: &mut dyn Messages) -> io::Result<Option<String>> {
    let mut source = CountedReader { inner: source, at: 0 };
    let Some(magic) = source.exactly(MAGIC.len() as u64)? else {
        return Ok(Some("ends within its first line".to_owned()));
    };
    if magic != MAGIC {
        return Ok(Some("does not begin as a bag does".to_owned()));
    }
    // Where the bag's header says that its index begins; 0 while it is being recorded.
    let mut index = None;
    loop {
        if topics.is_done() {
            return Ok(None);
        }
        let begin = source.at;
        let cut = || Some(format!("cut off in the record at byte {begin}"));
        let header_length = match source.up_to(4)? {
            length if length.is_empty() => {
                return Ok(match index {
                    Some(0) => {
                        Some("was never closed: it has no index (recording was interrupted)".to_owned())
                    }
                    Some(index) if begin < index => Some(format!("cut off at byte {begin}")),
                    _ => None,
                });
            }
            length => match Bytes::new(&length).u32() {
                Some(length) => length,
                None => return Ok(cut()),
            },
        };
        if header_length > LARGEST_HEADER {
            return Ok(Some(format!(
                "no record at byte {begin}: its header would have {header_length} bytes"
            )));
        }
        let Some(header) = source.exactly(u64::from(header_length))? else {
            return Ok(cut());
        };
        let Some(length) = source.exactly(4)?.and_then(|l| Bytes::new(&l).u32()) else {
            return Ok(cut());
        };
        let Some(fields) = Fields::new(&header) else {
            return Ok(Some(format!("no record at byte {begin}: its header has no fields")));
        };
        match fields.op() {
            Some(CHUNK) => {
                let packed = source.up_to(u64::from(length))?;
                let is_whole = packed.len() as u64 == u64::from(length);
                let Some(name) = fields.text("compression") else {
                    return Ok(Some(format!("the chunk at byte {begin} lacks the name of its compression")));
                };
                let size = fields.u32("size").map_or(LARGEST, u64::from);
                let plain = decompress(&name, packed, size, topics.budget());
                let inside = records(&plain.bytes, topics);
                if !is_whole {
                    return Ok(Some(format!("cut off in the chunk at byte {begin}")));
                }
                if let Some(damage) = plain.damage.or(inside) {
                    return Ok(Some(format!("the chunk at byte {begin}: {damage}")));
                }
            }
            op => {
                let Some(data) = source.exactly(u64::from(length))? else {
                    return Ok(cut());
                };
                if op == Some(BAG_HEADER) {
                    index = fields.u64("index_pos");
                }
                if record(op, &fields, &data, topics).is_none() {
                    return Ok(Some(format!("the record at byte {begin} lacks a field")));
                }
            }
        }
    }
}

/// The records in a chunk; returns what is wrong where they end early.
fn records(bytes: &[u8], topics: &mut dyn Messages) -> Option<String> {
    let mut bytes = Bytes::new(bytes);
    while !bytes.is_empty() && !topics.is_done() {
        let parts = (|| Some((bytes.counted()?, bytes.counted()?)))();
        let Some((header, data)) = parts else {
            return Some("ends within a record".to_owned());
        };
        let Some(fields) = Fields::new(header) else {
            return Some("holds what is no record".to_owned());
        };
        if record(fields.op(), &fields, data, topics).is_none() {
            return Some("holds a record that lacks a field".to_owned());
        }
    }
    None
}

/// A connection or a message; `None` where a field is missing that it must have.
fn record(op: Option<u8>, fields: &Fields<'_>, data: &[u8], topics: &mut dyn Messages) -> Option<()> {
    match op {
        Some(CONNECTION) => {
            let kind = Fields::new(data)?.text("type")?;
            topics.declare(fields.u32("conn")?, &fields.text("topic")?, &kind, Ok(Encoding::Ros1));
        }
        Some(MESSAGE) => {
            // Seconds, then nanoseconds.
            let time = fields.u64("time")?;
            let received = i64::from(time as u32) * 1_000_000_000 + i64::from((time >> 32) as u32);
            topics.message(fields.u32("conn")?, received, data);
        }
        _ => {}
    }
    Some(())
}

/// A header's fields.
#[derive(Debug, Clone, Copy)]
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// `None` where the bytes are no fields.
    fn new(header: &'a [u8]) -> Option<Self> {
        let mut bytes = Bytes::new(header);
        while !bytes.is_empty() {
            let field = bytes.counted()?;
            field.contains(&b'=').then_some(())?;
        }
        Some(Self(header))
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        let mut bytes = Bytes::new(self.0);
        while let Some(field) = bytes.counted() {
            if let Some(value) = field.strip_prefix(name.as_bytes()).and_then(|rest| rest.strip_prefix(b"="))
            {
                return Some(value);
            }
        }
        None
    }

    fn op(&self) -> Option<u8> {
        Bytes::new(self.get("op")?).u8()
    }

    fn u32(&self, name: &str) -> Option<u32> {
        Bytes::new(self.get(name)?).u32()
    }

    fn u64(&self, name: &str) -> Option<u64> {
        Bytes::new(self.get(name)?).u64()
    }

    fn text(&self, name: &str) -> Option<String> {
        self.get(name).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}

/// Bytes of a stream and how many were taken.
pub(crate) struct CountedReader<R> {
    pub(crate) inner: R,
    pub(crate) at: u64,
}

impl<R: Read> CountedReader<R> {
    /// As many of `count` bytes as there are; room is made as they come, not as a damaged length says.
    pub(crate) fn up_to(&mut self, count: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(count.min(1 << 16) as usize);
        self.inner.by_ref().take(count).read_to_end(&mut bytes)?;
        self.at += bytes.len() as u64;
        Ok(bytes)
    }

    /// `count` bytes, or `None` where there are fewer.
    pub(crate) fn exactly(&mut self, count: u64) -> io::Result<Option<Vec<u8>>> {
        let bytes = self.up_to(count)?;
        Ok((bytes.len() as u64 == count).then_some(bytes))
    }
}
