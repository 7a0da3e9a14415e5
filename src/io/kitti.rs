//! Trajectories in KITTI's format, which evo reads: the upper three rows of `world_from_body` as twelve numbers a line, no stamps. Two such files are
//! compared line by line.

use super::IoError;
use super::decimal::TimeUnit;
use super::pose::{position, rigid};
use super::row_fault::RowFault;
use super::rows::Rows;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use std::path::Path;

/// Where the stamps of a file without any stand, beside it: a number of seconds a line.
const TIMES: &str = "times.txt";
/// What the columns may be.
const COLUMNS: &str = "13 (t and three rows of four), or 12 with times.txt beside";

/// Whether a first row is of this format: twelve or thirteen numbers between blanks.
pub(crate) fn is_kitti(row: &[u8]) -> bool {
    matches!(row.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty()).count(), 12 | 13)
}

/// Reads poses whose stamps in seconds stand before each, or, a line each, in `times.txt` beside the file.
///
/// # Errors
/// Files that cannot be read or hold no row; other columns; a matrix that is no pose; as many stamps as poses are needed, and they increase.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Vec<StampedPose>, IoError> {
    let mut rows = Rows::open(bytes, path)?.by_place();
    let stamped = match rows.width() {
        13 => 1,
        12 => 0,
        _ => return Err(rows.unknown_layout(COLUMNS)),
    };
    let times_path = path.with_file_name(TIMES);
    let times_bytes = match stamped {
        0 => std::fs::read(&times_path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => rows.below(RowFault::NoStamps),
            _ => IoError::reading(&times_path, e),
        })?,
        _ => Vec::new(),
    };
    let mut times = (stamped == 0).then(|| Rows::open(&times_bytes, &times_path)).transpose()?;
    all(&mut rows, stamped, |rows, before| match &mut times {
        None => rows.stamp_after(before, 0, TimeUnit::Seconds),
        Some(times) => {
            if !times.advance()? {
                return Err(rows.unknown_layout("as many lines in times.txt as poses"));
            }
            times.stamp_after(before, 0, TimeUnit::Seconds)
        }
    })
}

/// The same of a file of twelve columns, whose poses are counted: the first at 0 s, the next at 1 s. `None` where it has other columns.
///
/// # Errors
/// As [`parse`], but for stamps.
pub(crate) fn parse_counted(bytes: &[u8], path: &Path) -> Result<Option<Vec<StampedPose>>, IoError> {
    let mut rows = Rows::open(bytes, path)?.by_place();
    if rows.width() != 12 {
        return Ok(None);
    }
    let next = |before: Option<Stamp>| before.map_or(Stamp::from_ns(0), |t| t.plus_seconds(1.0));
    all(&mut rows, 0, |_, before| Ok(next(before))).map(Some)
}

/// All poses, whose matrices stand behind so many columns, each at the stamp that `stamp` says of its row, given the last.
fn all<'a>(
    rows: &mut Rows<'a>,
    behind: usize,
    mut stamp: impl FnMut(&Rows<'a>, Option<Stamp>) -> Result<Stamp, IoError>,
) -> Result<Vec<StampedPose>, IoError> {
    let mut poses: Vec<StampedPose> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let t = stamp(rows, poses.last().map(|p| p.t))?;
        let names: [String; 12] = std::array::from_fn(|i| format!("m{}{}", i / 4 + 1, i % 4 + 1));
        let columns: [usize; 12] = std::array::from_fn(|i| i + behind);
        let numbers = rows.numbers(columns, names.each_ref().map(String::as_str))?;
        let world_from_body = rigid(&numbers).map_err(|problem| rows.fault(RowFault::BadPose { problem }))?;
        position(world_from_body.translation.vector.into()).map_err(|fault| rows.fault(fault))?;
        poses.push(StampedPose { t, world_from_body });
    }
    Ok(poses)
}

#[cfg(test)]
mod tests {

    #[test]
    fn stamps_stand_before_the_poses_or_beside_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.kitti");
        let row = "0 -1 0 1 1 0 0 2 0 0 1 3";
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            crate::read_poses(&path)
        };
        let stamped = read(&format!("0.5 {row}\n0.75 {row}\n")).unwrap();
        assert!(read(&format!("{row}\n{row}\n")).unwrap_err().to_string().contains("times.txt"));
        std::fs::write(dir.path().join("times.txt"), "0.5\n0.75\n").unwrap();
        assert_eq!(read(&format!("{row}\n{row}\n")).unwrap(), stamped);
        assert_eq!(stamped[1].t.ns(), 750_000_000);
        let turned = stamped[0].world_from_body * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((turned - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
        assert!(read(&format!("{row}\n{row}\n{row}\n")).is_err(), "more poses than stamps");
        assert!(read("0 9 0 1 1 0 0 2 0 0 1 3\n").unwrap_err().to_string().contains("the pose's matrix"));
    }
}
