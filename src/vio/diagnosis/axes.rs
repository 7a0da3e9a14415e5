//! The camera's rotation between frames against the gyro's.
//!
//! Between two frames a camera's rays turn by `cam_b_from_cam_a`, which the rays alone tell roughly: a rotation fitted to all of them, the
//! worst left out, beside a translation before points of one distance; what distances differ is taken for rotation, now one way and now
//! the other. The gyro tells the same turn in body axes, plus its bias. So over all pairs of frames, means removed,
//!
//! turn_in_body = s * body_from_cam * turn_in_cam,
//!
//! whose best `body_from_cam` (Wahba's problem, by SVD) and scale `s` are compared with the calibration. Where a reflection fits better than any
//! rotation, an axis has the wrong sign or two are swapped.
//! Source: G. Wahba, "A least squares estimate of satellite attitude", SIAM Review 1965; hand-eye calibration by rotations, e.g. J. Furrer et
//! al., "Evaluation of combined time-offset estimation and hand-eye calibration on robotic datasets", FSR 2017.

use dpn_core::camera::CameraModel;
use dpn_core::geometry::so3;
use dpn_core::{ImuSample, TrackFrame};
use nalgebra::{
    Isometry3, Matrix3, Matrix3x6, Matrix6, Rotation3, UnitQuaternion, Vector2, Vector3, Vector6,
};
use serde::Serialize;

/// Fewest tracks that two frames must share.
const FEWEST_TRACKS: usize = 12;
/// Fewest pairs of frames.
const FEWEST_PAIRS: usize = 30;
/// Share of the rays that is left out of a fit as the worst.
const LEFT_OUT: f64 = 0.3;
/// Frames farther apart are not compared \[s\].
const LONGEST_STEP_S: f64 = 0.25;
/// Least turning about the second-strongest axis that lets axes be told \[rad/s, rms\].
const LEAST_TURNING: f64 = 0.05;
/// Turns that agree within this are from a camera mounted as said \[rad\]; parallax alone makes some degrees.
const TURN_TOLERANCE: f64 = 0.21;
/// A mounting that is the inverse of what was said, within this, and thrice as near to it, is that \[rad\]: real tracks tell it to 20 degrees.
const SWAP_TOLERANCE: f64 = 0.5;
/// Scales between this and its inverse are the same.
const SCALE_TOLERANCE: f64 = 1.5;
/// A scale is told where all within so many of its standard errors are outside the tolerance.
const SCALE_CERTAINTY: f64 = 3.0;
/// Errors of the camera's turns are alike over so many pairs: the same points at the same distances, seen again.
const ALIKE_PAIRS: f64 = 10.0;
/// Another reading must lower the residual to this share of that of the calibration.
const BETTER: f64 = 0.8;

/// What the comparison says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "verdict")]
pub enum AxesVerdict {
    /// Camera and gyro turn together as the calibration says.
    Consistent,
    /// Too little turning, or too few tracks, to tell.
    Unknown,
    /// They turn together if the extrinsics are taken the other way about: IMU to camera where camera to IMU belongs.
    Swapped,
    /// They turn together if the camera is mounted otherwise.
    Turned {
        /// By how much \[deg\].
        degrees: f64,
        /// About which axis of the body.
        axis_in_body: [f64; 3],
    },
    /// They turn together if the gyro's axes (or the camera's) are mirrored: one sign is wrong, or two axes are swapped.
    Mirrored,
    /// The gyro reads so many times what the camera sees: 57.3 is degrees for radians.
    Scaled {
        /// The factor.
        factor: f64,
    },
    /// Camera and gyro do not turn together, however mounted: another recording's tracks, clocks apart, or tracks of nothing.
    Unrelated,
}

/// The comparison.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Axes {
    /// What it says.
    pub verdict: AxesVerdict,
    /// Pairs of frames compared.
    pub pairs: usize,
    /// Correlation of both turns as the calibration has them, from -1 to 1.
    pub correlation: f64,
    /// Correlation with the best mounting.
    pub best_correlation: f64,
}

