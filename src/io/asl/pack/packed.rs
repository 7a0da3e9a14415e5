//! One sequence of a pack: its files as the readers of a folder make them.

use super::super::CameraFrame;
use super::{DataPack, NAMES, STAMPS, VALUES};
use crate::IoError;
use dpn_core::imu::{ImuRecording, ImuSample};
use dpn_core::time::Stamp;
use dpn_core::truth::{Biases, GroundTruth, TrueState};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::path::PathBuf;
use std::sync::Arc;

/// A sequence of a pack.
#[derive(Debug, Clone)]
pub(in super::super) struct Packed {
    pack: Arc<DataPack>,
    key: String,
}

/// Numbers of a sample: three axes of the gyroscope, three of the accelerometer.
pub(super) const OF_SAMPLE: usize = 6;

/// The numbers of a true state: position, quaternion w x y z, and in fuller ones velocity, then biases of gyroscope and accelerometer.
pub(super) fn of_state(state: &TrueState) -> Vec<f64> {
    let pose = &state.world_from_body;
    let q = pose.rotation.quaternion();
    let mut values: Vec<f64> = pose.translation.vector.iter().copied().collect();
    values.extend([q.w, q.i, q.j, q.k]);
    values.extend(state.vel_in_world.iter().flatten());
    values.extend(state.biases.iter().flat_map(|b| b.gyro.iter().chain(&b.accel)));
    values
}

impl Packed {
    pub(super) fn new(pack: &Arc<DataPack>, key: &str) -> Self {
        Self { pack: Arc::clone(pack), key: key.to_owned() }
    }

    fn sequence(&self) -> &super::manifest::PackedSequence {
        self.pack.manifest.sequences.get(&self.key).expect("it was made of a key of this pack")
    }

    /// Whether the pack has a file of it.
    pub(in super::super) fn has(&self, file: &str) -> bool {
        self.sequence().files.contains_key(file)
    }

    /// SHA-256 of the file that a part was made of.
    pub(in super::super) fn source_checksum(&self, file: &str) -> Result<String, IoError> {
        self.sequence()
            .files
            .get(file)
            .cloned()
            .ok_or_else(|| IoError::Missing { path: self.pack.file.path().join(&self.key).join(file) })
    }

    /// Root of the sequence in the folder that was packed.
    pub(in super::super) fn root_of_images(&self) -> PathBuf {
        self.pack.folder().join(&self.sequence().root)
    }

    fn name(&self, file: &str, column: &str) -> String {
        format!("{}/{file}/{column}", self.key)
    }

    /// A file that is kept as it is; `None` where there is none.
    pub(in super::super) fn text(&self, file: &str) -> Result<Option<Vec<u8>>, IoError> {
        if !self.has(file) {
            return Ok(None);
        }
        self.pack.file.bytes(&format!("{}/{file}", self.key)).map(Some)
    }

    /// Stamps and rows of `file`, as many of the one as of the other.
    fn table(&self, file: &str, widths: &[usize]) -> Result<(Vec<i64>, usize, Vec<f64>), IoError> {
        let stamps = self.pack.file.i64s(&self.name(file, STAMPS))?;
        let values = self.name(file, VALUES);
        let (width, numbers) = self.pack.file.f64s(&values)?;
        if !widths.contains(&width) || numbers.len() != width * stamps.len() {
            let what =
                format!("has {} numbers in rows of {width} for {} stamps", numbers.len(), stamps.len());
            return Err(self.pack.file.column(&values, what).into());
        }
        Ok((stamps, width, numbers))
    }

    /// The samples.
    pub(in super::super) fn imu(&self, file: &str) -> Result<ImuRecording, IoError> {
        let (stamps, _, numbers) = self.table(file, &[OF_SAMPLE])?;
        let rows = numbers.as_chunks::<OF_SAMPLE>().0;
        let samples = stamps.iter().zip(rows).map(|(t, &[gx, gy, gz, ax, ay, az])| ImuSample {
            t: Stamp::from_ns(*t),
            gyro: [gx, gy, gz],
            accel: [ax, ay, az],
        });
        ImuRecording::new(samples.collect())
            .map_err(|e| self.pack.file.column(&self.name(file, VALUES), e.to_string()).into())
    }

    /// The ground truth.
    pub(in super::super) fn truth(&self, file: &str) -> Result<GroundTruth, IoError> {
        let (stamps, width, numbers) = self.table(file, &[7, 10, 16])?;
        let vector = |row: &[f64]| Vector3::from_column_slice(row);
        let states = stamps.iter().zip(numbers.chunks_exact(width)).map(|(t, row)| TrueState {
            t: Stamp::from_ns(*t),
            world_from_body: Isometry3::from_parts(
                Translation3::from(vector(&row[..3])),
                // As it was read from the file: of length 1 already.
                UnitQuaternion::new_unchecked(Quaternion::new(row[3], row[4], row[5], row[6])),
            ),
            vel_in_world: (width >= 10).then(|| vector(&row[7..10])),
            biases: (width == 16).then(|| Biases { gyro: vector(&row[10..13]), accel: vector(&row[13..16]) }),
        });
        GroundTruth::new(states.collect())
            .map_err(|e| self.pack.file.column(&self.name(file, VALUES), e.to_string()).into())
    }

    /// Stamps and names of the camera's images.
    pub(in super::super) fn frames(&self, file: &str) -> Result<Vec<CameraFrame>, IoError> {
        let stamps = self.pack.file.i64s(&self.name(file, STAMPS))?;
        let column = self.name(file, NAMES);
        let bytes = self.pack.file.bytes(&column)?;
        let text = String::from_utf8_lossy(&bytes);
        let names: Vec<&str> = text.lines().collect();
        let inside = names.iter().all(|name| super::super::camera::stays_inside(name));
        if names.len() != stamps.len() || !inside {
            let what = format!(
                "has {} names of images for {} stamps, or one that is no file's",
                names.len(),
                stamps.len()
            );
            return Err(self.pack.file.column(&column, what).into());
        }
        let frames = stamps.iter().zip(names);
        Ok(frames.map(|(t, file)| CameraFrame { t: Stamp::from_ns(*t), file: file.to_owned() }).collect())
    }
}
