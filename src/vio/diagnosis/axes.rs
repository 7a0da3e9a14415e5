//! The camera's rotation between frames against the gyro's.
//!
//! Between two frames a camera's rays turn by `cam_b_from_cam_a`, which the rays alone tell (`clock::flow_turn`). The gyro tells the same turn in body axes, plus its bias. So over all pairs of frames, means removed,
//!
//! turn_in_body = s * body_from_cam * turn_in_cam,
//!
//! whose best `body_from_cam` (Wahba's problem, by SVD) and scale `s` are compared with the calibration. Where a reflection fits better than any
//! rotation, an axis has the wrong sign or two are swapped. Where the calibration fits in the main, `turn_map` says what of it is off by less.
//! Source: G. Wahba, "A least squares estimate of satellite attitude", SIAM Review 1965; hand-eye calibration by rotations, e.g. J. Furrer et
//! al., "Evaluation of combined time-offset estimation and hand-eye calibration on robotic datasets", FSR 2017.

use super::jitter::jitter;
use super::lag::lag;
use super::turn_map::{Turn, TurnMap};
use crate::clock::{GyroCourse, SharedRays};
use dpn_core::camera::CameraModel;
use dpn_core::geometry::nearest::nearest_orthogonal;
use dpn_core::{ImuSample, TrackFrame};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use serde::Serialize;

/// Fewest pairs of frames.
const FEWEST_PAIRS: usize = 30;
/// Least turning about the second-strongest axis that lets axes be told \[rad/s, rms\].
const LEAST_TURNING: f64 = 0.05;
/// Turns that agree within this are from a camera mounted as said \[rad\]; parallax alone makes some degrees.
const TURN_TOLERANCE: f64 = 0.21;
/// A mounting that is the inverse of what was said, within this, and thrice as near to it, is that \[rad\]: real tracks tell it to 20 degrees.
const SWAP_TOLERANCE: f64 = 0.5;
/// A focal length is told from pan and tilt against roll where these differ by more \[log\]: who turns to where he goes makes 4 %.
const FOCAL_TOLERANCE: f64 = 0.12;
/// A scale of the gyroscope's is told where roll differs by more \[log\].
const SCALE_TOLERANCE: f64 = 0.06;
/// A mounting is told where it is off by more \[rad\].
const MOUNTING_TOLERANCE: f64 = 0.08;
/// And where it is known to this \[rad\]: a robot on wheels turns about one axis, and about it any mounting fits.
const MOUNTING_KNOWN: f64 = 0.1;
/// Stamps of good recordings are off by less \[s\].
const JITTER_S: f64 = 0.002;
/// All that by so many deviations more.
const SURE: f64 = 4.0;
/// Turns that correlate by more are made at the same time.
const SAME: f64 = 0.95;
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
    /// They turn together about the camera's axis and, as the camera has it, so many times as far across it: the focal length is wrong, too large by this
    /// factor or, where the path is too short to tell turns from moves, too small by it.
    Focal {
        /// The factor.
        factor: f64,
    },
    /// They turn together, but for frames whose stamps are off, now early, now late.
    Jitter {
        /// The deviation of a stamp \[s\].
        seconds: f64,
    },
    /// They make the same turns so far apart that the clock's offset is not looked for there.
    Late {
        /// By how much the camera is late \[s\]; early below zero.
        seconds: f64,
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
                "the gyro reads {factor:.2} times what the camera sees; angular rates must be in rad/s (degrees make 57.3), and --gyro-scale takes a gyroscope's own scale out"
            )),
            AxesVerdict::Focal { factor } => Some(format!(
                "the focal length looks wrong by about {:.0} %, too large or too small: the camera turns as the gyroscope says about its axis, and {factor:.2} times as far across it; is the calibration (focal length, distortion) of this lens and of this resolution? --calib names another",
                100.0 * factor.ln().abs()
            )),
            AxesVerdict::Jitter { seconds } => Some(format!(
                "the images' stamps jitter: they are off by {:.1} ms now and then early and late, as the gyroscope tells from image to image; stamp images where they are exposed (a sensor's or a driver's own stamp, START_OF_FRAME and not arrival), or space them evenly where the camera's rate is steady",
                1e3 * seconds
            )),
            AxesVerdict::Late { seconds } => Some(format!(
                "the camera's stamps are about {:.2} s {} of the gyroscope's turns: `--time-offset {:.2}` puts them right to a frame or so, and a calibration with that offset (`timeshift_cam_imu`) lets the rest be found",
                seconds.abs(),
                if seconds > 0.0 { "late" } else { "ahead" },
                -seconds
            )),
            AxesVerdict::Unrelated => Some(format!(
                "camera and gyro do not turn together, however mounted: {seen}; are tracks and IMU of one recording and on one clock?"
            )),
        }
    }
}

