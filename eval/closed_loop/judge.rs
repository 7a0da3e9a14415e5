//! From a finished run and the truth to a row.

use super::drive::EstimatorOutput;
use super::error::{ClosedLoopError, OfSequence};
use super::image_report::FrontEndFigures;
use super::recording::{Recording, Span, first_motion};
use super::row::{Failure, Restart, Row, StageSeconds, TruthKind};
use super::sequence_set::SequenceSet;
use crate::metrics::{
    AlignmentKind, Interpolation, MetricsError, PoseNees, PosePair, RPE_TOLERANCE, RpeStep, TruthOptions,
    TruthTrack, associate_interpolated, ate, nees, rpe, scale_error, start_alignment,
};
use crate::noise::MeanSquare;
use crate::stats::percentile;
use dpn_core::estimate::NoiseSpec;
use dpn_core::time::median_step_s;
use dpn_core::trajectory::StampedPose;
use dpn_core::{NoiseTrack, Sensor, Stamp};
use dpn_vio::estimator::Stage;
use nalgebra::Matrix6;

/// True poses farther apart than this have none between them \[s\].
pub const MAX_GAP_S: f64 = 0.1;
/// Ground truth slower than this is interpolated by a cubic \[s\].
const SLOW_TRUTH_S: f64 = 0.01;
/// A run whose error exceeds this share of the true path is lost.
const LOST_SHARE: f64 = 0.05;
/// A run with poses at fewer of the frames since its first one is none.
const FEW_POSES: f64 = 0.5;
/// Fewest pairs of poses that are judged.
const FEWEST_PAIRS: usize = 10;

/// Errors of a trajectory against the truth; what could not be computed is `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Errors {
    /// RMSE after SE(3) alignment \[m\].
    pub ate_se3: Option<f64>,
    /// After alignment of yaw and position \[m\].
    pub ate_yaw: Option<f64>,
    /// After Sim(3) alignment \[m\].
    pub ate_sim3: Option<f64>,
    /// RMSE of orientations after SE(3) alignment \[deg\].
    pub rotation_deg: Option<f64>,
    /// Metres of the truth to one of the estimate, minus 1; above 0 the estimate is too small.
    pub scale_error: Option<f64>,
    /// RMSE of positions over the stretches of [`RpeStep::USUAL`] \[m\]: 5, 10, 20, 40 m, 1, 5 s.
    pub rpe: [Option<f64>; 6],
    /// NEES of the poses, where they have covariances.
    pub nees: Option<Vec<PoseNees>>,
    /// Length of the true path under the poses \[m\].
    pub path_m: f64,
}

impl Errors {
    /// Of `estimate`, whose poses may have covariances; these are about `anchor`, the pose that the estimator took for known, or about
    /// the first pose.
    ///
    /// # Errors
    /// Truth or estimate with values that are not finite or stamps that do not increase.
    pub fn of(
        truth: &[StampedPose],
        estimate: &[StampedPose],
        covariances: Option<&[Matrix6<f64>]>,
        anchor: Option<&StampedPose>,
    ) -> Result<Self, MetricsError> {
        if estimate.len() < FEWEST_PAIRS {
            return Ok(Self::default());
        }
        let track = truth_track(truth)?;
        let pairs = associate_interpolated(&track, estimate)?.pairs;
        if pairs.len() < FEWEST_PAIRS {
            return Ok(Self::default());
        }
        let aligned = |kind| determined(ate(&pairs, kind));
        let se3 = aligned(AlignmentKind::Se3)?;
        let mut errors = Self {
            ate_se3: se3.as_ref().map(|ate| ate.translation.rmse),
            ate_yaw: aligned(AlignmentKind::YawPosition)?.map(|ate| ate.translation.rmse),
            ate_sim3: aligned(AlignmentKind::Sim3)?.map(|ate| ate.translation.rmse),
            rotation_deg: se3.map(|ate| ate.rotation.rmse.to_degrees()),
            scale_error: determined(scale_error(&pairs))?,
            path_m: path_length(&pairs),
            ..Self::default()
        };
        for (value, step) in errors.rpe.iter_mut().zip(RpeStep::USUAL) {
            *value = rpe(&pairs, step, RPE_TOLERANCE)?.map(|rpe| rpe.translation.rmse);
        }
        if let Some(covariances) = covariances {
            errors.nees = match all_nees(&track, &pairs, covariances, anchor) {
                // A mean over the others would be about another run.
                Err(MetricsError::NotPositiveDefinite { .. }) => None,
                nees => Some(nees?),
            };
        }
        Ok(errors)
    }
}

