//! One recording as ASL's folder layout keeps it, its parts read when asked for.

use super::camera::{self, CameraFrame};
use super::ground_truth;
use super::imu_config::{self, ImuConfig};
use crate::calibration::Calibration;
use crate::imu_csv::parse_with;
use crate::understood::CsvOptions;
use crate::{IoError, TimeUnit};
use dpn_core::camera::CameraConfig;
use dpn_core::checksum::of_source;
use dpn_core::imu::ImuRecording;
use dpn_core::truth::GroundTruth;
use std::path::{Path, PathBuf};

/// Where the inertial samples are, below `mav0` or the folder itself.
pub(super) const IMU_DATA: &str = "imu0/data.csv";
pub(super) const IMU_SENSOR: &str = "imu0/sensor.yaml";
pub(super) const CAMERA_DATA: &str = "cam0/data.csv";
pub(super) const CAMERA_SENSOR: &str = "cam0/sensor.yaml";
/// Where ground truth may be, best first: EuRoC's estimate, TUM-VI's motion capture.
pub(super) const GROUND_TRUTH: [&str; 2] = ["state_groundtruth_estimate0/data.csv", "mocap0/data.csv"];

/// A folder with an IMU recording and what belongs to it. Opening looks for the IMU file only; nothing is read yet, and every call reads its file anew.
#[derive(Debug, Clone)]
pub struct Sequence {
    name: String,
    dir: PathBuf,
    root: PathBuf,
    /// A reconciled ground truth in place of the published one.
    reconciled: Option<PathBuf>,
    /// A calibration in place of `cam0/sensor.yaml`.
    calibration: Option<Calibration>,
}

impl Sequence {
    /// The sequence in the folder `dir`; `None` where there is none.
    pub(super) fn at(dir: &Path) -> Option<Self> {
        let root =
            [dir.join("mav0"), dir.to_path_buf()].into_iter().find(|root| root.join(IMU_DATA).is_file())?;
        Some(Self { name: name_of(dir), dir: dir.to_path_buf(), root, reconciled: None, calibration: None })
    }

    /// Whether it has this file, a path below its root.
    fn has(&self, file: &str) -> bool {
        self.root.join(file).is_file()
    }

    /// The folder's name, for example `MH_01_easy` or `dataset-room1_512_16`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name people use: TUM-VI's `dataset-room1_512_16` is `room1`; any other name is as it is.
    pub fn short_name(&self) -> &str {
        let name = self.name.strip_prefix("dataset-").unwrap_or(&self.name);
        ["_512_16", "_1024_16"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name)
    }

    /// The same sequence with `NAME.csv` of `dir`, as `dpn truth` writes it, for its ground truth. That it is there is found when it is read.
    #[must_use]
    pub fn with_reconciled_truth(self, dir: &Path) -> Self {
        Self { reconciled: Some(dir.join(format!("{}.csv", self.name))), ..self }
    }

    /// The same sequence with another calibration in place of `cam0/sensor.yaml`; its time offset is added to the camera's stamps.
    #[must_use]
    pub fn with_calibration(self, calibration: Calibration) -> Self {
        Self { calibration: Some(calibration), ..self }
    }

