//! What can be wrong with a calibration file.

use crate::IoError;
use crate::noise_formats::FormatError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a calibration could not be read.
#[derive(Debug, Error)]
pub enum CalibrationError {
    /// A file that cannot be read, or an ASL `sensor.yaml` with a fault.
    #[error(transparent)]
    Io(#[from] IoError),
    /// No YAML and no JSON.
    #[error(transparent)]
    Tree(#[from] FormatError),
    /// No keys of a known calibration.
    #[error("{}: no camera calibration of a known kind", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// Several that could be meant.
    #[error("several calibrations of the camera: {files}")]
    Several {
        /// The files.
        files: String,
        /// One of them.
        one: String,
    },
    /// A key is not there.
    #[error("{}: no `{key}`", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The key, with those above it.
        key: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A value that cannot be.
    #[error("{}:{line}: `{key}` {problem}", path.display())]
    Bad {
        /// The file.
        path: PathBuf,
        /// Where it stands.
        line: usize,
        /// The key, with those above it.
        key: String,
        /// What is wrong.
        problem: String,
    },
}

impl CalibrationError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Io(error) => error.hint(),
            Self::Tree(FormatError::Io(IoError::BadYaml { .. })) => Some("a calibration is YAML or JSON; mend the line".to_owned()),
            Self::Tree(FormatError::Io(error)) => error.hint(),
            Self::Tree(_) | Self::Unknown { .. } => Some(
                "known are Kalibr's camchain-imucam.yaml, OpenVINS' kalibr_imucam_chain.yaml and estimator_config.yaml, VINS', ORB-SLAM3's, \
                 Basalt's and OKVIS2's configurations, ASL's cam0/sensor.yaml, and DSO's camera.txt"
                    .to_owned(),
            ),
            Self::Several { one, .. } => Some(format!("say which one: --calib {one}")),
            Self::Missing { remedy, .. } => Some((*remedy).to_owned()),
            Self::Bad { .. } => Some("mend the value as the calibration program wrote it".to_owned()),
        }
    }
}
