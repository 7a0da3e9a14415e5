//! A log with the covariances of its IMU's messages filled in, and everything else as it was.
//!
//! An MCAP file, packed or not, or a rosbag2 folder of them is copied record by record into one file: schemas, channels with their metadata (quality of
//! service), messages, attachments. Of the IMU's messages, in whatever representation they are, the 18 doubles of two covariances are replaced in
//! place. Chunks are cut anew and not compressed. A damaged file is copied up to its damage, as it is read.

use super::mcap_log::{McapLog, from_mcap};
use crate::bag::headed;
use crate::budget::Budget;
use crate::bytes::Bytes;
use crate::fields::Encoding;
use crate::imu_message::{decode, fill_covariances};
use crate::mcap::{self, ATTACHMENT, CHANNEL, HEADER, MESSAGE, METADATA, RecordSink, SCHEMA};
use crate::packed::{Packing, Unpacked};
use crate::rosbag2::bags;
use crate::{Kind, LogError};
use ::mcap::Attachment;
use ::mcap::records::{MessageHeader, Metadata};
use dpn_core::{ImuNoise, Sensor, Stamp};
use dpn_io::{IoError, atomic_write, printable};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

/// What became of the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CovarianceCopy {
    /// The IMU's whose covariances were filled in.
    pub filled: u64,
    /// The IMU's from before the noise was known: as they were.
    pub before: u64,
    /// The IMU's that are no `sensor_msgs/Imu`: as they were.
    pub undecodable: u64,
    /// All others.
    pub others: u64,
}

/// The MCAP files that a log of this kind consists of; `None` where it cannot be copied by record.
fn parts(path: &Path, kind: Kind) -> Result<Option<Vec<PathBuf>>, IoError> {
    match kind {
        Kind::Mcap if path.is_file() => Ok(Some(vec![path.to_path_buf()])),
        Kind::Rosbag2 if path.is_dir() => {
            let (files, _) = bags(path)?;
            let all = files.iter().all(|file| file.extension().is_some_and(|end| end == "mcap"));
            Ok((all && !files.is_empty()).then_some(files))
        }
        _ => Ok(None),
    }
}

/// Whether [`write_with_covariances`] can copy the log at `path`: MCAP in a file or in a rosbag2 folder.
///
/// # Errors
/// A folder that cannot be read.
pub fn is_copied(path: &Path, kind: Kind) -> Result<bool, LogError> {
    Ok(parts(path, kind)?.is_some())
}

