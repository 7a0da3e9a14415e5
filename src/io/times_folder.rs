//! A camera's folder as TUM-mono and DM-VIO have it: `times.txt` with a row an image, `id timestamp exposure`, and the images in `images/`.
//!
//! Stamps are seconds, or nanoseconds where they are whole numbers of more than 14 digits. The image of an id is the file of that name, `00012.jpg` or
//! `12.jpg` for 12, PNG or JPEG. The exposure is passed over.

use super::IoError;
use super::decimal::TimeUnit;
use super::rows::Rows;
use dpn_core::time::Stamp;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// File of the stamps.
const TIMES: &str = "times.txt";
/// Folder of the images.
const IMAGES: &str = "images";
/// Whole numbers of more digits count nanoseconds: so many seconds are three million years.
const LONGEST_SECONDS: usize = 14;

/// Images that a folder lists, in increasing time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimesFolder {
    /// Stamps and files; one that is listed and not there is named as it should be.
    pub frames: Vec<(Stamp, PathBuf)>,
    /// How many images there are.
    pub files: usize,
    /// The list.
    pub times: PathBuf,
}

impl TimesFolder {
    /// Whether `dir` looks like one.
    pub fn is(dir: &Path) -> bool {
        dir.join(TIMES).is_file()
    }

    /// Reads the list and looks which images there are.
    ///
    /// # Errors
    /// No list or no folder of images; a row that is none; stamps that do not increase.
    pub fn read(dir: &Path) -> Result<Self, IoError> {
        let times = dir.join(TIMES);
        let bytes = std::fs::read(&times).map_err(|e| IoError::reading(&times, e))?;
        let images = dir.join(IMAGES);
        let listed = std::fs::read_dir(&images).map_err(|e| IoError::reading(&images, e))?;
        let mut names = HashMap::new();
        let mut files = 0;
        for entry in listed {
            let path = entry.map_err(|e| IoError::reading(&images, e))?.path();
            let is_image =
                |end: &OsStr| ["png", "jpg", "jpeg"].iter().any(|known| end.eq_ignore_ascii_case(known));
            let (Some(stem), Some(_)) = (path.file_stem(), path.extension().filter(|end| is_image(end)))
            else {
                continue;
            };
            files += 1;
            names.insert(key(&stem.to_string_lossy()), path);
        }
        Ok(Self { frames: rows(&bytes, &times, |id| file_of(id, &names, &images))?, files, times })
    }

    /// Says whether as many images are there as are listed.
    ///
    /// # Errors
    /// They are not.
    pub fn agree(&self) -> Result<(), IoError> {
        let (listed, found) = (self.frames.len(), self.files);
        match listed == found {
            true => Ok(()),
            false => Err(IoError::TimesDiffer { path: self.times.clone(), listed, found }),
        }
    }
}

/// A name as it is compared: a number without the zeros before it.
fn key(name: &str) -> String {
    let digits = name.trim_start_matches('0');
    match name.bytes().all(|c| c.is_ascii_digit()) {
        true if digits.is_empty() => "0".to_owned(),
        true => digits.to_owned(),
        false => name.to_owned(),
    }
}

fn file_of(id: &str, names: &HashMap<String, PathBuf>, images: &Path) -> PathBuf {
    names.get(&key(id)).cloned().unwrap_or_else(|| {
        // As its neighbours are called; what steers out of the folder is no name.
        let plain: String = id.chars().filter(|c| c.is_ascii_alphanumeric() || "-_".contains(*c)).collect();
        images.join(format!("{plain}.png"))
    })
}

fn rows(bytes: &[u8], path: &Path, file: impl Fn(&str) -> PathBuf) -> Result<Vec<(Stamp, PathBuf)>, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    if !(2..=3).contains(&rows.width()) {
        return Err(rows.unknown_layout("id timestamp exposure, or the first two,"));
    }
    let mut frames: Vec<(Stamp, PathBuf)> = Vec::new();
    while rows.advance()? {
        let digits = rows.text(1)?;
        let whole = digits.bytes().all(|c| c.is_ascii_digit());
        let unit = if whole && digits.len() > LONGEST_SECONDS { TimeUnit::Nanos } else { TimeUnit::Seconds };
        let t = rows.stamp_after(frames.last().map(|(t, _)| *t), 1, unit)?;
        frames.push((t, file(rows.text(0)?)));
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn ids_name_files_with_and_without_zeros_and_stamps_are_exact() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
        fs::create_dir(dir.path().join("images")).unwrap();
        for name in ["images/00000.jpg", "images/1.PNG", "images/00002.jpeg", "images/notes.txt"] {
            write(name, "");
        }
        write(
            "times.txt",
            "# id timestamp exposure\n0 1403636625.363555670 12.5\n00001 1403636625.413555670 1\n2 1403636625.5 1\n",
        );
        assert!(TimesFolder::is(dir.path()));
        let folder = TimesFolder::read(dir.path()).unwrap();
        let found: Vec<_> = folder
            .frames
            .iter()
            .map(|(t, path)| (t.ns(), path.file_name().unwrap().to_str().unwrap()))
            .collect();
        let expected = [
            (1_403_636_625_363_555_670, "00000.jpg"),
            (1_403_636_625_413_555_670, "1.PNG"),
            (1_403_636_625_500_000_000, "00002.jpeg"),
        ];
        assert_eq!(found, expected);
        folder.agree().unwrap();
        write("times.txt", "0 1403636625363555670\n7 1403636625413555670\n");
        let folder = TimesFolder::read(dir.path()).unwrap();
        assert_eq!(folder.frames[0].0.ns(), 1_403_636_625_363_555_670);
        assert!(!folder.frames[1].1.is_file());
        let error = folder.agree().unwrap_err();
        assert!(
            error.to_string().ends_with("times.txt lists 2 images, and images/ beside it holds 3"),
            "{error}"
        );
        assert!(error.hint().unwrap().contains("--skip-missing"));
        for (text, words) in [
            ("0\n1\n", "times.txt:1: 1 columns; id timestamp exposure"),
            ("0 2\n1 1\n", "times.txt:2: time goes"),
            ("0 x\n", "times.txt:1: "),
            ("../../etc/passwd 1\n", "passwd.png"),
        ] {
            write("times.txt", text);
            let said = match TimesFolder::read(dir.path()) {
                Ok(folder) => folder.frames[0].1.display().to_string(),
                Err(error) => error.to_string(),
            };
            assert!(said.contains(words), "{said}");
        }
    }
}