/// Compares the turns of camera and gyroscope, of a recording that is all there; a run's own comparison is in its report.
pub fn axes(
    samples: &[ImuSample],
    frames: &[TrackFrame],
    camera: &CameraModel,
    body_from_cam: &Isometry3<f64>,
) -> Axes {
    let mut course = GyroCourse::default();
    samples.iter().for_each(|sample| course.push(sample));
    let pairs = frames.windows(2).filter_map(|pair| {
        let rays = SharedRays::of((&pair[0], &pair[1]), &pair[1].shared(&pair[0]), camera)?;
        Turn::of(&rays.turn(&[])?, None, &course, 0.0)
    });
    compared(&pairs.collect::<Vec<_>>(), &body_from_cam.rotation)
}

/// Compares the turns of camera and gyroscope, before a camera mounted so.
pub(crate) fn compared(turns: &[Turn], body_from_cam: &UnitQuaternion<f64>) -> Axes {
    let unknown =
        Axes { verdict: AxesVerdict::Unknown, pairs: turns.len(), correlation: 0.0, best_correlation: 0.0 };
    if turns.len() < FEWEST_PAIRS {
        return unknown;
    }
    let all = turns;
    let turns = &centred(all)[..];
    let n = turns.len() as f64;
    let (mut cross, mut power_body, mut power_cam) = (Matrix3::zeros(), 0.0, Matrix3::zeros());
    for (body, cam) in turns {
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
    let given = body_from_cam.to_rotation_matrix();
    let (rotation, reflected) = nearest_orthogonal(&cross);
    // The covariance with the best scale is (sum of what agrees) / norm.
    let agreement = |m: &Matrix3<f64>| (m.transpose() * cross).trace() / norm;
    let (correlation, turned, mirrored) =
        (agreement(given.matrix()), agreement(rotation.matrix()), agreement(&reflected));
    let residual = |correlation: f64| (1.0 - correlation * correlation.abs()).max(0.0);
    let away = rotation * given.inverse();
    let late = if correlation < SAME { lag(all) } else { None };
    let verdict = if let Some(seconds) = late {
        AxesVerdict::Late { seconds }
    } else if mirrored > turned && residual(mirrored) < BETTER * residual(turned.max(correlation)) {
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
        TurnMap::of(all, &body_from_cam.inverse())
            .map_or(AxesVerdict::Consistent, |map| in_detail(&map, body_from_cam))
    };
    let verdict = match verdict {
        AxesVerdict::Consistent => jitter(all, &body_from_cam.inverse())
            .filter(|seconds| *seconds > JITTER_S)
            .map_or(verdict, |seconds| AxesVerdict::Jitter { seconds }),
        _ => verdict,
    };
    Axes { verdict, pairs: turns.len(), correlation, best_correlation: turned.max(mirrored) }
}

/// What is left to say of a camera that turns as its calibration says in the main.
fn in_detail(map: &TurnMap, body_from_cam: &UnitQuaternion<f64>) -> AxesVerdict {
    let roll = map.scale.z;
    let pan = 0.5 * (map.scale.x + map.scale.y);
    let (roll_std, pan_std) = (map.scale_std.z, 0.5 * map.scale_std.xy().norm());
    if !(roll > 0.0 && pan > 0.0) {
        return AxesVerdict::Consistent;
    }
    let off = |ratio: f64, least: f64, std: f64| ratio.ln().abs() > least + SURE * std;
    let across_std = (roll_std / roll).hypot(pan_std / pan);
    if off(pan / roll, FOCAL_TOLERANCE, across_std) {
        return AxesVerdict::Focal { factor: pan / roll };
    }
    if off(roll, SCALE_TOLERANCE, roll_std / roll) {
        return AxesVerdict::Scaled { factor: 1.0 / roll };
    }
    let known = map.away_std.max();
    if known < MOUNTING_KNOWN && map.away.norm() > MOUNTING_TOLERANCE + SURE * known {
        let axis = (body_from_cam * map.away).normalize();
        return AxesVerdict::Turned { degrees: map.away.norm().to_degrees(), axis_in_body: axis.into() };
    }
    AxesVerdict::Consistent
}

/// Means removed (the gyro's bias with them), the worst tenth by size left out.
fn centred(turns: &[Turn]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut kept: Vec<_> = turns.iter().map(|turn| (turn.body, turn.cam)).collect();
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
        let mut told = |factor: f64| {
            let turns: Vec<Turn> = (0..600)
                .map(|_| {
                    let turn = Vector3::from_fn(|_, _| rng.random::<f64>() - 0.5);
                    let cam = turn + Vector3::from_fn(|_, _| 1.4 * (rng.random::<f64>() - 0.5));
                    Turn {
                        body: factor * turn,
                        cam,
                        information: Matrix3::identity(),
                        seconds: 0.1,
                        follows: true,
                    }
                })
                .collect();
            compared(&turns, &UnitQuaternion::identity()).verdict
        };
        assert_eq!(told(1.0), AxesVerdict::Consistent);
        for wrong in [57.3, 1.0 / 57.3] {
            let AxesVerdict::Scaled { factor } = told(wrong) else { panic!("{wrong}") };
            assert!((0.8..1.25).contains(&(factor / wrong)), "{factor}");
        }
    }

    /// A camera low above the ground sees parallax as pitch and roll, and the gyroscope has next to none.
    #[test]
    fn a_robot_on_wheels_is_told_no_other_mounting() {
        let mut rng = dpn_core::random::Stream::new(5).named("wheels").rng();
        let mut about = |size: f64| size * Vector3::from_fn(|_, _| rng.random::<f64>() - 0.5);
        for seed in 0..40 {
            let turns: Vec<Turn> = (0..300)
                .map(|k| {
                    let upright = Vector3::new(0.0, 0.0, 0.4 * (0.05 * f64::from(k + seed)).sin());
                    let (body, cam) = (upright + about(0.06), upright + about(0.4));
                    Turn { body, cam, information: Matrix3::identity(), seconds: 0.1, follows: true }
                })
                .collect();
            let found = compared(&turns, &UnitQuaternion::identity());
            assert!(!matches!(found.verdict, AxesVerdict::Turned { .. }), "{seed}: {found:?}");
        }
    }

    #[test]
    fn a_lens_of_another_focal_length_a_gyro_a_tenth_off_and_a_mounting_ten_degrees_off_are_told_apart() {
        let case = case();
        for factor in [0.8, 1.25] {
            let [fx, fy, cx, cy] = [458.654, 457.296, 367.215, 248.375];
            let pinhole = CameraModel::euroc_cam0();
            let wrong =
                CameraModel::radtan([752, 480], [factor * fx, factor * fy, cx, cy], [0.0; 5]).unwrap();
            // Tracks as a lens without distortion has them.
            let right = CameraModel::radtan([752, 480], [fx, fy, cx, cy], [0.0; 5]).unwrap();
            let moved = |frame: &TrackFrame| TrackFrame {
                t: frame.t,
                tracks: (frame.tracks.iter())
                    .filter_map(|track| {
                        let px = right.project(&pinhole.bearing(&track.px)?)?;
                        Some(dpn_core::Track { px, ..*track })
                    })
                    .collect(),
                ..frame.clone()
            };
            let frames: Vec<_> = case.frames.iter().map(moved).collect();
            let judged = axes(&case.samples, &frames, &wrong, &case.body_from_cam);
            let AxesVerdict::Focal { factor: found } = judged.verdict else { panic!("{factor}: {judged:?}") };
            assert!((found / factor - 1.0).abs() < 0.05, "{factor}: {found}");
            let judged = axes(&case.samples, &frames, &right, &case.body_from_cam);
            assert_eq!(judged.verdict, AxesVerdict::Consistent, "{judged:?}");
        }
        let scaled = case.with_gyro(|g| g.map(|v| 1.1 * v));
        let AxesVerdict::Scaled { factor } = scaled.verdict else { panic!("{scaled:?}") };
        assert!((factor - 1.1).abs() < 0.03, "{factor}");
        let mut turned = case;
        turned.body_from_cam.rotation *= UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.17);
        let judged = turned.judged();
        let AxesVerdict::Turned { degrees, .. } = judged.verdict else { panic!("{judged:?}") };
        assert!((degrees - 9.7).abs() < 2.0, "{judged:?}");
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
    fn tracks_of_another_time_are_late_or_unrelated_and_a_body_at_rest_says_nothing() {
        let case = case();
        for (late_s, samples) in [(0.4, &case.samples[80..]), (-1.0, &case.samples[..])] {
            let early = if late_s < 0.0 { 200 } else { 0 };
            let moved = samples.iter().zip(&case.samples[early..]);
            let moved: Vec<_> = moved.map(|(other, s)| ImuSample { t: s.t, ..*other }).collect();
            let judged = axes(&moved, &case.frames, &case.camera, &case.body_from_cam);
            let AxesVerdict::Late { seconds } = judged.verdict else { panic!("{late_s}: {judged:?}") };
            assert!((seconds - late_s).abs() < 0.03, "{late_s}: {seconds}");
        }
        let moved = case.samples[4000..].iter().zip(&case.samples);
        let moved: Vec<_> = moved.map(|(later, s)| ImuSample { t: s.t, ..*later }).collect();
        let judged = axes(&moved, &case.frames, &case.camera, &case.body_from_cam);
        assert_eq!(judged.verdict, AxesVerdict::Unrelated, "{judged:?}");
        let first = &case.frames[0];
        let still: Vec<_> = case.frames.iter().map(|f| TrackFrame::new(f.t, first.tracks.clone())).collect();
        assert_eq!(
            axes(&case.samples, &still, &case.camera, &case.body_from_cam).verdict,
            AxesVerdict::Unknown
        );
        assert_eq!(axes(&[], &[], &case.camera, &case.body_from_cam).verdict, AxesVerdict::Unknown);
    }
}