impl Axes {
    /// A sentence for people; `None` where nothing is wrong.
    pub fn warning(&self) -> Option<String> {
        let seen =
            format!("the correlation of camera and gyro rotation is {:.2} as calibrated", self.correlation);
        match self.verdict {
            AxesVerdict::Consistent | AxesVerdict::Unknown => None,
            AxesVerdict::Swapped => Some(format!(
                "the camera's extrinsics are swapped: {seen}, {:.2} with what fits best, which is about the inverse; they must map points in the camera's frame to the IMU's: invert the matrix where it stands (`T_BS` of an ASL sensor.yaml, `T_cam_imu` of Kalibr, the rotation and translation of VINS), or name with --calib the file that the calibration's program wrote: each program's direction is known",
                self.best_correlation
            )),
            AxesVerdict::Turned { degrees, axis_in_body: [x, y, z] } => Some(format!(
                "camera and gyro do not turn about the same axes: {seen}, {:.2} with the camera turned by {degrees:.0} degrees about ({x:.2}, {y:.2}, {z:.2}) in the body; look at the rotation of the extrinsics and at the order of the gyro's axes",
                self.best_correlation
            )),
            AxesVerdict::Mirrored => Some(format!(
                "camera and gyro turn in mirrored axes: {seen}, {:.2} with a reflection; one axis has the wrong sign, or two are swapped",
                self.best_correlation
            )),
            AxesVerdict::Scaled { factor } => Some(format!(
                "the gyro reads {factor:.1} times what the camera sees; angular rates must be in rad/s (degrees make 57.3)"
            )),
            AxesVerdict::Unrelated => Some(format!(
                "camera and gyro do not turn together, however mounted: {seen}; are tracks and IMU of one recording and on one clock?"
            )),
        }
    }
}

/// Compares the turns of camera and gyro.
pub fn axes(
    samples: &[ImuSample],
    frames: &[TrackFrame],
    camera: &CameraModel,
    body_from_cam: &Isometry3<f64>,
) -> Axes {
    let mut meter = AxesMeter::default();
    for pair in frames.windows(2) {
        meter.pair(samples, (&pair[0], &pair[1]), &pair[1].shared(&pair[0]), camera);
    }
    meter.axes(body_from_cam)
}

