//! Trajectories in KITTI's format, which evo reads: the upper three rows of `world_from_body` as twelve numbers a line, no stamps. Two such files are
//! compared line by line.

use super::{IoError, ResultPath, atomic_write};
use nalgebra::Isometry3;

/// Writes poses, all of them or nothing, with as many digits as bring the same bits back.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_kitti<'a>(
    path: impl Into<ResultPath>,
    poses: impl IntoIterator<Item = &'a Isometry3<f64>>,
) -> Result<(), IoError> {
    atomic_write(path, |out| {
        for pose in poses {
            let rows = pose.to_matrix();
            let numbers: Vec<String> = (0..3)
                .flat_map(|row| (0..4).map(move |column| format!("{:?}", rows[(row, column)])))
                .collect();
            writeln!(out, "{}", numbers.join(" "))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_line_is_the_matrix_row_by_row() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.kitti");
        let quarter = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::z() * std::f64::consts::FRAC_PI_2);
        write_kitti(&path, [&quarter, &Isometry3::identity()]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let line: Vec<f64> = text.lines().next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
        for (got, expected) in line.iter().zip([0.0, -1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 3.0])
        {
            assert!((got - expected).abs() < 1e-15, "{text}");
        }
        assert_eq!(text.lines().nth(1), Some("1.0 0.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 0.0 1.0 0.0"));
    }
}
