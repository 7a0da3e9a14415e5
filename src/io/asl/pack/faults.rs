//! What is damaged in a pack.

use super::super::sequence::Sequence;
use super::{DataPack, discover};
use crate::IoError;
use std::sync::Arc;

impl DataPack {
    /// Reads everything: what is damaged, by its part; empty of a pack that is whole.
    ///
    /// # Errors
    /// A pack that cannot be read any more.
    pub fn faults(self) -> Result<Vec<IoError>, IoError> {
        let mut faults: Vec<IoError> =
            self.file.names().filter_map(|name| self.file.check(name).err()).collect();
        if faults.is_empty() {
            // What is as it was written is still held to what a recording may be.
            for sequence in discover::all(&Arc::new(self), "") {
                faults.extend(faults_of(&sequence));
            }
        }
        Ok(faults)
    }
}

fn faults_of(sequence: &Sequence) -> Vec<IoError> {
    let mut faults: Vec<_> = sequence.imu().err().into_iter().collect();
    faults.extend(sequence.imu_config().err());
    faults.extend(sequence.camera_config().err());
    if sequence.has_camera_frames() {
        faults.extend(sequence.camera_frames().err());
    }
    if sequence.ground_truth_path().is_some() {
        faults.extend(sequence.ground_truth().err());
    }
    faults
}
