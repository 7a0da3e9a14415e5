//! One of rosbag2's SQLite files: tables `topics` and `messages`.

use crate::LogError;
use crate::decompress::{LARGEST, decompress};
use crate::fields::Encoding;
use crate::messages::Messages;
use dpn_io::{IoError, printable, scratch_file};
use rusqlite::{Connection, OpenFlags, params};
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

/// Views under the names of rosbag2's tables, and columns of them that are computed.
const MADE: &str = "SELECT (SELECT count(*) FROM sqlite_schema WHERE name IN ('topics', 'messages') AND type <> 'table') \
    + (SELECT count(*) FROM pragma_table_xinfo('topics') WHERE hidden > 0) \
    + (SELECT count(*) FROM pragma_table_xinfo('messages') WHERE hidden > 0)";

/// Reads a whole file in the order of writing; returns what was wrong where it ended early.
///
/// # Errors
/// None: what is wrong with a database is damage.
pub(crate) fn read(path: &Path, topics: &mut dyn Messages) -> Result<Option<String>, LogError> {
    Ok(match all(path, topics) {
        Ok(damage) => damage,
        Err(error) => Some(printable(&error.to_string())),
    })
}

/// The same of one that comes through a pipe: its reader must seek, so it is copied to a temporary file first.
///
/// # Errors
/// A source that cannot be read, a file that cannot be written.
pub(crate) fn read_stream(
    mut source: impl Read,
    path: &Path,
    topics: &mut dyn Messages,
) -> Result<Option<String>, LogError> {
    let reading = |e| IoError::reading(path, e);
    let mut copy = scratch_file().map_err(reading)?;
    std::io::copy(&mut source, &mut copy).map_err(reading)?;
    read(copy.path(), topics)
}

fn all(path: &Path, topics: &mut dyn Messages) -> rusqlite::Result<Option<String>> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    // A view or a generated column is a program that a file brings along; rosbag2 writes neither.
    let made: i64 = connection.query_row(MADE, [], |row| row.get(0))?;
    if made > 0 {
        return Ok(Some(
            "its tables are made by views or generated columns, as no rosbag2 writes them".to_owned(),
        ));
    }
    let mut wanted = HashMap::new();
    {
        let mut statement = connection.prepare("SELECT id, name, type, serialization_format FROM topics")?;
        let mut rows = statement.query([])?;
        // Numbers of our own: an id of a damaged table may be any.
        let mut number = 0;
        while let Some(row) = rows.next()? {
            let (id, name): (i64, String) = (row.get(0)?, row.get(1)?);
            let (kind, format): (String, String) = (row.get(2)?, row.get(3)?);
            number += 1;
            if topics.declare(number, &name, &kind, Encoding::named(&format)) {
                wanted.insert(id, number);
            }
        }
    }
    let mut statement = connection.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = statement.query(params![])?;
    let (mut count, mut unreadable) = (0u64, 0u64);
    loop {
        if topics.is_done() {
            return Ok(None);
        }
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) if unreadable == 0 => return Ok(None),
            Ok(None) => return Ok(Some(format!("{unreadable} of its {count} rows hold no message"))),
            Err(error) => {
                let error = printable(&error.to_string());
                return Ok(Some(format!("damaged after {count} messages: {error}")));
            }
        };
        count += 1;
        // The bytes of messages that nobody wants, images above all, are not even fetched.
        let cells = (|| Some((row.get::<_, i64>(0).ok()?, row.get::<_, i64>(1).ok()?)))();
        let number = cells.map(|(id, _)| wanted.get(&id));
        if number == Some(None) {
            continue;
        }
        let data = row.get_ref(2).ok().and_then(|cell| cell.as_blob().ok());
        let (Some((_, time)), Some(Some(number)), Some(data)) = (cells, number, data) else {
            unreadable += 1;
            continue;
        };
        // Compressed message by message; no CDR begins like this.
        let name = match data.first_chunk::<4>() {
            Some(b"\x28\xb5\x2f\xfd") => "zstd",
            Some(b"\x04\x22\x4d\x18") => "lz4",
            _ => {
                topics.message(*number, time, data);
                continue;
            }
        };
        let plain = decompress(name, data.to_vec(), LARGEST, topics.budget());
        if let Some(damage) = plain.damage {
            return Ok(Some(format!("damaged after {} messages: {damage}", count - 1)));
        }
        topics.message(*number, time, &plain.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LogOptions;
    use crate::topics::Topics;

    #[test]
    fn tables_that_a_file_computes_are_refused_and_not_run() {
        let dir = tempfile::tempdir().unwrap();
        let found = |name: &str, sql: &str| {
            let path = dir.path().join(name);
            Connection::open(&path).unwrap().execute_batch(sql).unwrap();
            read(&path, &mut Topics::new(&LogOptions::default())).unwrap()
        };
        let messages = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);";
        let topics = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);";
        // A view without an end, and a column that makes a gigabyte a row.
        let endless = "CREATE VIEW topics AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) \
            SELECT i AS id, 'a' AS name, 'b' AS type, 'cdr' AS serialization_format FROM n;";
        let wide = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data AS (zeroblob(1000000000)));";
        let made =
            Some("its tables are made by views or generated columns, as no rosbag2 writes them".to_owned());
        assert_eq!(found("endless", &format!("{messages}{endless}")), made);
        assert_eq!(found("wide", &format!("{topics}{wide}")), made);
        assert_eq!(found("sound", &format!("{topics}{messages}")), None);
        assert_eq!(
            found("other", "CREATE TABLE a(b);").as_deref().map(|e| e.contains("no such table: topics")),
            Some(true)
        );
    }
}
