//! Files that are there in full or not at all.

use super::IoError;
use super::beneath::Folder;
use super::leftovers;
use super::result_path::ResultPath;
use serde::Serialize;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Writes `path` through `fill`: into a temporary file beside it, which takes its place once all is on the disk. Folders above it are
/// made. On any error the file that was there stays as it was and nothing half-written is left; what a process left that was killed meanwhile goes when
/// another one next writes into that folder.
///
/// Of a path that somebody named a link is followed, and what is no regular file (a pipe, `/dev/stdout`) is written to directly. Below a folder that
/// somebody named ([`ResultPath::join`]) both are errors.
///
/// # Errors
/// A folder that cannot be made or written to, a full disk, whatever `fill` returns; all as [`IoError::Write`] with `path`.
/// What is in the way, as [`IoError::InTheWay`].
pub fn atomic_write(
    path: impl Into<ResultPath>,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    let path = path.into();
    let failed = |source| IoError::Write { path: path.path().to_path_buf(), source };
    if path.is_named() {
        return write_named(path.path(), fill).map_err(failed);
    }
    let (folder, name) = path.place()?;
    leftovers::clear_once(path.path().parent().expect("it is below another"), &folder);
    write(&folder, name, fill).map_err(failed)
}

/// [`atomic_write`] of what is there already: a text, or bytes.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_file(path: impl Into<ResultPath>, content: impl AsRef<[u8]>) -> Result<(), IoError> {
    atomic_write(path, |out| out.write_all(content.as_ref()))
}

/// [`write_file`] of a line of JSON.
///
/// # Errors
/// As [`atomic_write`], and a value that JSON cannot say.
pub fn write_json(path: impl Into<ResultPath>, value: &(impl Serialize + ?Sized)) -> Result<(), IoError> {
    atomic_write(path, |out| writeln!(out, "{}", serde_json::to_string(value)?))
}

/// Renaming over a link would replace the link, over a device the device.
fn write_named(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = match fs::metadata(path) {
        Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(there) if !there.is_file() => {
            let mut out = BufWriter::new(fs::OpenOptions::new().write(true).open(path)?);
            fill(&mut out)?;
            return out.flush();
        }
        Ok(_) => fs::canonicalize(path)?,
        Err(_) => path.to_path_buf(),
    };
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    fs::create_dir_all(folder)?;
    let opened = Folder::named(folder)?;
    leftovers::clear_once(folder, &opened);
    write(&opened, name, fill)
}

/// A temporary file, removed unless it took its place.
struct Temporary<'a> {
    folder: &'a Folder,
    name: OsString,
    file: fs::File,
    placed: bool,
}

impl<'a> Temporary<'a> {
    fn new(folder: &'a Folder) -> io::Result<Self> {
        static MADE: AtomicUsize = AtomicUsize::new(0);
        // Another container's process may have this one's number.
        for _ in 0..1000 {
            let number = MADE.fetch_add(1, Ordering::Relaxed);
            let name = OsString::from(format!("{}{number}{}", leftovers::own_prefix(), leftovers::END));
            match folder.create_new(&name) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                file => return Ok(Self { folder, name, file: file?, placed: false }),
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "every name for a temporary file is taken"))
    }
}

impl Drop for Temporary<'_> {
    fn drop(&mut self) {
        if !self.placed {
            // What stays goes when another process next writes there.
            let _ = self.folder.remove(&self.name);
        }
    }
}

fn write(
    folder: &Folder,
    name: &OsStr,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut temporary = Temporary::new(folder)?;
    // A file system without locks has the process's number alone.
    let _ = temporary.file.try_lock();
    let mut out = BufWriter::with_capacity(1 << 16, &mut temporary.file);
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    temporary.file.sync_all()?;
    #[cfg(debug_assertions)]
    let rename = abort::next();
    folder.rename(&temporary.name, name)?;
    temporary.placed = true;
    #[cfg(debug_assertions)]
    abort::after(rename);
    Ok(())
}

/// Ends the process as a kill would, at one rename: `DPN_ABORT_AT_RENAME=3` before the third of this process, `3+` after it. In builds with debug
/// assertions alone; `tests/chaos` kills so.
#[cfg(debug_assertions)]
mod abort {
    use std::sync::atomic::{AtomicUsize, Ordering};

    static RENAMES: AtomicUsize = AtomicUsize::new(0);

    /// The number of the rename that comes.
    pub(super) fn next() -> usize {
        let rename = RENAMES.fetch_add(1, Ordering::SeqCst) + 1;
        at(&rename.to_string());
        rename
    }

    pub(super) fn after(rename: usize) {
        at(&format!("{rename}+"));
    }

    fn at(moment: &str) {
        if std::env::var_os("DPN_ABORT_AT_RENAME").is_some_and(|wanted| wanted == moment) {
            std::process::abort();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(dir: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_half_way_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out.csv");
        atomic_write(&path, |out| out.write_all(b"old")).unwrap();
        let error = atomic_write(&path, |out| {
            out.write_all(&[b'x'; 1 << 20])?;
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(error.hint().unwrap().contains("disk is full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(files(dir.path()), ["out.csv"]);
    }

    #[test]
    fn folders_above_are_made_and_old_content_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b/out.csv");
        atomic_write(&path, |out| out.write_all(b"a long first text")).unwrap();
        atomic_write(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn a_folder_in_the_way_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        assert!(atomic_write(dir.path(), |out| out.write_all(b"x")).is_err());
        fs::write(dir.path().join("file"), "").unwrap();
        let error = atomic_write(dir.path().join("file/out.csv"), |out| out.write_all(b"x")).unwrap_err();
        assert!(error.to_string().ends_with("file/out.csv"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_the_mode_is_a_plain_files() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let (plain, target, link) =
            (dir.path().join("plain"), dir.path().join("target"), dir.path().join("link"));
        fs::write(&plain, "").unwrap();
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        atomic_write(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&target), mode(&plain));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error_and_stays_a_device() {
        let full = Path::new("/dev/full");
        let error = atomic_write(full, |out| out.write_all(&[b'x'; 1 << 17])).unwrap_err();
        assert!(error.hint().unwrap().contains("disk is full"), "{error:?}");
        assert!(!fs::metadata(full).unwrap().is_file());
    }
}
