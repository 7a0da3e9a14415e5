//! Somebody's true poses, in any of the formats that people have them in.

use super::asl::ground_truth;
use super::decimal::TimeUnit;
use super::fields::{self, shown};
use super::pose::{position, rotation};
use super::row_fault::RowFault;
use super::{IoError, kitti, tum};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use nalgebra::Isometry3;
use std::path::Path;

/// More than any stamp in seconds.
const MOST_SECONDS: f64 = 1e11;

/// Reads poses in increasing time: ASL's ground truth (commas, nanoseconds, quaternion `w x y z`), a trajectory of TUM's (blanks, seconds, `x y z w`) or KITTI's with
/// stamps (before each pose, or in `times.txt` beside), told apart by their first row.
///
/// # Errors
/// As [`super::read_tum`], and the same of ASL's layout.
pub fn read_poses(path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path).map_err(of_poses)
}

fn parse(bytes: &[u8], path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).zip(1..);
    let mut rows = lines.filter(|(row, _)| !row.is_empty() && !row.starts_with(b"#"));
    let head = [rows.next(), rows.next()];
    let first = head[0].map(|(row, _)| row);
    if first.is_some_and(kitti::is_kitti) {
        return kitti::parse(bytes, path);
    }
    if !first.is_some_and(|row| row.contains(&b',')) {
        return tum::parse(bytes, path);
    }
    // Seconds between commas: as nanoseconds they would all be one stamp.
    for (row, line) in head.into_iter().flatten() {
        let stamp = row.split(|byte| *byte == b',').next().unwrap_or_default().trim_ascii();
        if fields::number(stamp).is_some_and(|t| t.fract() != 0.0 && t.abs() < MOST_SECONDS) {
            let unit = TimeUnit::Nanos.name();
            return Err(IoError::row(path, line, RowFault::PoseStamp { text: shown(stamp), unit }));
        }
    }
    let truth = ground_truth::parse(bytes, path)?;
    Ok(truth.states().iter().map(|s| StampedPose { t: s.t, world_from_body: s.world_from_body }).collect())
}

/// Reads poses that have no stamps, counted: the first at 0 s, the next at 1 s. `None` where the file is not KITTI's of twelve columns.
///
/// # Errors
/// As [`read_poses`].
pub fn read_counted_poses(path: &Path) -> Result<Option<Vec<StampedPose>>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    kitti::parse_counted(&bytes, path).map_err(of_poses)
}

/// The same error with a trajectory's remedy instead of a log's, which has flags for its columns and units.
fn of_poses(error: IoError) -> IoError {
    let IoError::Row { path, line, fault } = error else { return error };
    let fault = match fault {
        RowFault::UnknownLayout { found, expected } => RowFault::PoseLayout { found, expected },
        RowFault::BadStamp { text, unit } => RowFault::PoseStamp { text, unit },
        other => other,
    };
    IoError::Row { path, line, fault }
}

/// A pose of numbers, the quaternion as `w x y z`; none where they are not finite, further than 1e9 m or the quaternion is no rotation.
pub fn stamped_pose(t: Stamp, [x, y, z]: [f64; 3], quaternion: [f64; 4]) -> Option<StampedPose> {
    let finite = [x, y, z].iter().all(|v| v.is_finite());
    let rotation = rotation(quaternion).ok().filter(|_| finite)?;
    Some(StampedPose { t, world_from_body: Isometry3::from_parts(position([x, y, z]).ok()?, rotation) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(text: &str) -> Result<Vec<StampedPose>, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("truth");
        std::fs::write(&path, text).unwrap();
        read_poses(&path)
    }

    #[test]
    fn both_formats_give_the_same_poses() {
        let asl =
            case("1403636625363555670,1,2,3,0.6,0.8,0,0\n1403636625463555670,1,2,4,0.6,0.8,0,0\n").unwrap();
        let tum = case(
            "# t x y z qx qy qz qw\n1403636625.363555670 1 2 3 0.8 0 0 0.6\n1403636625.463555670 1 2 4 0.8 0 0 0.6\n",
        );
        assert_eq!(asl, tum.unwrap());
        assert_eq!(asl.len(), 2);
    }

    #[test]
    fn what_is_neither_says_so() {
        assert!(case("").is_err());
        assert!(
            case("1,2,3\n").unwrap_err().to_string().contains("8 (stamp, position"),
            "ASL's by its commas"
        );
        assert!(case("1 2 3\n").unwrap_err().to_string().contains("8 (t x y z"), "TUM's by its blanks");
    }
}