/// The truth as runs are judged against it: interpolated, not across gaps.
fn truth_track(truth: &[StampedPose]) -> Result<TruthTrack<'_>, MetricsError> {
    let slow = median_step_s(truth.iter().map(|pose| pose.t)).is_some_and(|step| step > SLOW_TRUTH_S);
    let interpolation = if slow { Interpolation::Cubic } else { Interpolation::Linear };
    TruthTrack::new(truth, TruthOptions { max_gap_s: MAX_GAP_S, interpolation })
}

/// Pairs of a true and an estimated pose, as runs are judged by them.
///
/// # Errors
/// Truth or estimate with values that are not finite or stamps that do not increase.
pub fn paired(truth: &[StampedPose], estimate: &[StampedPose]) -> Result<Vec<PosePair>, MetricsError> {
    Ok(associate_interpolated(&truth_track(truth)?, estimate)?.pairs)
}

/// A straight line leaves an alignment open: a figure that is not there, no fault. Everything else is one.
fn determined<T>(figure: Result<T, MetricsError>) -> Result<Option<T>, MetricsError> {
    match figure {
        Ok(figure) => Ok(Some(figure)),
        Err(MetricsError::Degenerate { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// NEES of a run's poses: those of `estimate` that have a truth, under covariances about `anchor`, or about the first pose, which is left out then.
///
/// # Errors
/// Truth or estimate that are no trajectories; fewer than two poses with a truth; as [`nees`].
pub fn run_nees(
    truth: &[StampedPose],
    estimate: &[StampedPose],
    covariances: &[Matrix6<f64>],
    anchor: Option<&StampedPose>,
) -> Result<Vec<PoseNees>, MetricsError> {
    let track = truth_track(truth)?;
    let pairs = associate_interpolated(&track, estimate)?.pairs;
    if pairs.len() < 2 {
        return Err(MetricsError::TooFewPairs { what: "NEES", needed: 2, found: pairs.len() });
    }
    all_nees(&track, &pairs, covariances, anchor)
}

/// Of all poses. The anchor fixes the gauge; without one, or without a truth there, the first pose does and is left out.
fn all_nees(
    track: &TruthTrack<'_>,
    pairs: &[PosePair],
    covariances: &[Matrix6<f64>],
    anchor: Option<&StampedPose>,
) -> Result<Vec<PoseNees>, MetricsError> {
    let anchor = match anchor {
        Some(anchor) => associate_interpolated(track, std::slice::from_ref(anchor))?.pairs.first().copied(),
        None => None,
    };
    let (first, rest) = pairs.split_first().expect("too few pairs were left out before");
    let (gauge, judged) = anchor.as_ref().map_or((first, rest), |anchor| (anchor, pairs));
    nees(judged, covariances, &start_alignment(gauge))
}

fn mean(nees: Option<&Vec<PoseNees>>, part: impl Fn(&PoseNees) -> f64) -> Option<f64> {
    let nees = nees.filter(|nees| !nees.is_empty())?;
    Some(nees.iter().map(part).sum::<f64>() / nees.len() as f64)
}

fn path_length(pairs: &[PosePair]) -> f64 {
    let position = |p: &PosePair| p.true_world_from_body.translation.vector;
    pairs.windows(2).map(|w| (position(&w[1]) - position(&w[0])).norm()).sum()
}

/// What a run was told.
#[derive(Debug, Clone, PartialEq)]
pub struct RunInfo {
    /// Where the images came from.
    pub camera: String,
    /// What the recording's ground truth is, where it has one.
    pub truth: TruthKind,
    /// The noise spec.
    pub noise: NoiseSpec,
    /// The seed.
    pub seed: u64,
    /// Seconds after the first frame.
    pub from_s: f64,
    /// Where it was told to end, in the same seconds.
    pub to_s: Option<f64>,
    /// What the front-end made of the images, where there are any.
    pub front_end: Option<FrontEndFigures>,
}

impl RunInfo {
    /// Of a run over one of `source`'s sequences.
    pub fn new(source: &SequenceSet, noise: &NoiseSpec, seed: u64, span: &Span) -> Self {
        Self {
            camera: source.camera().into(),
            truth: source.truth(),
            noise: noise.clone(),
            seed,
            from_s: span.from_s,
            to_s: span.to_s,
            front_end: None,
        }
    }
}

/// A finished run, judged.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Its row.
    pub row: Row,
    /// NEES of its poses, where they have covariances.
    pub nees: Option<Vec<PoseNees>>,
}

/// The row of a finished run.
///
/// # Errors
/// As [`Errors::of`].
pub fn judge(
    recording: &Recording,
    info: &RunInfo,
    output: &EstimatorOutput,
) -> Result<Judged, ClosedLoopError> {
    let poses = output.poses();
    let covariances = output.covariances();
    let errors = match &recording.truth {
        Some(truth) => Errors::of(truth, &poses, covariances.as_deref(), output.report.anchor.as_ref())
            .of_sequence(&recording.name)?,
        None => Errors::default(),
    };
    let report = &output.report;
    let first_frame = *output.frames.first().expect("no run without frames is begun");
    let since_first = |t: Stamp| t.seconds_since(first_frame);
    let p95_update_s = percentile(&output.update_cpu_s, 0.95);
    let completion = report.completion();
    let [rpe_5m, rpe_10m, rpe_20m, rpe_40m, rpe_1s, rpe_5s] = errors.rpe;
    let seconds = |stage: Stage| report.seconds[stage as usize];
    let row = Row {
        sequence: recording.name.clone(),
        split: recording.side,
        cell: String::new(),
        camera: info.camera.clone(),
        truth: recording.truth.as_ref().map(|_| info.truth),
        noise: info.noise.clone(),
        seed: info.seed,
        from_s: info.from_s,
        failure: failure(recording.truth.is_some(), &errors, poses.len(), completion),
        ate_se3: errors.ate_se3,
        ate_yaw: errors.ate_yaw,
        ate_sim3: errors.ate_sim3,
        rotation_deg: errors.rotation_deg,
        scale_error: errors.scale_error,
        rpe_1s,
        rpe_5s,
        rpe_5m,
        rpe_10m,
        rpe_20m,
        rpe_40m,
        nees_position: mean(errors.nees.as_ref(), |n| n.position),
        nees_orientation: mean(errors.nees.as_ref(), |n| n.orientation),
        completion,
        init_s: report.initialised.map(since_first),
        init_in_motion_s: in_motion(recording, first_frame, report.initialised),
        restarts: report.restarts.len(),
        restart_reasons: report.restarts.iter().map(|(t, r)| Restart::new(since_first(*t), r)).collect(),
        whitened: report.whitened_mean(),
        iterations: (report.poses > 0).then(|| report.iterations as f64 / report.poses as f64),
        outliers: report.outliers,
        frames: output.frames.len(),
        poses: poses.len(),
        noise_rms: None,
        noise_doubts: Vec::new(),
        cpu_per_data_s: output.cpu_s / output.data_s,
        p95_update_ms: 1e3 * p95_update_s.expect("frames that have samples are worked off"),
        stage_s: StageSeconds {
            feed: seconds(Stage::Feed),
            initialise: seconds(Stage::Initialise),
            solve: seconds(Stage::Solve),
            reject: seconds(Stage::Reject),
            slide: seconds(Stage::Slide),
        },
        front_end: info.front_end.clone(),
    };
    Ok(Judged { row, nees: errors.nees })
}

/// From the first motion to the first pose.
fn in_motion(recording: &Recording, first_frame: Stamp, initialised: Option<Stamp>) -> Option<f64> {
    let motion = first_motion(recording.truth.as_deref()?, first_frame)?;
    Some(initialised?.seconds_since(motion).max(0.0))
}

fn failure(judged: bool, errors: &Errors, poses: usize, completion: Option<f64>) -> Option<Failure> {
    if poses < FEWEST_PAIRS || (judged && errors.ate_se3.is_none()) {
        return Some(Failure::NoPose);
    }
    if completion.is_some_and(|share| share < FEW_POSES) {
        return Some(Failure::FewPoses);
    }
    let lost = errors.ate_se3.is_some_and(|ate| ate > LOST_SHARE * errors.path_m);
    lost.then_some(Failure::Diverged)
}

/// Root mean square of the noise told: accelerometer x, y, z, gyroscope x, y, z.
pub(super) fn noise_rms(track: &NoiseTrack) -> [[f64; 3]; 2] {
    let mut mean = MeanSquare::default();
    mean.add(track);
    let noise = mean.root().expect("a recording has samples, and each a noise");
    Sensor::ALL.map(|sensor| noise.of(sensor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector3};

    fn circle(radius: f64, scale: f64) -> Vec<StampedPose> {
        (0..400)
            .map(|i| {
                let angle = 0.05 * f64::from(i);
                let position = Vector3::new(angle.cos(), angle.sin(), 0.1 * angle.sin()) * radius * scale;
                StampedPose {
                    t: Stamp::from_ns(i64::from(i) * 50_000_000),
                    world_from_body: Isometry3::new(position, Vector3::z() * angle.sin()),
                }
            })
            .collect()
    }

    #[test]
    fn a_scaled_circle_has_its_scale_as_error_and_none_after_sim3() {
        let (truth, estimate) = (circle(5.0, 1.0), circle(5.0, 0.8));
        let errors = Errors::of(&truth, &estimate, None, None).unwrap();
        assert!((errors.scale_error.unwrap() - 0.25).abs() < 1e-9);
        assert!(errors.ate_sim3.unwrap() < 1e-9);
        assert!((errors.ate_se3.unwrap() - 1.0).abs() < 0.01, "{errors:?}");
        assert!((errors.path_m - 100.0).abs() < 1.0);
        // 1 m of 100 m is not lost, 6 m are.
        assert_eq!(failure(true, &errors, 400, Some(1.0)), None);
        let lost = Errors { ate_se3: Some(6.0), ..errors.clone() };
        assert_eq!(failure(true, &lost, 400, Some(1.0)), Some(Failure::Diverged));
    }

    #[test]
    fn a_straight_line_has_no_alignment_and_a_fault_of_the_input_is_one() {
        let line: Vec<StampedPose> = (0..400)
            .map(|i| StampedPose {
                t: Stamp::from_ns(i64::from(i) * 50_000_000),
                world_from_body: Isometry3::new(Vector3::x() * 0.1 * f64::from(i), Vector3::zeros()),
            })
            .collect();
        let errors = Errors::of(&line, &line, None, None).unwrap();
        assert_eq!((errors.ate_se3, errors.rpe[4]), (None, Some(0.0)), "{errors:?}");
        let covariances = [Matrix6::identity(); 3];
        let error = Errors::of(&circle(5.0, 1.0), &circle(5.0, 1.0), Some(&covariances), None).unwrap_err();
        assert!(matches!(error, MetricsError::CovarianceMissing { covariances: 3, .. }), "{error}");
        // A covariance that is none costs the run its NEES, and nothing else.
        let flat = vec![Matrix6::zeros(); 400];
        let errors = Errors::of(&circle(5.0, 1.0), &circle(5.0, 1.0), Some(&flat), None).unwrap();
        assert!(errors.nees.is_none() && errors.ate_se3.is_some());
    }

    #[test]
    fn too_few_poses_are_a_failure_with_or_without_truth() {
        assert_eq!(failure(false, &Errors::default(), 3, Some(1.0)), Some(Failure::NoPose));
        assert_eq!(failure(true, &Errors::default(), 100, Some(1.0)), Some(Failure::NoPose));
        assert_eq!(failure(false, &Errors::default(), 100, Some(0.4)), Some(Failure::FewPoses));
        assert_eq!(failure(false, &Errors::default(), 100, Some(0.6)), None);
    }
}