/// Copies the log at `path` to the file `into`, with the variances of `noise` in the messages on `topic`: per sample \[(rad/s)^2, (m/s^2)^2\],
/// asked by each message's stamp. `most` as in [`crate::LogOptions::max_uncompressed`].
///
/// # Errors
/// A log that [`is_copied`] says no of, or that cannot be read; a file that cannot be written, and then none is.
pub fn write_with_covariances(
    path: &Path,
    kind: Kind,
    topic: &str,
    most: Option<u64>,
    into: &Path,
    mut noise: impl FnMut(Stamp) -> Option<ImuNoise>,
) -> Result<CovarianceCopy, LogError> {
    let files =
        parts(path, kind)?.ok_or_else(|| LogError::NoCopy { path: path.to_path_buf(), kind: kind.name() })?;
    let mut head = Head { profile: None, budget: Budget::new(most) };
    walk(&files[0], most, &mut head)?;
    let profile = head.profile.unwrap_or_default();
    let mut counts = CovarianceCopy::default();
    let mut unreadable = None;
    let written = atomic_write(into, |out| {
        let mut copy = Copy {
            out: McapLog::new(out, &profile)?,
            topic,
            noise: &mut noise,
            counts: CovarianceCopy::default(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            budget: Budget::new(most),
            fault: None,
        };
        for file in &files {
            // Each file of a bag has numbers of its own.
            copy.schemas.clear();
            copy.channels.clear();
            let read = walk(file, most, &mut copy);
            if let Some(fault) = copy.fault.take() {
                return Err(fault);
            }
            if let Err(error) = read {
                unreadable = Some(error);
                return Err(io::Error::other("the log cannot be read"));
            }
        }
        counts = copy.counts;
        copy.out.finish()
    });
    match unreadable {
        Some(error) => Err(error),
        None => Ok(written.map(|()| counts)?),
    }
}

/// A file's records, unpacked where it is packed; damage ends them, and was told when the log was read.
fn walk(file: &Path, most: Option<u64>, sink: &mut dyn RecordSink) -> Result<(), LogError> {
    let reading = |e| IoError::reading(file, e);
    let (head, source) = headed(File::open(file).map_err(reading)?, file)?;
    match Packing::of(&head) {
        None => mcap::walk(BufReader::new(source), sink).map_err(reading)?,
        Some(packing) => {
            mcap::walk(BufReader::new(Unpacked::new(packing, source, most)), sink).map_err(reading)?
        }
    };
    Ok(())
}

/// Takes the profile and no more.
struct Head {
    profile: Option<String>,
    budget: Budget,
}

impl RecordSink for Head {
    fn record(&mut self, op: u8, content: &[u8]) -> Option<()> {
        let profile = (op == HEADER).then(|| Bytes::new(content).text()).flatten();
        self.profile = Some(profile.unwrap_or_default());
        Some(())
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }

    fn is_done(&self) -> bool {
        self.profile.is_some()
    }
}

/// A channel of the source.
#[derive(Debug, Clone, Copy)]
struct Channel {
    /// Its number in the copy.
    number: u16,
    /// How its messages are written, where it is the IMU's.
    imu: Option<Encoding>,
}

struct Copy<'a, W: Write> {
    out: McapLog<W>,
    topic: &'a str,
    noise: &'a mut dyn FnMut(Stamp) -> Option<ImuNoise>,
    counts: CovarianceCopy,
    /// From the source's numbers to the copy's.
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, Channel>,
    budget: Budget,
    /// Why no more can be written.
    fault: Option<io::Error>,
}

impl<W: Write> RecordSink for Copy<'_, W> {
    fn record(&mut self, op: u8, content: &[u8]) -> Option<()> {
        let mut bytes = Bytes::new(content);
        let done = match op {
            SCHEMA => self.schema(&mut bytes)?,
            CHANNEL => self.channel(&mut bytes)?,
            MESSAGE => self.message(&mut bytes)?,
            ATTACHMENT => {
                let (log_time, create_time) = (bytes.u64()?, bytes.u64()?);
                let (name, media_type) = (bytes.text()?, bytes.text()?);
                let length = usize::try_from(bytes.u64()?).ok()?;
                let data = bytes.take(length)?.into();
                self.out
                    .inner
                    .attach(&Attachment { log_time, create_time, name, media_type, data })
                    .map_err(from_mcap)
            }
            METADATA => {
                let name = bytes.text()?;
                let metadata = pairs(&mut bytes)?;
                self.out.inner.write_metadata(&Metadata { name, metadata }).map_err(from_mcap)
            }
            _ => Ok(()),
        };
        if let Err(fault) = done {
            self.fault = Some(fault);
        }
        Some(())
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }

    fn is_done(&self) -> bool {
        self.fault.is_some()
    }
}

