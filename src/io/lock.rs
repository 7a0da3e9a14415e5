//! Folders that one process at a time writes results to.
//!
//! A lock is the system's own, on the file [`LOCK`] in the folder: it goes with its process, however that ends. The file says who holds it.

use super::IoError;
use super::beneath::Folder;
use super::leftovers::clear;
use super::result_path::ResultPath;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use thiserror::Error;

/// Name of the file that is locked.
const LOCK: &str = ".dpn.lock";
/// Folders below the locked one in which files of dead processes are looked for.
const DEPTH: usize = 2;

/// Why a folder cannot be written to by this process alone.
#[derive(Debug, Error)]
pub enum LockError {
    /// Another process writes there.
    #[error("{}: another dpn writes there ({})", dir.display(), holder.as_deref().unwrap_or("it does not say which"))]
    Held {
        /// The folder.
        dir: PathBuf,
        /// Its process and since when, in words.
        holder: Option<String>,
    },
    /// A folder in which nothing can be made or locked.
    #[error(transparent)]
    Io(#[from] IoError),
}

impl LockError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Held { .. } => {
                Some("wait until that one is over, stop it, or name another folder for this one".into())
            }
            Self::Io(error) => error.hint(),
        }
    }
}

/// A folder that no other process takes while this value lives.
#[derive(Debug)]
pub struct FolderLock {
    dir: ResultPath,
    file: File,
    /// The folder was not there before.
    made: bool,
}

impl FolderLock {
    /// Takes `dir`, which is made where it is not there, and clears it of what dead processes left half-written.
    ///
    /// # Errors
    /// Another process (or another value of this one) holds it; a folder that cannot be made or written to.
    pub fn take(dir: impl Into<ResultPath>) -> Result<Self, LockError> {
        let dir = dir.into();
        let lock = dir.join(LOCK);
        let path = lock.path();
        let failed = |source| LockError::Io(IoError::Write { path: path.to_path_buf(), source });
        let made = dir.kind().is_none();
        let mut tries = 0..100;
        let file = loop {
            let mut file = match lock.open_lock() {
                // Its holder took the folder away between making and opening.
                Err(IoError::Write { source, .. })
                    if source.kind() == io::ErrorKind::NotFound && tries.next().is_some() =>
                {
                    continue;
                }
                file => file?,
            };
            match file.try_lock() {
                Ok(()) if is_at(&file, path) => break file,
                // Locked, and gone: its holder removed it between our opening and our locking.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut text = String::new();
                    // Who cannot be told is somebody all the same.
                    let _ = file.read_to_string(&mut text);
                    let holder = text.lines().next().map(str::to_owned);
                    return Err(LockError::Held { dir: dir.path().to_path_buf(), holder });
                }
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
        };
        let lock = Self { dir: dir.clone(), file, made };
        let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs());
        let text = format!("process {}, since {}\n", std::process::id(), utc(since));
        lock.file.set_len(0).and_then(|()| (&lock.file).write_all(text.as_bytes())).map_err(failed)?;
        // Folders that somebody holds or held are left to their own lock; `.figure-*` is what earlier versions drew into.
        if let Ok(folder) = dir.entered(false) {
            let is_free = |below: &Folder| below.kind(LOCK.as_ref()).is_err();
            clear(&folder, DEPTH, is_free, |name| name.starts_with(".figure-"));
        }
        Ok(lock)
    }

    /// The folder.
    pub fn dir(&self) -> &ResultPath {
        &self.dir
    }
}

impl Drop for FolderLock {
    /// Takes the file away, and the folder where this lock made it and nothing has come into it. Elsewhere than on Unix the file stays: there an open
    /// file cannot be told from another of its name.
    fn drop(&mut self) {
        // Whatever fails here leaves a file that nobody has locked: the next process takes it over.
        let lock = self.dir.join(LOCK);
        if cfg!(unix) && is_at(&self.file, lock.path()) {
            let _ = lock.remove();
        }
        if self.made {
            let _ = self.dir.remove_empty();
        }
    }
}

/// Whether `file` is what lies at `path` now.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |meta: fs::Metadata| (meta.dev(), meta.ino());
    file.metadata()
        .map(place)
        .ok()
        .is_some_and(|here| fs::symlink_metadata(path).map(place).is_ok_and(|there| here == there))
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Seconds since 1970 as a date and a time, as `2026-11-22 12:46:19 UTC`.
fn utc(seconds: u64) -> String {
    // Years begin in March, so that the leap day is a year's last: Hinnant, "chrono-compatible low-level date algorithms".
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (date, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = 400 * era + year + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{date:02} {hour:02}:{minute:02}:{second:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_one_holders_and_free_again_when_that_one_is_gone() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path().join("runs/a");
        let lock = FolderLock::take(&dir).unwrap();
        let error = FolderLock::take(&dir).unwrap_err();
        let text = error.to_string();
        let words = format!("runs/a: another dpn writes there (process {}, since 2", std::process::id());
        assert!(text.contains(&words) && text.ends_with(" UTC)"), "{text}");
        assert!(error.hint().unwrap().contains("another folder"));
        drop(lock);
        assert!(!dir.exists(), "a folder made for nothing stays");
        let lock = FolderLock::take(&dir).unwrap();
        fs::write(dir.join("rows.jsonl"), "").unwrap();
        drop(lock);
        let left: Vec<_> = fs::read_dir(&dir).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["rows.jsonl"]);
    }

    #[test]
    fn of_many_that_want_a_folder_at_once_one_has_it_at_a_time() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path().join("a");
        let inside = std::sync::atomic::AtomicUsize::new(0);
        let taken = std::sync::atomic::AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let Ok(lock) = FolderLock::take(&dir) else { continue };
                        assert_eq!(inside.fetch_add(1, std::sync::atomic::Ordering::SeqCst), 0);
                        taken.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                        inside.fetch_sub(1, std::sync::atomic::Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert!(taken.into_inner() > 0);
    }

    #[test]
    fn what_a_dead_holder_left_is_cleared_and_what_a_living_one_writes_is_not() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path();
        fs::create_dir_all(dir.join("tables")).unwrap();
        fs::create_dir_all(dir.join("other")).unwrap();
        let alive = format!(".dpn-{}-x.tmp", std::process::id());
        let dead =
            [".dpn-4194999-x.tmp", ".dpn-Ab12cd.tmp", ".figure-Ab12cd", "tables/.dpn-4194999-y.tmp", LOCK];
        let kept = ["rows.jsonl", "a.tmp", "other/.dpn.lock", "other/.dpn-Ab12cd.tmp", &alive];
        for name in dead.iter().chain(&kept) {
            fs::write(dir.join(name), "process 4194999").unwrap();
        }
        drop(FolderLock::take(dir).unwrap());
        assert!(dead.iter().all(|name| !dir.join(name).exists()));
        let kept = kept.iter().filter(|name| !name.contains("-x.") || cfg!(target_os = "linux"));
        assert!(kept.clone().all(|name| dir.join(name).exists()), "{kept:?}");
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "1970-01-01 00:00:00 UTC"),
            (951_782_400, "2000-02-29 00:00:00 UTC"),
            (1_709_251_199, "2024-02-29 23:59:59 UTC"),
            (1_795_351_579, "2026-11-22 12:46:19 UTC"),
            (4_107_542_400, "2100-03-01 00:00:00 UTC"),
        ] {
            assert_eq!(utc(seconds), text);
        }
    }
}
