//! A log with images as a sequence: a bag, or a folder with `times.txt`, and the camera's calibration.

use super::error::{ClosedLoopError, OfSequence};
use super::images::ImageStream;
use super::recording::{Recording, Span};
use super::sequence_fault::SequenceFault;
use dpn_core::camera::{CameraConfig, CameraModel};
use dpn_core::checksum::hex;
use dpn_core::trajectory::StampedPose;
use dpn_io::calibration::{self, Calibration};
use dpn_io::{IoError, read_poses};
use dpn_logs::{ImageLog, ImageLogOptions, ImageSpan, LogError};
use dpn_train::split::{Side, paper_side};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// A log with images, and what camera took them.
#[derive(Debug, Clone)]
pub struct LoggedSequence {
    log: ImageLog,
    calibration: Calibration,
    /// Where that was found, when nobody named it and it lies at no usual place.
    found: Option<PathBuf>,
    /// Somebody's file of true poses, and what is in it.
    truth: Option<(PathBuf, Vec<StampedPose>)>,
}

impl LoggedSequence {
    /// The log at `path` with the `calibration` given, else the one in it or beside it; `None` where it is no such log.
    ///
    /// # Errors
    /// No calibration, or one that does not read.
    pub fn find(
        path: &Path,
        options: ImageLogOptions,
        calibration: Option<&Calibration>,
    ) -> Result<Option<Self>, ClosedLoopError> {
        let Some(log) = ImageLog::find(path, options)? else { return Ok(None) };
        let own = log.calibration().map(|file| calibration::read(&file));
        let mut found = None;
        let calibration = match (calibration, own) {
            (Some(given), _) => given.clone(),
            (None, Some(Ok(own))) => own,
            (None, broken) => {
                let beside = calibration::beside::find(&log.calibration_dirs())?;
                let Some((file, calibration)) = beside else {
                    return Err(match broken {
                        Some(Err(error)) => error.into(),
                        // Of a log without images nobody needs one.
                        _ => match log.imu([1, 1]) {
                            Err(error @ LogError::NoImages { .. }) => error.into(),
                            _ => ClosedLoopError::NoCalibration { path: path.to_path_buf() },
                        },
                    });
                };
                found = Some(file);
                calibration
            }
        };
        Ok(Some(Self { log, calibration, found, truth: None }))
    }

    /// The same with the true poses of `file`, as [`read_poses`] takes them.
    ///
    /// # Errors
    /// A file that does not read.
    pub fn with_truth(mut self, file: &Path) -> Result<Self, ClosedLoopError> {
        self.truth = Some((file.to_path_buf(), read_poses(file)?));
        Ok(self)
    }

    /// The calibration that was found, and where, when nobody named it and it lies at no usual place.
    pub(super) fn found(&self) -> Option<(&Path, &Calibration)> {
        self.found.as_deref().map(|file| (file, &self.calibration))
    }

    /// The log's name.
    pub fn name(&self) -> String {
        self.log.name()
    }

    /// Its side of the split.
    pub fn side(&self) -> Side {
        paper_side(&self.name()).unwrap_or(Side::Test)
    }

    /// The samples and the camera; what is to be said of the log is in the remarks.
    ///
    /// # Errors
    /// No calibration that can be used; as [`ImageLog::imu`].
    pub(super) fn recording(&self) -> Result<Recording, ClosedLoopError> {
        let (name, config) = (self.name(), self.camera());
        let camera = CameraModel::try_from(config).of_sequence(&name)?;
        let log = self.log.imu(size(config))?;
        let mut remarks = log.warnings();
        if !log.guesses.is_empty() {
            remarks.push(format!("taken for granted: {}", log.guesses.join(", ")));
        }
        Ok(Recording {
            side: self.side(),
            imu: log.recording.held().map_err(|e| IoError::reading(self.log.path(), e))?,
            camera,
            body_from_cam: config.body_from_cam,
            truth: self.truth.as_ref().map(|(_, poses)| poses.clone()),
            oracle: None,
            remarks,
            name,
        })
    }

    /// The images within `span`, read ahead on a second thread.
    ///
    /// # Errors
    /// As [`ImageLog::images`]; of a folder, images that are listed and not there, unless those are passed over.
    pub(super) fn images(&self, span: &Span) -> Result<ImageStream<'static>, ClosedLoopError> {
        let size = size(self.camera());
        if self.log.is_folder() {
            let coverage = self.log.folder(size)?.coverage();
            if !coverage.is_complete() {
                return Err(SequenceFault::ImagesMissing(Box::new(coverage)).of(self.name()));
            }
        }
        let images = self.log.images(size, ImageSpan { from_s: span.from_s, to_s: span.to_s })?;
        let calibration = self.calibration.clone();
        Ok(Box::new(images.map(move |(t, image)| (calibration.on_imu_clock(t), image))))
    }

    /// SHA-256 over the files that it is read from.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn checksum(&self) -> Result<String, ClosedLoopError> {
        let mut hash = Sha256::new();
        let truth = self.truth.iter().map(|(file, _)| file.clone());
        for path in &self.log.files()?.into_iter().chain(truth).collect::<Vec<_>>() {
            std::fs::File::open(path)
                .and_then(|mut file| std::io::copy(&mut file, &mut hash))
                .map_err(|e| IoError::reading(path, e))?;
        }
        hash.update(self.calibration.checksum());
        Ok(hex(hash.finalize()))
    }

    fn camera(&self) -> &CameraConfig {
        &self.calibration.camera
    }
}

fn size(config: &CameraConfig) -> [usize; 2] {
    config.resolution.map(|side| side as usize)
}
