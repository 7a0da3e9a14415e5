//! An MCAP file as it grows: chunks of about a megabyte with their index, not compressed, as rosbag2 records them unless told otherwise.

use ::mcap::records::MessageHeader;
use ::mcap::write::NoSeek;
use ::mcap::{McapError, WriteOptions, Writer};
use dpn_core::Stamp;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// A log being written; [`McapLog::finish`] ends it.
pub struct McapLog<W: Write> {
    pub(super) inner: Writer<NoSeek<W>>,
    /// Messages written by channel.
    counts: BTreeMap<u16, u32>,
}

impl<W: Write> McapLog<W> {
    /// Begins a file; `profile` is `ros1`, `ros2` or empty.
    ///
    /// # Errors
    /// The writer's.
    pub fn new(out: W, profile: &str) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .disable_seeking(true)
            .profile(profile)
            .library(concat!("dpn ", env!("CARGO_PKG_VERSION")));
        let inner = options.create(NoSeek::new(out)).map_err(from_mcap)?;
        Ok(Self { inner, counts: BTreeMap::new() })
    }

    /// A topic whose messages are of the type `schema` (name, encoding, text); returns its number.
    ///
    /// # Errors
    /// The writer's; more than 65,535 of them.
    pub fn channel(
        &mut self,
        topic: &str,
        encoding: &str,
        (name, kind, text): (&str, &str, &str),
    ) -> io::Result<u16> {
        let schema = self.inner.add_schema(name, kind, text.as_bytes()).map_err(from_mcap)?;
        self.inner.add_channel(schema, topic, encoding, &BTreeMap::new()).map_err(from_mcap)
    }

    /// A topic of JSON objects, for whose type [JSON Schema](https://json-schema.org) text is given; returns its number.
    ///
    /// # Errors
    /// As [`McapLog::channel`].
    pub fn json_channel(&mut self, topic: &str, name: &str, schema: &str) -> io::Result<u16> {
        self.channel(topic, "json", (name, "jsonschema", schema))
    }

    /// A message of the time `t`.
    ///
    /// # Errors
    /// The writer's; a time before 1970.
    pub fn message(&mut self, channel: u16, t: Stamp, data: &[u8]) -> io::Result<()> {
        let time = u64::try_from(t.ns()).map_err(|_| unwritable(t))?;
        let count = self.counts.entry(channel).or_default();
        let header =
            MessageHeader { channel_id: channel, sequence: *count, log_time: time, publish_time: time };
        *count = count.wrapping_add(1);
        self.inner.write_to_known_channel(&header, data).map_err(from_mcap)
    }

    /// Writes what is left, index and summary.
    ///
    /// # Errors
    /// The writer's.
    pub fn finish(mut self) -> io::Result<()> {
        self.inner.finish().map(|_| ()).map_err(from_mcap)
    }
}

/// A log's time has no sign there.
pub(super) fn unwritable(t: Stamp) -> io::Error {
    io::Error::new(
        io::ErrorKind::InvalidInput,
        format!(
            "the stamp {t} is none that a ROS message or an MCAP file can have: they begin in 1970 and end in 2038"
        ),
    )
}

/// The system's own error where there is one.
pub(super) fn from_mcap(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
