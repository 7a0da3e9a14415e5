//! The IMU's file in a folder of images: by its usual names, the only one with JSON, or a phone's two.

use crate::LogError;
use crate::two_files::TwoFiles;
use dpn_io::IoError;
use std::path::{Path, PathBuf};

/// Names of the file, the first that is there: DM-VIO's, Kalibr's bagcreater's and others'.
const FILES: [&str; 6] = ["imu.txt", "imu.csv", "imu0.csv", "imu0.txt", "imu_data.csv", "imu0/data.csv"];

/// Where a folder has its samples.
#[derive(Debug)]
pub(crate) enum ImuFile {
    /// A file.
    One(PathBuf),
    /// The folder of a phone's two files.
    Two(PathBuf),
}

impl ImuFile {
    /// That of `dir`, or of the folder above where `dir` is a camera's.
    ///
    /// # Errors
    /// None; a folder that cannot be listed.
    pub(crate) fn of(dir: &Path) -> Result<Self, LogError> {
        let full = dir.canonicalize().unwrap_or_else(|_| dir.to_path_buf());
        let is_camera = full.file_name().is_some_and(|name| name.to_string_lossy().starts_with("cam"));
        let above = is_camera.then(|| dir.join(".."));
        for dir in [Some(dir), above.as_deref()].into_iter().flatten() {
            if let Some(file) = FILES.map(|file| dir.join(file)).into_iter().find(|file| file.is_file()) {
                return Ok(Self::One(file));
            }
            let entries = std::fs::read_dir(dir).map_err(|e| IoError::reading(dir, e))?;
            let is_json = |path: &PathBuf| {
                path.extension().is_some_and(|end| end == "jsonl" || end == "ndjson") && path.is_file()
            };
            let mut json = entries.flatten().map(|entry| entry.path()).filter(is_json);
            if let (Some(only), None) = (json.next(), json.next()) {
                return Ok(Self::One(only));
            }
            if TwoFiles::find(dir)?.is_some() {
                return Ok(Self::Two(dir.to_path_buf()));
            }
        }
        Err(LogError::NoImuFile { dir: dir.to_path_buf() })
    }

    /// What is read: the file, or the folder of two.
    pub(crate) fn path(&self) -> &Path {
        match self {
            Self::One(path) | Self::Two(path) => path,
        }
    }

    /// The files that it is read from.
    #[cfg(feature = "images")]
    pub(crate) fn files(self) -> Result<Vec<PathBuf>, LogError> {
        Ok(match self {
            Self::One(file) => vec![file],
            Self::Two(dir) => TwoFiles::find(&dir)?.map(|files| files.files()).unwrap_or_default(),
        })
    }
}