    /// The calibration given in place of its own.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref()
    }

    /// Folder of the reconciled ground truth.
    pub fn reconciled_truth(&self) -> Option<&Path> {
        self.reconciled.as_deref().and_then(Path::parent)
    }

    /// Whether the ground truth is a reconciled one: it is smooth, and made to fit the samples.
    pub fn truth_is_reconciled(&self) -> bool {
        self.reconciled.is_some()
    }

    /// The sequence's folder, as given.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// File of the inertial samples.
    pub fn imu_path(&self) -> PathBuf {
        self.root.join(IMU_DATA)
    }

    /// File of the camera's stamps.
    pub fn camera_path(&self) -> PathBuf {
        self.root.join(CAMERA_DATA)
    }

    /// File of the ground truth: `state_groundtruth_estimate0/data.csv`, else `mocap0/data.csv`; `None` without either.
    pub fn ground_truth_path(&self) -> Option<PathBuf> {
        self.reconciled.clone().or_else(|| self.published_truth().map(|file| self.root.join(file)))
    }

    /// The file of the published ground truth, below the root.
    fn published_truth(&self) -> Option<&'static str> {
        GROUND_TRUTH.into_iter().find(|file| self.has(file))
    }

    /// Whether there are stamps of a camera.
    pub fn has_camera_frames(&self) -> bool {
        self.has(CAMERA_DATA)
    }

    /// SHA-256 of each file that it is read from: samples, ground truth, the camera's calibration and stamps, those that are there.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn checksums(&self) -> Vec<Result<String, IoError>> {
        let mut sums = vec![self.checksum_of(IMU_DATA)];
        match (&self.reconciled, self.published_truth()) {
            (Some(path), _) => sums.push(checksum_of_file(path)),
            (None, Some(file)) => sums.push(self.checksum_of(file)),
            (None, None) => {}
        }
        let own = self.calibration.is_none().then_some(CAMERA_SENSOR);
        let camera = own.into_iter().chain([CAMERA_DATA]).filter(|file| self.has(file));
        sums.extend(camera.map(|file| self.checksum_of(file)));
        sums.extend(self.calibration.iter().map(|given| Ok(given.checksum())));
        sums
    }

    fn checksum_of(&self, file: &str) -> Result<String, IoError> {
        checksum_of_file(&self.root.join(file))
    }

    /// The inertial samples. Columns by the header's names, ASL's order without a header.
    ///
    /// # Errors
    /// As [`crate::read_imu_csv`].
    pub fn imu(&self) -> Result<ImuRecording, IoError> {
        read_imu(&self.imu_path())
    }

    /// What `imu0/sensor.yaml` says; `None` without the file.
    ///
    /// # Errors
    /// A file that cannot be read, lacks a key or holds a value that cannot be.
    pub fn imu_config(&self) -> Result<Option<ImuConfig>, IoError> {
        optional(imu_config::read(&self.root.join(IMU_SENSOR)))
    }

    /// What `cam0/sensor.yaml` says, or the calibration given in its place; `None` without either.
    ///
    /// # Errors
    /// A file that cannot be read, lacks a key or holds a value that cannot be.
    pub fn camera_config(&self) -> Result<Option<CameraConfig>, IoError> {
        match &self.calibration {
            // Few calibrations say how many images there are in a second, and one that is there need not be whole.
            Some(given) => {
                let own = self.own_camera().ok().flatten().map(|own| own.rate);
                let rate = given.rate.or(own).unwrap_or(given.camera.rate);
                Ok(Some(CameraConfig { rate, ..given.camera.clone() }))
            }
            None => self.own_camera(),
        }
    }

    fn own_camera(&self) -> Result<Option<CameraConfig>, IoError> {
        optional(camera::read_config(&self.root.join(CAMERA_SENSOR)))
    }

    /// Stamps and file names of the first camera's images, in increasing time; on the IMU's clock where a calibration says how.
    ///
    /// # Errors
    /// No `cam0/data.csv`; a row that is no frame; stamps that do not increase.
    pub fn camera_frames(&self) -> Result<Vec<CameraFrame>, IoError> {
        let mut frames = camera::read_frames(&self.camera_path())?;
        if let Some(given) = &self.calibration {
            frames.iter_mut().for_each(|frame| frame.t = given.on_imu_clock(frame.t));
        }
        Ok(frames)
    }

    /// Where a frame's image is, when it was unpacked.
    pub fn image_path(&self, frame: &CameraFrame) -> PathBuf {
        self.root.join("cam0/data").join(&frame.file)
    }

    /// The ground truth.
    ///
    /// # Errors
    /// No file of ground truth; a layout that is not known; a row that is no state; stamps that do not increase.
    pub fn ground_truth(&self) -> Result<GroundTruth, IoError> {
        let path = self
            .ground_truth_path()
            .ok_or_else(|| IoError::Missing { path: self.root.join(GROUND_TRUTH[0]) })?;
        ground_truth::read(&path)
    }
}

/// Reads an ASL `imu0/data.csv`; stamps are nanoseconds unless its header says otherwise.
///
/// # Errors
/// As [`crate::read_imu_csv`].
pub(crate) fn read_imu(path: &Path) -> Result<ImuRecording, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse_imu(&bytes, path)
}

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse_imu(bytes: &[u8], path: &Path) -> Result<ImuRecording, IoError> {
    Ok(parse_with(bytes, path, &CsvOptions::default(), Some(TimeUnit::Nanos))?.recording)
}

fn checksum_of_file(path: &Path) -> Result<String, IoError> {
    std::fs::File::open(path).and_then(of_source).map_err(|e| IoError::reading(path, e))
}

/// Turns "the file is not there" into `None`.
fn optional<T>(read: Result<T, IoError>) -> Result<Option<T>, IoError> {
    match read {
        Ok(value) => Ok(Some(value)),
        Err(IoError::Missing { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The folder's own name; a folder given as `.` or as its `mav0` is looked up.
fn name_of(dir: &Path) -> String {
    let full = dir.canonicalize().unwrap_or_else(|_| dir.to_path_buf());
    let named = match full.file_name() {
        Some(name) if name == "mav0" => full.parent().and_then(Path::file_name).unwrap_or(name),
        Some(name) => name,
        None => full.as_os_str(),
    };
    named.to_string_lossy().into_owned()
}
