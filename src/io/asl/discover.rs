//! Finds the sequences under a folder.

use super::sequence::{IMU_DATA, Sequence};
use crate::IoError;
use std::path::{Path, PathBuf};

/// How many folders below the given one a sequence may be: `data/euroc/MH_01_easy` is two below `data`.
const DEPTH: usize = 2;

/// Every ASL sequence in `dir`: the folder itself, or those one or two levels below, sorted by name, then by path. Hidden folders
/// and what is inside a sequence are not looked at.
///
/// # Errors
/// `dir` cannot be listed; no sequence in it.
pub fn discover(dir: &Path) -> Result<Vec<Sequence>, IoError> {
    let below = folders(dir)?;
    let mut found = Vec::new();
    match Sequence::at(dir) {
        Some(sequence) => found.push(sequence),
        None => below.iter().for_each(|sub| collect(sub, DEPTH, &mut found)),
    }
    if found.is_empty() {
        let looked_for = ["", "*/", "*/*/"]
            .iter()
            .flat_map(|up| [format!("{up}mav0/{IMU_DATA}"), format!("{up}{IMU_DATA}")])
            .collect::<Vec<_>>()
            .join(", ");
        return Err(IoError::NoSequence { dir: dir.to_path_buf(), looked_for });
    }
    found.sort_by(|a, b| (a.name(), a.dir()).cmp(&(b.name(), b.dir())));
    Ok(found)
}

impl Sequence {
    /// The sequence in `dir`, which holds `mav0/imu0/data.csv` or `imu0/data.csv`.
    ///
    /// # Errors
    /// `dir` is not there, or holds neither.
    pub fn open(dir: &Path) -> Result<Self, IoError> {
        std::fs::read_dir(dir).map_err(|e| IoError::reading(dir, e))?;
        Self::at(dir).ok_or_else(|| IoError::NoSequence {
            dir: dir.to_path_buf(),
            looked_for: format!("mav0/{IMU_DATA}, {IMU_DATA}"),
        })
    }
}

fn collect(dir: &Path, levels: usize, found: &mut Vec<Sequence>) {
    if let Some(sequence) = Sequence::at(dir) {
        found.push(sequence);
    } else if levels > 1 {
        // A folder below that cannot be listed is none of the caller's sequences.
        for sub in folders(dir).unwrap_or_default() {
            collect(&sub, levels - 1, found);
        }
    }
}

/// The folders in `dir` that are not hidden.
fn folders(dir: &Path) -> Result<Vec<PathBuf>, IoError> {
    let failed = |e| IoError::reading(dir, e);
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        if !entry.file_name().to_string_lossy().starts_with('.') && path.is_dir() {
            folders.push(path);
        }
    }
    Ok(folders)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn put(root: &Path, dir: &str) {
        let file = root.join(dir).join(IMU_DATA);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, "0,0,0,0,0,0,9.81\n5000000,0,0,0,0,0,9.81\n").unwrap();
    }

    fn names(dir: &Path) -> Vec<String> {
        discover(dir).unwrap().iter().map(|s| s.name().to_owned()).collect()
    }

    #[test]
    fn sequences_are_found_at_the_folder_itself_and_two_levels_down() {
        let tmp = tempfile::tempdir().unwrap();
        let root = tmp.path();
        put(root, "euroc/MH_02/mav0");
        put(root, "euroc/MH_01/mav0");
        put(root, "room1");
        put(root, ".hidden/x/mav0");
        put(root, "a/b/too_deep/mav0");
        assert_eq!(names(root), ["MH_01", "MH_02", "room1"]);
        assert_eq!(names(&root.join("euroc")), ["MH_01", "MH_02"]);
        assert_eq!(names(&root.join("euroc/MH_01")), ["MH_01"]);
        assert_eq!(names(&root.join("euroc/MH_01/mav0")), ["MH_01"]);
        assert_eq!(names(&root.join("room1")), ["room1"]);
        assert_eq!(Sequence::open(&root.join("room1")).unwrap().imu().unwrap().len(), 2);
    }

    #[test]
    fn an_empty_folder_tells_what_was_looked_for() {
        let tmp = tempfile::tempdir().unwrap();
        let error = discover(tmp.path()).unwrap_err();
        assert!(error.to_string().contains("*/*/mav0/imu0/data.csv"), "{error}");
        assert!(error.hint().is_some());
        let error = discover(&tmp.path().join("nowhere")).unwrap_err();
        assert!(matches!(error, IoError::Missing { .. }), "{error}");
        let error = Sequence::open(tmp.path()).unwrap_err();
        assert!(matches!(error, IoError::NoSequence { .. }), "{error}");
    }
}
