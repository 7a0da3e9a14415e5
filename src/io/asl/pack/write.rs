//! A folder of sequences into a pack.

use super::super::sequence::{CAMERA_DATA, CAMERA_SENSOR, IMU_DATA, IMU_SENSOR, Sequence};
use super::discover::{in_pack, split};
use super::manifest::{Manifest, PackedSequence};
use super::packed::{OF_SAMPLE, of_state};
use super::{DataPack, FORMAT, NAMES, STAMPS, VALUES};
use crate::IoError;
use crate::column_file::{Column, ColumnFileError, write};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Packs every sequence under `dir` into `out`, as [`discover`](super::super::discover()) finds them: whole or not at all, the same bytes each time. Every file is read
/// as it always is, and one that does not read ends it.
///
/// # Errors
/// No sequence; a file that cannot be read or holds what it may not; a folder that is a pack already; whatever keeps `out` from being written.
pub fn pack(dir: &Path, out: &Path) -> Result<DataPack, IoError> {
    if split(dir).is_some() {
        let (path, found) = (dir.to_path_buf(), "no folder".to_owned());
        return Err(ColumnFileError::Foreign { path, found, wanted: "folder of sequences" }.into());
    }
    let mut columns = BTreeMap::new();
    let mut sequences = BTreeMap::new();
    for sequence in super::super::discover(dir)? {
        let (key, packed) = add(&sequence, dir, &mut columns)?;
        sequences.insert(key, packed);
    }
    let full = dir.canonicalize().map_err(|e| IoError::reading(dir, e))?;
    let name = full.file_name().unwrap_or(full.as_os_str()).to_string_lossy().into_owned();
    let manifest = Manifest { name, folder: seen_from(out, full), sequences };
    write(out, FORMAT, &manifest, &columns)?;
    DataPack::open(out)
}

/// The folder `full` as the file `out` may call it: what lies below that file's own folder moves with it.
fn seen_from(out: &Path, full: PathBuf) -> PathBuf {
    let own = out.parent().filter(|own| !own.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let own = own.canonicalize();
    own.ok().and_then(|own| full.strip_prefix(own).map(Path::to_path_buf).ok()).unwrap_or(full)
}

fn add(
    sequence: &Sequence,
    dir: &Path,
    columns: &mut BTreeMap<String, Column>,
) -> Result<(String, PackedSequence), IoError> {
    let relative = |path: &Path| in_pack(path.strip_prefix(dir).expect("it was found below the folder"));
    let (own, root) = (relative(sequence.dir()), relative(sequence.root()));
    // A folder that is a sequence itself.
    let key = if own.is_empty() { sequence.name().to_owned() } else { own };
    let mut files = BTreeMap::new();
    let mut keep = |file: &str, parts: Vec<(&str, Column)>| -> Result<(), IoError> {
        files.insert(file.to_owned(), sequence.checksum_of(file)?);
        for (name, column) in parts {
            let end = if name.is_empty() { String::new() } else { format!("/{name}") };
            columns.insert(format!("{key}/{file}{end}"), column);
        }
        Ok(())
    };
    let imu = sequence.imu()?;
    let mut numbers = Vec::with_capacity(OF_SAMPLE * imu.len());
    imu.samples().iter().for_each(|sample| numbers.extend(sample.gyro.iter().chain(&sample.accel)));
    let stamps = imu.samples().iter().map(|sample| sample.t.ns()).collect();
    keep(IMU_DATA, vec![(STAMPS, Column::I64(stamps)), (VALUES, Column::F64(OF_SAMPLE, numbers))])?;
    if let Some(file) = sequence.published_truth() {
        let truth = sequence.ground_truth()?;
        let stamps = truth.states().iter().map(|state| state.t.ns()).collect();
        let numbers: Vec<f64> = truth.states().iter().flat_map(of_state).collect();
        let width = numbers.len() / truth.states().len();
        keep(file, vec![(STAMPS, Column::I64(stamps)), (VALUES, Column::F64(width, numbers))])?;
    }
    if sequence.has_camera_frames() {
        let frames = sequence.camera_frames()?;
        let stamps = frames.iter().map(|frame| frame.t.ns()).collect();
        let names: String = frames.iter().map(|frame| format!("{}\n", frame.file)).collect();
        keep(CAMERA_DATA, vec![(STAMPS, Column::I64(stamps)), (NAMES, Column::Bytes(names.into_bytes()))])?;
    }
    // Read once, so that what cannot be read is found here and not on a node.
    if sequence.imu_config()?.is_some() {
        keep(IMU_SENSOR, vec![("", Column::Bytes(text(sequence, IMU_SENSOR)?))])?;
    }
    if sequence.camera_config()?.is_some() {
        keep(CAMERA_SENSOR, vec![("", Column::Bytes(text(sequence, CAMERA_SENSOR)?))])?;
    }
    Ok((key, PackedSequence { name: sequence.name().to_owned(), root, files }))
}

fn text(sequence: &Sequence, file: &str) -> Result<Vec<u8>, IoError> {
    crate::small::read_config(&sequence.root().join(file))
}
