//! Trajectories in TUM's format, which evo reads: `t x y z qx qy qz qw` between blanks, t in seconds, comments after `#`.
//!
//! Seconds are text on both sides, never floats: a stamp is read and written to the nanosecond. Positions and quaternions are
//! written with as many digits as bring the same bits back.

use super::decimal::{TimeUnit, seconds_text};
use super::pose::{position, rotation};
use super::row_fault::RowFault;
use super::rows::Rows;
use super::{IoError, ResultPath, atomic_write};
use dpn_core::trajectory::StampedPose;
use nalgebra::Isometry3;
use std::path::Path;

/// Reads a trajectory, in increasing time, at least one pose.
///
/// # Errors
/// A file that cannot be read or holds no row; a row that is not eight finite numbers; a position beyond 1e9 m; a quaternion that is no
/// rotation; stamps that do not increase.
pub fn read_tum(path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path)
}

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let mut rows = Rows::open(bytes, path)?.by_place();
    if rows.width() != 8 {
        return Err(rows.unknown_layout("8 (t x y z qx qy qz qw)"));
    }
    let mut poses: Vec<StampedPose> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let t = rows.stamp_after(poses.last().map(|p| p.t), 0, TimeUnit::Seconds)?;
        let [x, y, z, qx, qy, qz, qw] =
            rows.numbers([1, 2, 3, 4, 5, 6, 7], ["x", "y", "z", "qx", "qy", "qz", "qw"])?;
        let bad = |norm| rows.fault(RowFault::BadQuaternion { norm });
        let rotation = rotation([qw, qx, qy, qz]).map_err(bad)?;
        let position = position([x, y, z]).map_err(|fault| rows.fault(fault))?;
        let world_from_body = Isometry3::from_parts(position, rotation);
        poses.push(StampedPose { t, world_from_body });
    }
    Ok(poses)
}

/// Writes a trajectory, all of it or nothing.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_tum(path: impl Into<ResultPath>, poses: &[StampedPose]) -> Result<(), IoError> {
    atomic_write(path, |out| {
        writeln!(out, "# timestamp tx ty tz qx qy qz qw")?;
        for pose in poses {
            writeln!(out, "{}", tum_line(pose))?;
        }
        Ok(())
    })
}

/// A pose as a line of a trajectory, without its end.
pub fn tum_line(pose: &StampedPose) -> String {
    let (p, q) = (pose.world_from_body.translation.vector, pose.world_from_body.rotation.coords);
    let t = seconds_text(pose.t);
    format!("{t} {:?} {:?} {:?} {:?} {:?} {:?} {:?}", p.x, p.y, p.z, q.x, q.y, q.z, q.w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;
    use nalgebra::{Quaternion, Translation3, UnitQuaternion};
    use proptest::prelude::*;

    fn case(text: &str) -> Result<Vec<StampedPose>, IoError> {
        parse(text.as_bytes(), Path::new("t.tum"))
    }

    #[test]
    fn the_quaternion_is_read_scalar_last() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let poses = case(&format!("# a comment\n1403636625.363555670 1 2 3 0 0 {half} {half}\n")).unwrap();
        assert_eq!(poses[0].t.ns(), 1_403_636_625_363_555_670);
        let x = poses[0].world_from_body * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((x.coords - nalgebra::Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
    }

    #[test]
    fn what_is_no_trajectory_is_refused_with_its_line() {
        let error = |text: &str| case(text).unwrap_err().to_string();
        assert!(error("# c\n1 2 3 4\n").starts_with("t.tum:2: 4 columns; 8 (t x y z"));
        assert!(
            error("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n").starts_with("t.tum:2: time goes from 1000000000")
        );
        assert!(error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 2\n").starts_with("t.tum:2: the quaternion"));
        assert!(error("1 0 0 0 0 0 0 1\n2 0 0 zero 0 0 0 1\n").starts_with("t.tum:2: z is \"zero\""));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back_bit_by_bit(
            t in any::<i64>(),
            p in prop::array::uniform3(-1e9f64..1e9),
            tiny in -1e-300f64..1e-300,
            q in prop::array::uniform4(-1.0f64..1.0),
        ) {
            prop_assume!(q.iter().map(|v| v * v).sum::<f64>() > 1e-6);
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
            let pose = StampedPose {
                t: Stamp::from_ns(t),
                world_from_body: Isometry3::from_parts(Translation3::new(p[0], p[1] * tiny, p[2]), rotation),
            };
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("t.tum");
            write_tum(&path, &[pose]).unwrap();
            prop_assert_eq!(read_tum(&path).unwrap(), vec![pose]);
        }
    }
}