/// The same of frames as they come: of a pair two rates are kept.
#[derive(Debug, Clone, Default)]
pub struct AxesMeter {
    /// Rates of gyro and camera between neighbouring frames \[rad/s\], each in its own axes.
    turns: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl AxesMeter {
    /// Takes the step from a frame to the next, and what both see, as [`TrackFrame::shared`] gives it; `samples` are all there are.
    pub fn pair(
        &mut self,
        samples: &[ImuSample],
        (a, b): (&TrackFrame, &TrackFrame),
        shared: &[(Vector2<f64>, Vector2<f64>)],
        camera: &CameraModel,
    ) {
        let seconds = b.t.seconds_since(a.t);
        if seconds > LONGEST_STEP_S {
            return;
        }
        let begin = samples.partition_point(|s| s.t < a.t);
        let end = samples.partition_point(|s| s.t <= b.t);
        if begin == 0 || end - begin < 2 || end == samples.len() {
            return;
        }
        let gyro = samples[begin..end].iter().map(|s| Vector3::from(s.gyro)).sum::<Vector3<f64>>();
        let ray = |px| camera.bearing(px);
        let rays = shared.iter().filter_map(|(before, px)| Some((ray(before)?, ray(px)?)));
        if let Some(b_from_a) = rotation_of(rays.collect()) {
            // A camera turning by d carries points by the inverse.
            self.turns.push((gyro / (end - begin) as f64, so3::log(&b_from_a.inverse()) / seconds));
        }
    }

    /// Steps so far that can be compared.
    pub fn pairs(&self) -> usize {
        self.turns.len()
    }

    /// What the steps so far say of a camera mounted so.
    pub fn axes(&self, body_from_cam: &Isometry3<f64>) -> Axes {
        compared(&self.turns, body_from_cam)
    }
}

fn compared(turns: &[(Vector3<f64>, Vector3<f64>)], body_from_cam: &Isometry3<f64>) -> Axes {
    let unknown =
        Axes { verdict: AxesVerdict::Unknown, pairs: turns.len(), correlation: 0.0, best_correlation: 0.0 };
    if turns.len() < FEWEST_PAIRS {
        return unknown;
    }
    let turns = centred(turns);
    let n = turns.len() as f64;
    let (mut cross, mut power_body, mut power_cam) = (Matrix3::zeros(), 0.0, Matrix3::zeros());
    for (body, cam) in &turns {
        cross += body * cam.transpose() / n;
        power_cam += cam * cam.transpose() / n;
        power_body += body.norm_squared() / n;
    }
    let mut spread = power_cam.symmetric_eigenvalues();
    spread.as_mut_slice().sort_by(f64::total_cmp);
    let norm = (power_body * power_cam.trace()).sqrt();
    // By squares: rounding leaves an eigenvalue of a camera at rest below zero, whose root compares with nothing.
    if spread[1] < LEAST_TURNING * LEAST_TURNING || !(norm.is_finite() && norm > 0.0) {
        return unknown;
    }
    let given = body_from_cam.rotation.to_rotation_matrix();
    let (rotation, reflected) = best(&cross);
    // The covariance with the best scale is (sum of what agrees) / norm.
    let agreement = |m: &Matrix3<f64>| (m.transpose() * cross).trace() / norm;
    let (correlation, turned, mirrored) =
        (agreement(given.matrix()), agreement(rotation.matrix()), agreement(&reflected));
    let residual = |correlation: f64| (1.0 - correlation * correlation.abs()).max(0.0);
    let away = rotation * given.inverse();
    let verdict = if mirrored > turned && residual(mirrored) < BETTER * residual(turned.max(correlation)) {
        AxesVerdict::Mirrored
    } else if turned.max(mirrored) < 0.5 {
        AxesVerdict::Unrelated
    } else if away.angle() > TURN_TOLERANCE && residual(turned) < BETTER * residual(correlation) {
        let inverse = given.inverse();
        let (off, as_inverse) = (inverse.angle_to(&rotation), residual(agreement(inverse.matrix())));
        if off < SWAP_TOLERANCE.min(away.angle() / 3.0) && as_inverse < BETTER * residual(correlation) {
            return Axes {
                verdict: AxesVerdict::Swapped,
                pairs: turns.len(),
                correlation,
                best_correlation: turned,
            };
        }
        let axis = away.axis().map_or([0.0; 3], |axis| axis.into_inner().into());
        AxesVerdict::Turned { degrees: away.angle().to_degrees(), axis_in_body: axis }
    } else {
        scale(turned * norm, power_body, power_cam.trace(), n)
    };
    Axes { verdict, pairs: turns.len(), correlation, best_correlation: turned.max(mirrored) }
}

/// Whether the camera's turns are so many times the gyro's, by regression of the camera's on the gyro's: the camera's carry nearly all
/// of the noise, and a ratio of powers takes that noise for turning. `agreement`, `power_body` and `power_cam` are means over `pairs`.
fn scale(agreement: f64, power_body: f64, power_cam: f64, pairs: f64) -> AxesVerdict {
    let slope = agreement / power_body;
    let left_over = (power_cam - slope * agreement).max(0.0);
    let error = SCALE_CERTAINTY * (left_over * ALIKE_PAIRS / (power_body * pairs)).sqrt();
    let outside = slope - error > SCALE_TOLERANCE || slope + error < 1.0 / SCALE_TOLERANCE;
    if outside { AxesVerdict::Scaled { factor: 1.0 / slope } } else { AxesVerdict::Consistent }
}

/// The rotation that carries the first rays to the second, beside a translation before points of one distance; the worst rays left out.
fn rotation_of(mut rays: Vec<(Vector3<f64>, Vector3<f64>)>) -> Option<UnitQuaternion<f64>> {
    let keep = ((1.0 - LEFT_OUT) * rays.len() as f64) as usize;
    if keep < FEWEST_TRACKS {
        return None;
    }
    let cross = rays.iter().map(|(a, b)| b * a.transpose()).sum::<Matrix3<f64>>();
    let mut rotation = UnitQuaternion::from_rotation_matrix(&best(&cross).0);
    let mut shift = Vector3::zeros();
    for round in 0..3 {
        let used = if round == 0 { rays.len() } else { keep };
        let (turn, moved) = step(&rays[..used], &rotation)?;
        rotation = so3::exp(&turn) * rotation;
        shift = moved;
        let off = |(a, b): &(Vector3<f64>, Vector3<f64>)| across(b, &(rotation * a + shift)).norm_squared();
        rays.sort_by(|x, y| off(x).total_cmp(&off(y)));
    }
    shift.iter().all(|v| v.is_finite()).then_some(rotation)
}

/// What of `v` is across the ray `b`.
fn across(b: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    v - b * b.dot(v)
}

/// Least squares over a small turn `d` and a translation `t` in units of the points' distance: across b, `b = Exp(d) R a + t`.
fn step(
    rays: &[(Vector3<f64>, Vector3<f64>)],
    rotation: &UnitQuaternion<f64>,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for (a, b) in rays {
        let turned = rotation * a;
        let project = Matrix3::identity() - b * b.transpose();
        let mut rows = Matrix3x6::zeros();
        // Exp(d) r = r - hat(r) d
        rows.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-project * turned.cross_matrix()));
        rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&project);
        normal += rows.transpose() * rows;
        right -= rows.transpose() * (project * turned);
    }
    let found = normal.cholesky()?.solve(&right);
    Some((found.fixed_rows::<3>(0).into_owned(), found.fixed_rows::<3>(3).into_owned()))
}