impl<W: Write> Copy<'_, W> {
    fn schema(&mut self, bytes: &mut Bytes<'_>) -> Option<io::Result<()>> {
        let (number, name, encoding) = (bytes.u16()?, bytes.text()?, bytes.text()?);
        let added = self.out.inner.add_schema(&name, &encoding, bytes.counted()?);
        Some(added.map_err(from_mcap).map(|new| {
            self.schemas.insert(number, new);
        }))
    }

    fn channel(&mut self, bytes: &mut Bytes<'_>) -> Option<io::Result<()>> {
        let (number, schema) = (bytes.u16()?, bytes.u16()?);
        let (topic, encoding) = (bytes.text()?, bytes.text()?);
        let metadata = pairs(bytes)?;
        // A channel without a schema has the number 0.
        let schema = self.schemas.get(&schema).copied().unwrap_or(0);
        let imu = (printable(&topic) == self.topic).then(|| Encoding::named(&encoding).ok()).flatten();
        let added = self.out.inner.add_channel(schema, &topic, &encoding, &metadata);
        Some(added.map_err(from_mcap).map(|number_there| {
            self.channels.insert(number, Channel { number: number_there, imu });
        }))
    }

    fn message(&mut self, bytes: &mut Bytes<'_>) -> Option<io::Result<()>> {
        let (channel, sequence) = (bytes.u16()?, bytes.u32()?);
        let (log_time, publish_time) = (bytes.u64()?, bytes.u64()?);
        // On no channel it is no message: readers pass it over.
        let Some(&Channel { number, imu }) = self.channels.get(&channel) else { return Some(Ok(())) };
        let data = match imu {
            Some(encoding) => self.filled(bytes.rest(), encoding, log_time),
            None => {
                self.counts.others += 1;
                Cow::Borrowed(bytes.rest())
            }
        };
        let header = MessageHeader { channel_id: number, sequence, log_time, publish_time };
        Some(self.out.inner.write_to_known_channel(&header, &data).map_err(from_mcap))
    }

    /// An IMU's message with its covariances, where they are known.
    fn filled<'d>(&mut self, data: &'d [u8], encoding: Encoding, log_time: u64) -> Cow<'d, [u8]> {
        let Ok(message) = decode(data, encoding) else {
            self.counts.undecodable += 1;
            return data.into();
        };
        let t = if message.stamped { message.sample.t } else { Stamp::from_ns(log_time.cast_signed()) };
        let Some(noise) = (self.noise)(t) else {
            self.counts.before += 1;
            return data.into();
        };
        let [gyro, accel] = [Sensor::Gyro, Sensor::Accel].map(|sensor| noise.of(sensor).map(|s| s * s));
        let mut data = data.to_vec();
        fill_covariances(&mut data, encoding, gyro, accel).expect("the message was decoded a moment ago");
        self.counts.filled += 1;
        data.into()
    }
}

