//! What a sweep kept of a run: poses and what the estimator believed of them.

use super::error::PaperError;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_eval::closed_loop::{ANCHOR, SequenceFault, paired};
use dpn_eval::metrics::{AlignmentKind, MetricsError, PosePair, align, start_alignment};
use dpn_io::ResultPath;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// A pose and the deviations believed of its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EstimatedPose {
    pub(super) pose: StampedPose,
    /// Of x, y, z in the estimate's world \[m\]; none where the estimator gave no covariance.
    pub(super) position_std: Option<[f64; 3]>,
}

/// Columns of a states file: stamp, phase, position, quaternion (w x y z), velocity, biases, deviations of position.
const POSITION: usize = 2;
const POSITION_STD: usize = 18;

/// Fewest poses that are drawn.
const FEWEST: usize = 10;

/// What a sweep kept of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct States {
    /// The frames with a pose.
    pub(super) poses: Vec<EstimatedPose>,
    /// The pose that the estimator took for known.
    pub(super) anchor: Option<StampedPose>,
}

/// Reads a file that a sweep wrote.
pub(super) fn read(path: &ResultPath) -> Result<States, PaperError> {
    let bytes = path.read_existing()?;
    let text = String::from_utf8_lossy(&bytes);
    let mut found = States { poses: Vec::new(), anchor: None };
    for (line, text) in (1..).zip(text.lines()) {
        let stale = |what: &str| PaperError::Stale {
            path: path.path().to_path_buf(),
            message: format!("line {line} is not {what}"),
        };
        if let Some(anchor) = text.strip_prefix(ANCHOR) {
            let anchor = pose(&anchor.split(',').collect::<Vec<_>>(), 1);
            found.anchor = Some(anchor.ok_or_else(|| stale("an anchor"))?);
        }
        if text.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = text.split(',').collect();
        // A frame without a pose has empty cells.
        if cells.get(POSITION) != Some(&"") {
            found.poses.push(estimated(&cells).ok_or_else(|| stale("a frame's state"))?);
        }
    }
    Ok(found)
}

fn number(cells: &[&str], at: usize) -> Option<f64> {
    cells.get(at)?.parse().ok()
}

fn three(cells: &[&str], at: usize) -> Option<[f64; 3]> {
    Some([number(cells, at)?, number(cells, at + 1)?, number(cells, at + 2)?])
}

/// Stamp in the first cell, position and quaternion from `at` on.
fn pose(cells: &[&str], at: usize) -> Option<StampedPose> {
    let position = three(cells, at)?;
    let (w, [x, y, z]) = (number(cells, at + 3)?, three(cells, at + 4)?);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let translation = Translation3::from(Vector3::from(position));
    let t = Stamp::from_ns(cells.first()?.parse().ok()?);
    Some(StampedPose { t, world_from_body: Isometry3::from_parts(translation, rotation) })
}

fn estimated(cells: &[&str]) -> Option<EstimatedPose> {
    let position_std = match *cells.get(POSITION_STD)? {
        "" => None,
        _ => Some(three(cells, POSITION_STD)?),
    };
    Some(EstimatedPose { pose: pose(cells, POSITION)?, position_std })
}

/// A run beside the truth.
#[derive(Debug, Clone)]
pub(super) struct PairedRun {
    /// Pairs in increasing time.
    pub(super) pairs: Vec<PosePair>,
    /// Beliefs of each pair's estimate.
    pub(super) position_std: Vec<Option<[f64; 3]>>,
    /// The pose that the estimator took for known, beside the truth.
    pub(super) anchor: Option<PosePair>,
}

