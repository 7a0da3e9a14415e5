//! Rows of fixed width, as many as come: the last ones in memory, all before them in a temporary file without a name, which goes with the
//! process. In a browser, where there are no files, all of them are in memory.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Bytes that are held before they go to the file.
const HELD: usize = 1 << 21;

/// What is kept in a [`Store`].
pub trait Row: Copy {
    /// Bytes of one.
    const BYTES: usize;

    /// Adds its [`BYTES`](Self::BYTES) to `bytes`.
    fn write(&self, bytes: &mut Vec<u8>);

    /// The row that was written as `words`, eight bytes each.
    fn read(words: &[[u8; 8]]) -> Self;
}

/// Rows that are added one by one and read again by place.
#[derive(Debug)]
pub struct Store<T> {
    file: Option<Mutex<File>>,
    /// Rows in the file.
    filed: usize,
    held: Vec<T>,
    /// Why a file could not be written; what came then is not here.
    failed: Option<io::Error>,
}

impl<T> Default for Store<T> {
    fn default() -> Self {
        Self::from(Vec::new())
    }
}

impl<T> From<Vec<T>> for Store<T> {
    fn from(held: Vec<T>) -> Self {
        Self { file: None, filed: 0, held, failed: None }
    }
}

fn named(error: &io::Error) -> io::Error {
    let text = format!(
        "a temporary file in {} (TMPDIR names another place): {error}",
        std::env::temp_dir().display()
    );
    io::Error::new(error.kind(), text)
}

impl<T: Row> Store<T> {
    /// Adds a row. A file that cannot be written is told by [`done`](Self::done).
    pub fn push(&mut self, row: T) {
        if self.failed.is_some() {
            return;
        }
        self.held.push(row);
        if self.held.len() * T::BYTES >= HELD && !cfg!(target_family = "wasm") {
            self.failed = self.file_held().err().map(|e| named(&e));
        }
    }

    fn file_held(&mut self) -> io::Result<()> {
        /// Rows written at a time.
        const MANY: usize = 4096;
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(Mutex::new(tempfile::tempfile()?)),
        };
        let file = file.get_mut().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start((self.filed * T::BYTES) as u64))?;
        let mut bytes = Vec::with_capacity(MANY * T::BYTES);
        for part in self.held.chunks(MANY) {
            bytes.clear();
            part.iter().for_each(|row| row.write(&mut bytes));
            file.write_all(&bytes)?;
        }
        self.filed += self.held.len();
        self.held.clear();
        Ok(())
    }

    /// The same, if all could be kept.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn done(mut self) -> io::Result<Self> {
        self.failed.take().map_or(Ok(self), Err)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.filed + self.held.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All rows, where none had to go to a file.
    pub(crate) fn into_held(self) -> Result<Vec<T>, Self> {
        if self.file.is_some() { Err(self) } else { Ok(self.held) }
    }

    /// The rows of `range`.
    ///
    /// # Errors
    /// A file that cannot be read.
    ///
    /// # Panics
    /// When `range` ends behind the last.
    pub fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [T]>> {
        let from = range.start.saturating_sub(self.filed);
        let held = &self.held[from..range.end.saturating_sub(self.filed).max(from)];
        let filed = range.start..range.end.min(self.filed);
        let (Some(file), false) = (&self.file, filed.is_empty()) else { return Ok(Cow::Borrowed(held)) };
        let mut bytes = vec![0; filed.len() * T::BYTES];
        {
            let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
            let at = SeekFrom::Start((filed.start * T::BYTES) as u64);
            file.seek(at).and_then(|_| file.read_exact(&mut bytes)).map_err(|e| named(&e))?;
        }
        let mut rows = Vec::with_capacity(range.len());
        rows.extend(bytes.as_chunks().0.chunks_exact(T::BYTES / 8).map(T::read));
        rows.extend_from_slice(held);
        Ok(Cow::Owned(rows))
    }

    /// Hands every row to `take`.
    ///
    /// # Errors
    /// A file that cannot be read, and `take`'s own.
    pub fn each(&self, mut take: impl FnMut(&T) -> io::Result<()>) -> io::Result<()> {
        /// Rows read at a time.
        const MANY: usize = 4096;
        for from in (0..self.len()).step_by(MANY) {
            self.piece(from..(from + MANY).min(self.len()))?.iter().try_for_each(&mut take)?;
        }
        Ok(())
    }
}
