//! Somebody's true poses, in any of the formats that people have them in.

use super::asl::ground_truth;
use super::pose::rotation;
use super::{IoError, kitti, tum};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use nalgebra::{Isometry3, Translation3};
use std::path::Path;

/// Reads poses in increasing time: ASL's ground truth (commas, nanoseconds, quaternion `w x y z`), a trajectory of TUM's (blanks, seconds, `x y z w`) or KITTI's with
/// stamps (before each pose, or in `times.txt` beside), told apart by their first row.
///
/// # Errors
/// As [`super::read_tum`], and the same of ASL's layout.
pub fn read_poses(path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    let mut rows = bytes.split(|byte| *byte == b'\n');
    let first = rows.find(|row| !row.trim_ascii().is_empty() && !row.trim_ascii_start().starts_with(b"#"));
    if first.is_some_and(kitti::is_kitti) {
        return kitti::parse(&bytes, path);
    }
    if !first.is_some_and(|row| row.contains(&b',')) {
        return tum::parse(&bytes, path);
    }
    let truth = ground_truth::parse(&bytes, path)?;
    Ok(truth.states().iter().map(|s| StampedPose { t: s.t, world_from_body: s.world_from_body }).collect())
}

/// Reads poses that have no stamps, counted: the first at 0 s, the next at 1 s. `None` where the file is not KITTI's of twelve columns.
///
/// # Errors
/// As [`read_poses`].
pub fn read_counted_poses(path: &Path) -> Result<Option<Vec<StampedPose>>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    kitti::parse_counted(&bytes, path)
}

/// A pose of numbers, the quaternion as `w x y z`; none where they are not finite or the quaternion is no rotation.
pub fn stamped_pose(t: Stamp, [x, y, z]: [f64; 3], quaternion: [f64; 4]) -> Option<StampedPose> {
    let finite = [x, y, z].iter().all(|v| v.is_finite());
    let rotation = rotation(quaternion).ok().filter(|_| finite)?;
    Some(StampedPose { t, world_from_body: Isometry3::from_parts(Translation3::new(x, y, z), rotation) })
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
