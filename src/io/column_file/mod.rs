//! Columns of numbers in one file, each with its checksum: what thousands of processes read without parsing a digit.
//!
//! The container is safetensors, which NumPy and PyTorch read by name. What it lacks stands as JSON under the single metadata key `"dpn"` (several would
//! come in any order, and the same columns shall be the same bytes): `{"format", "version", "sha256", "body"}`, where `body` is the text whose checksum is
//! `sha256`: `{"sums": {column: SHA-256 of its bytes}, "content": whatever the format says of itself}`.
//!
//! Opening reads the header alone. A column is read when asked for, and held to its checksum each time; nothing is mapped into memory, for a file that
//! shrinks under a map is undefined behaviour.

mod error;
mod read;
mod write;

pub use error::ColumnFileError;
pub use read::ColumnFile;
pub use write::{Column, to_bytes, write};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The metadata key the description stands under.
const KEY: &str = "dpn";

/// What a kind of column file is called, and the version of its layout that is written and read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Its name in the file and for people: `data pack`.
    pub name: &'static str,
    /// Its version.
    pub version: u64,
}

#[derive(Serialize, Deserialize)]
struct Description {
    format: String,
    version: u64,
    sha256: String,
    body: String,
}

#[derive(Serialize, Deserialize)]
struct Body<T> {
    sums: BTreeMap<String, String>,
    content: T,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::IoError;
    use std::path::Path;

    const FORMAT: Format = Format { name: "test file", version: 3 };

    fn columns() -> BTreeMap<String, Column> {
        BTreeMap::from([
            ("a/t".to_owned(), Column::I64(vec![-1, 7, i64::MAX])),
            ("a/xy".to_owned(), Column::F64(2, vec![0.1, -0.0, f64::MIN_POSITIVE, 3.0])),
            ("text".to_owned(), Column::Bytes(b"rate: 20".to_vec())),
            ("none".to_owned(), Column::I64(vec![])),
        ])
    }

    fn written(dir: &Path) -> std::path::PathBuf {
        let path = dir.join("x.dpn");
        write(&path, FORMAT, &"hello", &columns()).unwrap();
        path
    }

    #[test]
    fn what_was_written_comes_back_to_the_bit_and_is_the_same_bytes_each_time() {
        let dir = tempfile::tempdir().unwrap();
        let path = written(dir.path());
        let (file, content) = ColumnFile::open::<String>(&path, FORMAT).unwrap();
        assert_eq!(content, "hello");
        assert_eq!(file.i64s("a/t").unwrap(), [-1, 7, i64::MAX]);
        let (width, values) = file.f64s("a/xy").unwrap();
        assert_eq!(width, 2);
        assert_eq!(
            values.iter().map(|v| v.to_bits()).collect::<Vec<_>>(),
            [0.1f64.to_bits(), (-0.0f64).to_bits(), f64::MIN_POSITIVE.to_bits(), 3.0f64.to_bits()]
        );
        assert_eq!(file.bytes("text").unwrap(), b"rate: 20");
        assert!(file.i64s("none").unwrap().is_empty());
        assert_eq!(file.names().collect::<Vec<_>>(), ["a/t", "a/xy", "none", "text"]);
        assert_eq!(std::fs::read(&path).unwrap(), to_bytes(&path, FORMAT, &"hello", &columns()).unwrap());
    }

    /// Every byte of the file matters: whichever is turned is found when it is opened, or when its column is read, and the others still read.
    #[test]
    fn a_turned_bit_is_found_wherever_it_is_and_named_by_its_column() {
        let dir = tempfile::tempdir().unwrap();
        let path = written(dir.path());
        let good = std::fs::read(&path).unwrap();
        let mut by_column = 0;
        for place in 0..good.len() {
            let mut bad = good.clone();
            bad[place] ^= 1 << (place % 8);
            std::fs::write(&path, &bad).unwrap();
            let Ok((file, _)) = ColumnFile::open::<String>(&path, FORMAT) else { continue };
            let faults: Vec<_> = file.names().filter_map(|name| file.check(name).err()).collect();
            // The padding of the header is nobody's.
            let padding = good[place] == b' ' && place < good.len() - 60;
            assert!(!faults.is_empty() || padding, "byte {place} of {}: {}", good.len(), good[place] as char);
            if let [IoError::ColumnFile(ColumnFileError::Column { column, .. })] = &faults[..] {
                by_column += usize::from(file.names().any(|name| name == column));
            }
        }
        assert!(by_column >= 24 + 32 + 8, "{by_column}");
    }

    #[test]
    fn a_file_that_is_cut_off_of_another_kind_or_version_or_without_a_column_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let path = written(dir.path());
        let good = std::fs::read(&path).unwrap();
        let error = |format: Format| ColumnFile::open::<String>(&path, format).unwrap_err().to_string();
        assert!(
            error(Format { version: 4, ..FORMAT })
                .ends_with("written as version 3, and this program reads version 4")
        );
        assert!(
            error(Format { name: "data pack", ..FORMAT })
                .ends_with("a test file, where a data pack is needed")
        );
        for kept in 0..good.len() {
            std::fs::write(&path, &good[..kept]).unwrap();
            let error = error(FORMAT);
            assert!(error.contains("x.dpn: ") && !error.contains('\n'), "{error}");
        }
        let cut = error(FORMAT);
        assert!(cut.contains(&format!("cut off: {} of {} bytes", good.len() - 1, good.len())), "{cut}");
        std::fs::write(&path, &good).unwrap();
        let (file, _) = ColumnFile::open::<String>(&path, FORMAT).unwrap();
        assert!(file.i64s("b").unwrap_err().to_string().ends_with("`b` is missing"));
        assert!(file.i64s("a/xy").unwrap_err().to_string().contains("`a/xy` is F64 [2, 2]"));
    }
}