/// A map of strings, its length in bytes before it.
fn pairs(bytes: &mut Bytes<'_>) -> Option<BTreeMap<String, String>> {
    let mut inside = Bytes::new(bytes.counted()?);
    let mut all = BTreeMap::new();
    while !inside.is_empty() {
        all.insert(inside.text()?, inside.text()?);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LogOptions, read_log};

    fn golden(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/bags").join(name)
    }

    /// Everything in a file: topic or schema's name, time, bytes.
    #[derive(Default)]
    struct All {
        topics: BTreeMap<u16, String>,
        messages: Vec<(String, u64, Vec<u8>)>,
        schemas: Vec<String>,
        budget: Option<Budget>,
    }

    impl RecordSink for All {
        fn record(&mut self, op: u8, content: &[u8]) -> Option<()> {
            let mut bytes = Bytes::new(content);
            match op {
                SCHEMA => {
                    bytes.u16()?;
                    self.schemas.push(format!("{} {}", bytes.text()?, bytes.text()?));
                }
                CHANNEL => {
                    let (number, _) = (bytes.u16()?, bytes.u16()?);
                    self.topics.insert(number, bytes.text()?);
                }
                MESSAGE => {
                    let (number, _) = (bytes.u16()?, bytes.u32()?);
                    let (log_time, _) = (bytes.u64()?, bytes.u64()?);
                    self.messages.push((self.topics[&number].clone(), log_time, bytes.rest().to_vec()));
                }
                _ => {}
            }
            Some(())
        }

        fn budget(&mut self) -> &mut Budget {
            self.budget.get_or_insert_with(|| Budget::new(None))
        }

        fn is_done(&self) -> bool {
            false
        }
    }

    fn all(file: &Path) -> All {
        let mut all = All::default();
        walk(file, None, &mut all).unwrap();
        all
    }

    fn noise(t: Stamp) -> Option<ImuNoise> {
        let after = t.ns() - 1_600_000_000_250_000_000;
        (after >= 20_000_000).then(|| ImuNoise::from_values([0.5, 0.25, 2.0], [0.125, 4.0, 1.0]).unwrap())
    }

    #[test]
    fn every_message_is_there_and_those_of_the_imu_differ_by_their_covariances_alone() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["plain.mcap", "lz4.mcap", "zstd.mcap", "big_endian.mcap", "ros1.mcap"] {
            let (from, into) = (golden(name), dir.path().join(name));
            let log = read_log(&from, &LogOptions::default()).unwrap();
            let topic = log.topic.clone().unwrap();
            let copied = write_with_covariances(&from, log.kind, &topic, None, &into, noise).unwrap();
            let (before, after) = (all(&from), all(&into));
            assert_eq!((copied.filled, copied.before, copied.undecodable), (10, 2, 0), "{name}");
            assert_eq!(copied.others as usize + 12, before.messages.len(), "{name}");
            assert_eq!(before.schemas, after.schemas, "{name}");
            assert_eq!(before.messages.len(), after.messages.len(), "{name}");
            let encoding = if name == "ros1.mcap" { Encoding::Ros1 } else { Encoding::Cdr };
            let mut seen = 0;
            for (old, new) in before.messages.iter().zip(&after.messages) {
                assert_eq!((&old.0, old.1), (&new.0, new.1), "{name}");
                let mut expected = old.2.clone();
                if old.0 == topic {
                    seen += 1;
                    if seen > 2 {
                        let (gyro, accel) = ([0.015625, 16.0, 1.0], [0.25, 0.0625, 4.0]);
                        fill_covariances(&mut expected, encoding, gyro, accel).unwrap();
                        assert_ne!(expected, old.2, "{name}");
                    }
                }
                assert_eq!(expected, new.2, "{name}");
            }
            let again = read_log(&into, &LogOptions::default()).unwrap();
            assert!(again.warnings().is_empty(), "{name}: {:?}", again.warnings());
            assert_eq!(again.recording.held().unwrap(), log.recording.held().unwrap(), "{name}");
        }
    }

    #[test]
    fn a_folder_of_mcap_becomes_one_file_and_other_bags_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let into = dir.path().join("a.mcap");
        let copied =
            write_with_covariances(&golden("mcap"), Kind::Rosbag2, "/imu0", None, &into, noise).unwrap();
        assert_eq!((copied.filled, copied.before, copied.others), (10, 2, 4));
        for (name, kind) in [("sqlite", Kind::Rosbag2), ("plain.bag", Kind::Rosbag1)] {
            let refused = write_with_covariances(&golden(name), kind, "/imu0", None, &into, noise);
            assert!(matches!(refused, Err(LogError::NoCopy { .. })), "{name}");
        }
    }

    #[test]
    fn samples_alone_are_read_back_with_their_covariances() {
        let dir = tempfile::tempdir().unwrap();
        let into = dir.path().join("imu.mcap");
        let recording =
            read_log(&golden("plain.bag"), &LogOptions::default()).unwrap().recording.held().unwrap();
        atomic_write(&into, |out| {
            let each = |take: &mut dyn FnMut(&dpn_core::ImuSample)| {
                recording.samples().iter().for_each(take);
                Ok(())
            };
            crate::write_imu_log(out, each, noise)
        })
        .unwrap();
        let log = read_log(&into, &LogOptions::default()).unwrap();
        assert_eq!((log.topic.as_deref(), log.warnings()), (Some("/imu"), Vec::new()));
        assert_eq!(log.recording.held().unwrap(), recording);
        // Filling in the same variances again changes nothing.
        let again = dir.path().join("again.mcap");
        write_with_covariances(&into, Kind::Mcap, "/imu", None, &again, noise).unwrap();
        assert!(all(&into).messages == all(&again).messages);
    }

    #[test]
    fn a_damaged_log_is_copied_up_to_its_damage() {
        let dir = tempfile::tempdir().unwrap();
        let bytes = std::fs::read(golden("plain.mcap")).unwrap();
        let (cut, into) = (dir.path().join("cut.mcap"), dir.path().join("into.mcap"));
        for length in (0..bytes.len()).step_by(97) {
            std::fs::write(&cut, &bytes[..length]).unwrap();
            let copied = write_with_covariances(&cut, Kind::Mcap, "/imu0", None, &into, noise).unwrap();
            assert!(copied.filled + copied.before + copied.others <= 16);
            assert_eq!(all(&cut).messages.len(), all(&into).messages.len(), "{length}");
        }
    }
}