/// The rotation and the reflection nearest to a matrix.
fn best(cross: &Matrix3<f64>) -> (Rotation3<f64>, Matrix3<f64>) {
    let svd = cross.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return (Rotation3::identity(), -Matrix3::identity());
    };
    let mut smallest = Matrix3::identity();
    smallest[(2, 2)] = (u * v_t).determinant().signum();
    let mut other = smallest;
    other[(2, 2)] *= -1.0;
    (Rotation3::from_matrix_unchecked(u * smallest * v_t), u * other * v_t)
}

/// Means removed (the gyro's bias with them), the worst tenth by size left out.
fn centred(turns: &[(Vector3<f64>, Vector3<f64>)]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut kept = turns.to_vec();
    kept.sort_by(|a, b| a.1.norm_squared().total_cmp(&b.1.norm_squared()));
    kept.truncate((kept.len() * 9).div_ceil(10));
    let n = kept.len() as f64;
    let body = kept.iter().map(|t| t.0).sum::<Vector3<f64>>() / n;
    let cam = kept.iter().map(|t| t.1).sum::<Vector3<f64>>() / n;
    kept.iter().map(|t| (t.0 - body, t.1 - cam)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::SampleRate;
    use dpn_sim::tracks::{AnalyticPath, TracksConfig, camera_stamps, simulate_tracks};
    use dpn_sim::{Flight, FlightConfig, simulate};
    use rand::Rng;

    struct Case {
        samples: Vec<ImuSample>,
        frames: Vec<TrackFrame>,
        camera: CameraModel,
        body_from_cam: Isometry3<f64>,
    }

    fn case() -> Case {
        let flight = simulate(Flight::RoomMedium, 1, &FlightConfig::default()).unwrap();
        let config = TracksConfig::default();
        let path = AnalyticPath::of(&flight);
        let stamps = camera_stamps(&path, SampleRate::from_hz(20.0).unwrap());
        let settings = config.camera_or_default();
        Case {
            samples: flight.recording.samples().to_vec(),
            frames: simulate_tracks(&config, &path, &stamps[..800], 1).unwrap(),
            camera: settings.model().unwrap(),
            body_from_cam: settings.body_from_cam().unwrap(),
        }
    }

    impl Case {
        fn judged(&self) -> Axes {
            axes(&self.samples, &self.frames, &self.camera, &self.body_from_cam)
        }

        fn with_gyro(&self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Axes {
            let samples: Vec<_> = self.samples.iter().map(|s| ImuSample { gyro: f(s.gyro), ..*s }).collect();
            axes(&samples, &self.frames, &self.camera, &self.body_from_cam)
        }
    }

    #[test]
    fn a_sound_flight_is_consistent_and_each_slip_is_named() {
        let case = case();
        let sound = case.judged();
        assert_eq!(sound.verdict, AxesVerdict::Consistent, "{sound:?}");
        assert!(sound.correlation > 0.9 && sound.warning().is_none(), "{sound:?}");

        // A bias moves nothing.
        let biased = case.with_gyro(|[x, y, z]| [x + 0.3, y, z - 0.2]);
        assert_eq!(biased.verdict, AxesVerdict::Consistent, "{biased:?}");

        let degrees = case.with_gyro(|g| g.map(f64::to_degrees));
        let AxesVerdict::Scaled { factor } = degrees.verdict else { panic!("{degrees:?}") };
        assert!((factor / 57.3 - 1.0).abs() < 0.1, "{factor}");

        for mirror in [|[x, y, z]: [f64; 3]| [y, x, z], |[x, y, z]: [f64; 3]| [x, y, -z]] {
            let mirrored = case.with_gyro(mirror);
            assert_eq!(mirrored.verdict, AxesVerdict::Mirrored, "{mirrored:?}");
        }
        // Two swapped and one turned round: another frame, right-handed.
        let turned = case.with_gyro(|[x, y, z]| [y, -x, z]);
        let AxesVerdict::Turned { degrees, axis_in_body } = turned.verdict else { panic!("{turned:?}") };
        assert!((degrees - 90.0).abs() < 6.0 && axis_in_body[2].abs() > 0.99, "{turned:?}");
        assert!(turned.warning().unwrap().contains("the rotation of the extrinsics"));
    }

    /// A camera carried by hand past near things: its turns are told badly, and their noise is no turning.
    #[test]
    fn a_camera_that_tells_turns_badly_is_no_gyro_that_reads_too_little() {
        let mut rng = dpn_core::random::Stream::new(4).named("turns").rng();
        let pairs = 600;
        let mut told = |factor: f64| {
            let (mut agreement, mut power_body, mut power_cam) = (0.0, 0.0, 0.0);
            for _ in 0..pairs {
                let turn = Vector3::from_fn(|_, _| rng.random::<f64>() - 0.5);
                let cam = turn + Vector3::from_fn(|_, _| 1.4 * (rng.random::<f64>() - 0.5));
                let body = factor * turn;
                agreement += body.dot(&cam) / f64::from(pairs);
                power_body += body.norm_squared() / f64::from(pairs);
                power_cam += cam.norm_squared() / f64::from(pairs);
            }
            assert!(
                power_body / power_cam < factor.powi(2) * SCALE_TOLERANCE.powi(-2),
                "the case is too easy"
            );
            scale(agreement, power_body, power_cam, f64::from(pairs))
        };
        assert_eq!(told(1.0), AxesVerdict::Consistent);
        for wrong in [57.3, 1.0 / 57.3] {
            let AxesVerdict::Scaled { factor } = told(wrong) else { panic!("{wrong}") };
            assert!((0.8..1.25).contains(&(factor / wrong)), "{factor}");
        }
    }

    #[test]
    fn a_camera_mounted_otherwise_than_said_is_found() {
        let mut case = case();
        case.body_from_cam.rotation *= UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5);
        let judged = case.judged();
        let AxesVerdict::Turned { degrees, .. } = judged.verdict else { panic!("{judged:?}") };
        assert!((degrees - 28.6).abs() < 6.0, "{judged:?}");
    }

    #[test]
    fn extrinsics_the_wrong_way_about_are_named_and_other_mountings_are_not() {
        let mut case = case();
        // EuRoC's camera is turned by 90 degrees about its axis; as good a case as any, for its inverse is 180 degrees away.
        case.body_from_cam = case.body_from_cam.inverse();
        let judged = case.judged();
        assert_eq!(judged.verdict, AxesVerdict::Swapped, "{judged:?}");
        let said = judged.warning().unwrap();
        assert!(
            said.starts_with("the camera's extrinsics are swapped") && said.contains("--calib"),
            "{said}"
        );
    }

    #[test]
    fn tracks_of_another_time_are_unrelated_and_a_body_at_rest_says_nothing() {
        let case = case();
        let moved = case.samples[4000..].iter().zip(&case.samples);
        let moved: Vec<_> = moved.map(|(later, s)| ImuSample { t: s.t, ..*later }).collect();
        let judged = axes(&moved, &case.frames, &case.camera, &case.body_from_cam);
        assert_eq!(judged.verdict, AxesVerdict::Unrelated, "{judged:?}");
        let first = &case.frames[0];
        let still: Vec<_> =
            case.frames.iter().map(|f| TrackFrame { t: f.t, tracks: first.tracks.clone() }).collect();
        assert_eq!(
            axes(&case.samples, &still, &case.camera, &case.body_from_cam).verdict,
            AxesVerdict::Unknown
        );
        assert_eq!(axes(&[], &[], &case.camera, &case.body_from_cam).verdict, AxesVerdict::Unknown);
    }
}