impl PairedRun {
    /// Pairs states with the truth; nothing where fewer than ten do, as in a run that never had a pose.
    pub(super) fn new(
        sequence: &str,
        truth: &[StampedPose],
        states: &States,
    ) -> Result<Option<Self>, PaperError> {
        if states.poses.len() < FEWEST {
            return Ok(None);
        }
        let poses: Vec<StampedPose> = states.poses.iter().map(|s| s.pose).collect();
        let refused = |source| SequenceFault::Metrics(source).of(sequence);
        let pairs = paired(truth, &poses).map_err(refused)?;
        let anchor = match &states.anchor {
            Some(anchor) => paired(truth, std::slice::from_ref(anchor)).map_err(refused)?.first().copied(),
            None => None,
        };
        let std = |pair: &PosePair| states.poses[pair.estimate_index].position_std;
        let position_std = pairs.iter().map(std).collect();
        Ok((pairs.len() >= FEWEST).then_some(Self { pairs, position_std, anchor }))
    }

    /// Estimated positions after SE(3) alignment; nothing where that leaves a freedom.
    pub(super) fn aligned(&self) -> Result<Option<Vec<[f64; 3]>>, MetricsError> {
        let map = match align(&self.pairs, AlignmentKind::Se3) {
            Err(MetricsError::Degenerate { .. }) => return Ok(None),
            map => map?,
        };
        let position = |p: &PosePair| map.apply(&p.est_world_from_body).translation.vector.into();
        Ok(Some(self.pairs.iter().map(position).collect()))
    }

    /// Errors of position in the truth's world, both agreeing at the pose that the estimator took for known (the first pair where there is
    /// none), and three times the deviation believed, which is about that pose.
    pub(super) fn errors(&self) -> Vec<([f64; 3], Option<[f64; 3]>)> {
        let map = start_alignment(self.anchor.as_ref().unwrap_or(&self.pairs[0]));
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
        let anchor = "#anchor,4,7.0,8.0,9.0,1.0,0.0,0.0,0.0";
        let text = format!("#head\n{anchor}\n{empty}\n{}\n{}\n", line(5, 1.5), line(6, 1.6));
        std::fs::write(&path, text).unwrap();
        let states = read(&ResultPath::from(&path)).unwrap();
        assert_eq!(states.poses.len(), 2);
        assert_eq!(states.poses[0].position_std, Some([0.1, 0.2, 0.3]));
        assert_eq!(states.poses[1].pose.world_from_body.translation.x, 1.6);
        let anchor = states.anchor.unwrap();
        assert_eq!((anchor.t.ns(), anchor.world_from_body.translation.z), (4, 9.0));
        let whole = line(5, 1.5);
        let cut = &whole[..whole.find(",0.1,").unwrap()];
        for broken in ["5,tracking,1,2,x", "5,tracking", cut, &whole.replace(",0.1,", ",x,")] {
            std::fs::write(&path, format!("{broken}\n")).unwrap();
            let error = read(&ResultPath::from(&path)).unwrap_err().to_string();
            assert!(error.contains("line 1 is not a frame's state; remove it"), "{broken}: {error}");
        }
        std::fs::write(&path, "#anchor,4,7.0\n").unwrap();
        assert!(read(&ResultPath::from(&path)).unwrap_err().to_string().contains("line 1 is not an anchor"));
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
        let poses: Vec<EstimatedPose> = truth
            .iter()
            .map(|p| EstimatedPose {
                pose: StampedPose { t: p.t, world_from_body: moved * p.world_from_body },
                position_std: Some([0.1; 3]),
            })
            .collect();
        let states = States { poses, anchor: None };
        let beside = PairedRun::new("a", &truth, &states).unwrap().unwrap();
        for ((error, band), aligned) in beside.errors().iter().zip(beside.aligned().unwrap().unwrap()) {
            assert!(error.iter().all(|e| e.abs() < 1e-9), "{error:?}");
            assert!(band.unwrap().iter().all(|b| (b - 0.3).abs() < 1e-12));
            assert!(aligned.iter().all(|v| v.is_finite()));
        }
        for count in [0, 5] {
            let few = States { poses: states.poses[..count].to_vec(), anchor: None };
            assert!(PairedRun::new("a", &truth, &few).unwrap().is_none(), "{count} poses");
        }
    }
}
