//! One of rosbag2's SQLite files: tables `topics` and `messages`.

use crate::decompress::{LARGEST, decompress};
use crate::imu_message::Encoding;
use crate::topics::Topics;
use rusqlite::{Connection, OpenFlags, params};
use std::path::Path;

/// Reads a whole file in the order of writing; returns what was wrong where it ended early.
pub(crate) fn read(path: &Path, topics: &mut Topics) -> Option<String> {
    match all(path, topics) {
        Ok(damage) => damage,
        Err(error) => Some(error.to_string()),
    }
}

fn all(path: &Path, topics: &mut Topics) -> rusqlite::Result<Option<String>> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    let mut wanted = Vec::new();
    {
        let mut statement = connection.prepare("SELECT id, name, type, serialization_format FROM topics")?;
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            let (id, name): (i64, String) = (row.get(0)?, row.get(1)?);
            let (kind, format): (String, String) = (row.get(2)?, row.get(3)?);
            let Ok(number) = u32::try_from(id) else { continue };
            if topics.declare(number, &name, &kind, Encoding::named(&format)) {
                wanted.push((id, number));
            }
        }
    }
    let mut statement = connection.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = statement.query(params![])?;
    let mut count = 0u64;
    loop {
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) => return Ok(None),
            Err(error) => return Ok(Some(format!("damaged after {count} messages: {error}"))),
        };
        count += 1;
        let Ok(id) = row.get::<_, i64>(0) else { continue };
        let Some((_, number)) = wanted.iter().find(|(known, _)| *known == id) else {
            continue;
        };
        let (Ok(time), Ok(data)) = (row.get::<_, i64>(1), row.get_ref(2)) else { continue };
        let Ok(data) = data.as_blob() else { continue };
        // Compressed message by message; no CDR begins like this.
        let name = match data.first_chunk::<4>() {
            Some(b"\x28\xb5\x2f\xfd") => "zstd",
            Some(b"\x04\x22\x4d\x18") => "lz4",
            _ => {
                topics.message(*number, time, data);
                continue;
            }
        };
        let plain = decompress(name, data.to_vec(), LARGEST);
        if let Some(damage) = plain.damage {
            return Ok(Some(format!("damaged after {} messages: {damage}", count - 1)));
        }
        topics.message(*number, time, &plain.bytes);
    }
}
