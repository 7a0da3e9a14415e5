//! Temporary files that a process began and did not live to rename: told from those of the living, and removed.
//!
//! A temporary file carries its process in its name and is locked while it is written. It is abandoned where no process of that number lives and
//! nobody holds its lock: the number alone may be another container's, the lock alone may not be taken yet.

use super::beneath::{Access, Folder, Kind};
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::NamedTempFile;

/// What a temporary file's name begins with, before its process and random letters, and ends with.
const BEGIN: &str = ".dpn-";
pub(crate) const END: &str = ".tmp";

/// What the names of this process's temporary files begin with.
pub(crate) fn own_prefix() -> String {
    format!("{BEGIN}{}-", std::process::id())
}

/// A file in the system's folder for such, which goes when the value is dropped. What a process left there that was killed meanwhile goes
/// when another one next makes one.
///
/// # Errors
/// A folder that nothing can be made in.
pub fn scratch_file() -> io::Result<NamedTempFile> {
    let dir = std::env::temp_dir();
    clear_once(&dir, &Folder::named(&dir)?);
    let file = tempfile::Builder::new().prefix(&own_prefix()).suffix(END).tempfile_in(dir)?;
    // A file system without locks has the process's number alone.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Removes what lies abandoned in `folder` and what `also` names, and so `depth` levels of folders below it that `enters` lets in.
pub(crate) fn clear(folder: &Folder, depth: usize, enters: fn(&Folder) -> bool, also: fn(&str) -> bool) {
    // What cannot be listed or removed is in nobody's way.
    let Ok(names) = folder.list() else { return };
    for name in names {
        if folder.kind(&name).is_ok_and(|kind| kind == Kind::Folder) {
            let below = (depth > 0).then(|| folder.enter(&name).ok()).flatten().filter(enters);
            if let Some(below) = below {
                clear(&below, depth - 1, enters, also);
            }
        } else if name.to_str().is_some_and(|text| also(text) || is_abandoned(folder, text)) {
            let _ = folder.remove(&name);
        }
    }
}

/// The same of the folder at `dir`, the first time that this process is about to write there: listing it again for every file would be quadratic.
pub(crate) fn clear_once(dir: &Path, folder: &Folder) {
    static SEEN: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if seen.get_or_insert_default().insert(dir.to_path_buf()) {
        clear(folder, 0, |_| false, |_| false);
    }
}

fn is_abandoned(folder: &Folder, name: &str) -> bool {
    let Some(rest) = name.strip_prefix(BEGIN).and_then(|rest| rest.strip_suffix(END)) else { return false };
    let process = rest.split_once('-').and_then(|(id, _)| id.parse::<u32>().ok());
    // Only Linux says cheaply who is alive; elsewhere the lock has to do.
    let lives = process.is_some_and(|id| Path::new("/proc").join(id.to_string()).exists());
    !lives && folder.open(name.as_ref(), Access::Read).is_ok_and(|file| file.try_lock().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    #[test]
    fn what_the_dead_left_goes_and_what_the_living_write_stays() {
        let tmp = tempfile::tempdir().unwrap();
        let alive = format!("{}x{END}", own_prefix());
        // No process has a number so high: Linux ends at 2^22.
        let names =
            [".dpn-4194999-x.tmp", ".dpn-Ab12cd.tmp", ".dpn-4194999-held.tmp", "a.tmp", ".figure-Ab", &alive];
        for name in names {
            fs::write(tmp.path().join(name), "half").unwrap();
        }
        let held = File::open(tmp.path().join(names[2])).unwrap();
        held.try_lock().unwrap();
        let folder = Folder::named(tmp.path()).unwrap();
        clear_once(tmp.path(), &folder);
        let there = |name: &str| tmp.path().join(name).exists();
        assert!(!there(names[0]) && !there(names[1]));
        assert!(there(names[2]) && there(names[3]) && there(names[4]));
        assert!(there(&alive) || cfg!(not(target_os = "linux")));
        // Once a process.
        drop(held);
        clear_once(tmp.path(), &folder);
        assert!(there(names[2]));
        clear(&folder, 0, |_| false, |name| name.starts_with(".figure-"));
        assert!(!there(names[2]) && !there(names[4]) && there(names[3]));
    }
}
