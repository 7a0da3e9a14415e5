//! What a sweep kept of a run: poses and what the estimator believed of them.

use super::error::PaperError;
use crate::closed_loop::paired;
use crate::metrics::{Alignment, AlignmentKind, PosePair, align, start_alignment};
use dpn_core::Stamp;
use dpn_core::io::{IoError, StampedPose};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::path::Path;

/// A pose and the deviations believed of its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Believed {
    pub(super) pose: StampedPose,
    /// Of x, y, z in the estimate's world \[m\]; none where the estimator gave no covariance.
    pub(super) position_std: Option<[f64; 3]>,
}

/// Columns of a states file: stamp, phase, position, quaternion (w x y z), velocity, biases, deviations of position.
const POSITION: usize = 2;
const QUATERNION: usize = 5;
const POSITION_STD: usize = 18;

/// The frames with a pose, of a file that a sweep wrote.
pub(super) fn read(path: &Path) -> Result<Vec<Believed>, PaperError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| IoError::Read { path: path.to_path_buf(), source })?;
    let mut found = Vec::new();
    for (line, text) in (1..).zip(text.lines()).filter(|(_, text)| !text.starts_with('#')) {
        let cells: Vec<&str> = text.split(',').collect();
        if cells.get(POSITION).is_none_or(|cell| cell.is_empty()) {
            continue;
        }
        let stale = || PaperError::Stale {
            path: path.to_path_buf(),
            message: format!("line {line} is not a frame's state"),
        };
        found.push(believed(&cells).ok_or_else(stale)?);
    }
    Ok(found)
}

fn believed(cells: &[&str]) -> Option<Believed> {
    let number = |i: usize| cells.get(i)?.parse::<f64>().ok();
    let three = |i: usize| Some([number(i)?, number(i + 1)?, number(i + 2)?]);
    let [w, x] = [number(QUATERNION)?, number(QUATERNION + 1)?];
    let [y, z] = [number(QUATERNION + 2)?, number(QUATERNION + 3)?];
    Some(Believed {
        pose: StampedPose {
            t: Stamp::from_ns(cells.first()?.parse().ok()?),
            world_from_body: Isometry3::from_parts(
                Translation3::from(Vector3::from(three(POSITION)?)),
                UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            ),
        },
        position_std: three(POSITION_STD),
    })
}

/// A run beside the truth.
#[derive(Debug, Clone)]
pub(super) struct Beside {
    /// Pairs in increasing time.
    pub(super) pairs: Vec<PosePair>,
    /// Beliefs of each pair's estimate.
    pub(super) position_std: Vec<Option<[f64; 3]>>,
}

impl Beside {
    /// Pairs states with the truth; nothing where fewer than ten do.
    pub(super) fn new(
        sequence: &str,
        truth: &[StampedPose],
        states: &[Believed],
    ) -> Result<Option<Self>, PaperError> {
        let poses: Vec<StampedPose> = states.iter().map(|s| s.pose).collect();
        let pairs = paired(truth, &poses)
            .map_err(|source| PaperError::Metrics { sequence: sequence.to_owned(), source })?;
        let position_std = pairs.iter().map(|pair| states[pair.estimate_index].position_std).collect();
        Ok((pairs.len() >= 10).then_some(Self { pairs, position_std }))
    }

    /// Estimated positions after SE(3) alignment; as they are where that leaves a freedom.
    pub(super) fn aligned(&self) -> Vec<[f64; 3]> {
        let map = align(&self.pairs, AlignmentKind::Se3).unwrap_or_else(|_| Alignment::identity());
        let position = |p: &PosePair| map.apply(&p.est_world_from_body).translation.vector.into();
        self.pairs.iter().map(position).collect()
    }

    /// Errors of position in the truth's world with both agreeing at the first pair, and three times the deviation believed.
    pub(super) fn errors(&self) -> Vec<([f64; 3], Option<[f64; 3]>)> {
        let map = start_alignment(&self.pairs[0]);
        let turn = map.true_world_from_est_world.rotation;
        let of = |(pair, std): (&PosePair, &Option<[f64; 3]>)| {
            let estimate = map.apply(&pair.est_world_from_body).translation.vector;
            let error = estimate - pair.true_world_from_body.translation.vector;
            // The covariance turned with its world; only its diagonal is kept in the file, so a turn mixes x and y by their variances.
            let band = std.map(|std| {
                let rows = turn.to_rotation_matrix();
                let variance = |row: usize| -> f64 {
                    (0..3).map(|column| (rows[(row, column)] * std[column]).powi(2)).sum()
                };
                [0, 1, 2].map(|row| 3.0 * variance(row).sqrt())
            });
            (error.into(), band)
        };
        self.pairs.iter().zip(&self.position_std).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_read_and_a_broken_line_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        let line = |t: i64, x: f64| {
            let mut cells = vec![t.to_string(), "tracking".into()];
            cells.extend([x, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0].map(|v| v.to_string()));
            cells.extend(std::iter::repeat_n("0".to_owned(), 9));
            cells.extend([0.1, 0.2, 0.3, 0.0, 0.0, 0.0].map(|v| v.to_string()));
            cells.join(",")
        };
        let empty = format!("1,initialising: x{}", ",".repeat(40));
        std::fs::write(&path, format!("#head\n{empty}\n{}\n{}\n", line(5, 1.5), line(6, 1.6))).unwrap();
        let states = read(&path).unwrap();
        assert_eq!(states.len(), 2);
        assert_eq!(states[0].position_std, Some([0.1, 0.2, 0.3]));
        assert_eq!(states[1].pose.world_from_body.translation.x, 1.6);
        std::fs::write(&path, "5,tracking,1,2,x\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("line 1 is not a frame's state; remove it"));
    }

    #[test]
    fn a_run_that_is_the_truth_moved_has_no_error() {
        let truth: Vec<StampedPose> = (0..40)
            .map(|i| {
                let a = 0.1 * f64::from(i);
                StampedPose {
                    t: Stamp::from_ns(50_000_000 * i64::from(i)),
                    world_from_body: Isometry3::new(
                        Vector3::new(a.cos(), a.sin(), 0.1 * a),
                        Vector3::z() * a,
                    ),
                }
            })
            .collect();
        let moved = Isometry3::new(Vector3::new(3.0, -2.0, 1.0), Vector3::z() * 0.7);
        let states: Vec<Believed> = truth
            .iter()
            .map(|p| Believed {
                pose: StampedPose { t: p.t, world_from_body: moved * p.world_from_body },
                position_std: Some([0.1; 3]),
            })
            .collect();
        let beside = Beside::new("a", &truth, &states).unwrap().unwrap();
        for ((error, band), aligned) in beside.errors().iter().zip(beside.aligned()) {
            assert!(error.iter().all(|e| e.abs() < 1e-9), "{error:?}");
            assert!(band.unwrap().iter().all(|b| (b - 0.3).abs() < 1e-12));
            assert!(aligned.iter().all(|v| v.is_finite()));
        }
        assert!(Beside::new("a", &truth, &states[..5]).unwrap().is_none());
    }
}
