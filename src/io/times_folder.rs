//! A camera's images in a folder: with `times.txt` as TUM-mono and DM-VIO have it, a row an image, `id timestamp exposure`, and the images in `images/`; or with
//! the stamps for names, as Kalibr's bagextracter leaves them.
//!
//! Stamps of a list are seconds, or nanoseconds where they are whole numbers of more than 14 digits. The image of an id is the file of that name, `00012.jpg` or
//! `12.jpg` for 12, PNG or JPEG. The exposure is passed over. Stamps in names are of the unit in which images follow each other by 2 ms to 2 s. Both may lie in the
//! folder itself or in its `cam0`.

use super::IoError;
use super::decimal::{TimeUnit, parse_stamp};
use super::rows::Rows;
use dpn_core::signal::stats::median_of;
use dpn_core::time::Stamp;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Files of the stamps, the first that is there.
const TIMES: [&str; 2] = ["times.txt", "cam0/times.txt"];
/// Folder of the images beside them.
const IMAGES: &str = "images";
/// Folders of images whose names are their stamps.
const STAMPED: [&str; 6] = ["cam0", "cam0/data", "cam0/images", "images", "image_0", "."];
/// Characters that a stamp has at least: an index is none.
const LEAST_STAMP: usize = 10;
/// Steps between images that a unit must make \[s\].
const STEPS_S: [f64; 2] = [2e-3, 2.0];
/// Whole numbers of more digits count nanoseconds: so many seconds are three million years.
const LONGEST_SECONDS: usize = 14;

/// Images that a folder lists, in increasing time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimesFolder {
    /// Stamps and files; one that is listed and not there is named as it should be.
    pub frames: Vec<(Stamp, PathBuf)>,
    /// How many images there are.
    pub files: usize,
    /// The list, or the folder of images without one.
    pub times: PathBuf,
}

impl TimesFolder {
    /// Whether `dir` looks like one.
    pub fn is(dir: &Path) -> bool {
        list_of(dir).is_some() || stamped_in(dir).is_some()
    }

    /// Reads the list and looks which images there are; or their names, where there is no list.
    ///
    /// # Errors
    /// No list or no folder of images; a row that is none; stamps that do not increase.
    pub fn read(dir: &Path) -> Result<Self, IoError> {
        let Some(times) = list_of(dir) else {
            let (images, frames) =
                stamped_in(dir).ok_or_else(|| IoError::Missing { path: dir.join(TIMES[0]) })?;
            return Ok(Self { files: frames.len(), frames, times: images });
        };
        let bytes = std::fs::read(&times).map_err(|e| IoError::reading(&times, e))?;
        let beside = times.with_file_name(IMAGES);
        // DM-VIO's times may lie above the camera's folder.
        let below = dir.join("cam0").join(IMAGES);
        let images = if !beside.is_dir() && below.is_dir() { below } else { beside };
        let mut names = HashMap::new();
        let mut files = 0;
        for path in images_in(&images)? {
            files += 1;
            names.insert(key(&path.file_stem().unwrap_or_default().to_string_lossy()), path);
        }
        Ok(Self { frames: rows(&bytes, &times, |id| file_of(id, &names, &images))?, files, times })
    }

    /// Whether the stamps stand in a file of their own.
    pub fn has_list(&self) -> bool {
        self.times.is_file()
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

fn list_of(dir: &Path) -> Option<PathBuf> {
    TIMES.map(|name| dir.join(name)).into_iter().find(|file| file.is_file())
}

/// The images of a folder, in no order.
fn images_in(dir: &Path) -> Result<Vec<PathBuf>, IoError> {
    let reading = |e| IoError::reading(dir, e);
    let is_image = |end: &OsStr| ["png", "jpg", "jpeg"].iter().any(|known| end.eq_ignore_ascii_case(known));
    let mut all = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(reading)? {
        let path = entry.map_err(reading)?.path();
        if path.extension().is_some_and(is_image) {
            all.push(path);
        }
    }
    Ok(all)
}

/// The first folder of images whose names are stamps, and these in increasing time.
fn stamped_in(dir: &Path) -> Option<(PathBuf, Vec<(Stamp, PathBuf)>)> {
    STAMPED.into_iter().find_map(|name| {
        let images = if name == "." { dir.to_path_buf() } else { dir.join(name) };
        let stem = |path: &PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let is_stamp = |stem: &String| {
            stem.len() >= LEAST_STAMP && stem.bytes().all(|c| c.is_ascii_digit() || c == b'.')
        };
        let named = images_in(&images)
            .ok()?
            .into_iter()
            .filter_map(|path| Some((stem(&path).filter(is_stamp)?, path)));
        let named: Vec<(String, PathBuf)> = named.collect();
        let in_unit = |unit: TimeUnit| {
            let mut frames: Vec<(Stamp, PathBuf)> = Vec::with_capacity(named.len());
            for (stem, path) in &named {
                frames.push((parse_stamp(stem.as_bytes(), unit)?, path.clone()));
            }
            frames.sort();
            let steps = frames.windows(2).map(|pair| pair[1].0.seconds_since(pair[0].0));
            let step = median_of(steps)?;
            (STEPS_S[0]..STEPS_S[1]).contains(&step).then_some(frames)
        };
        Some((images, TimeUnit::USUAL.into_iter().find_map(in_unit)?))
    })
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

    #[test]
    fn names_that_are_stamps_need_no_list_and_lie_in_cam0_too() {
        for (unit, step) in [(1u64, 50_000_000u64), (1000, 50_000), (1_000_000, 50)] {
            let dir = tempfile::tempdir().unwrap();
            let start = 1_403_636_625_363_000_000 / unit;
            fs::create_dir_all(dir.path().join("cam0")).unwrap();
            for i in (0..5).rev() {
                fs::write(dir.path().join(format!("cam0/{}.png", start + i * step)), "").unwrap();
            }
            assert!(TimesFolder::is(dir.path()));
            let folder = TimesFolder::read(dir.path()).unwrap();
            let stamps: Vec<i64> = folder.frames.iter().map(|(t, _)| t.ns()).collect();
            assert_eq!(
                stamps,
                (0..5).map(|i| 1_403_636_625_363_000_000 + i * 50_000_000).collect::<Vec<_>>()
            );
            assert!(!folder.has_list() && folder.agree().is_ok());
        }
        // DM-VIO: images and list below, the IMU above; an index is no stamp.
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("cam0/images")).unwrap();
        for i in 0..3 {
            fs::write(dir.path().join(format!("cam0/images/0000{i}.jpg")), "").unwrap();
        }
        assert!(!TimesFolder::is(dir.path()));
        for list in ["cam0/times.txt", "times.txt"] {
            fs::write(dir.path().join(list), "0 1.5\n1 1.55\n2 1.6\n").unwrap();
            let folder = TimesFolder::read(dir.path()).unwrap();
            assert!(folder.frames.iter().all(|(_, file)| file.is_file()) && folder.agree().is_ok());
            fs::remove_file(dir.path().join(list)).unwrap();
        }
    }
}
