//! Absolute and relative errors held to evo's (`golden/evo/make.py`), on a synthetic pair and on 12 s of V1_02_medium.

use super::ate::ate_aligned;
use super::*;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use std::collections::BTreeMap;

/// t_ns x y z qx qy qz qw.
type Row = (i64, f64, f64, f64, f64, f64, f64, f64);

#[derive(Deserialize)]
struct Summary {
    count: usize,
    rmse: f64,
    mean: f64,
    median: f64,
    max: f64,
}

#[derive(Deserialize)]
struct Absolute {
    translation: Summary,
    rotation: Summary,
    rotation_matrix: Option<[[f64; 3]; 3]>,
    offset: Option<[f64; 3]>,
    scale: Option<f64>,
}

#[derive(Deserialize)]
struct Relative {
    step: f64,
    translation: Summary,
    rotation: Summary,
}

#[derive(Deserialize)]
struct Method {
    pairs: usize,
    first_truth_position: [f64; 3],
    absolute: BTreeMap<String, Absolute>,
    by_frames: Vec<Relative>,
    by_metres: Vec<Relative>,
    by_name: BTreeMap<String, Errors>,
}

#[derive(Deserialize)]
struct Errors {
    translation: Summary,
    rotation: Summary,
}

#[derive(Deserialize)]
struct Case {
    truth: Vec<Row>,
    estimate: Vec<Row>,
    methods: BTreeMap<String, Method>,
}

#[derive(Deserialize)]
struct Golden {
    cases: BTreeMap<String, Case>,
}

fn poses(rows: &[Row]) -> Vec<StampedPose> {
    let pose = |&(t_ns, x, y, z, qx, qy, qz, qw): &Row| StampedPose {
        t: Stamp::from_ns(t_ns),
        world_from_body: Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz)),
        ),
    };
    rows.iter().map(pose).collect()
}

/// Every pair of every case and association with its name and evo's figures.
fn each(check: impl Fn(&str, &[PosePair], &Method, &Case)) {
    let golden: Golden = dpn_testing::golden("evo");
    assert_eq!(golden.cases.len(), 2);
    for (name, case) in &golden.cases {
        let (truth, estimate) = (poses(&case.truth), poses(&case.estimate));
        for (kind, method) in &case.methods {
            let found = match kind.as_str() {
                "nearest" => associate_nearest(&truth, &estimate, 0.01).unwrap(),
                _ => {
                    let track = TruthTrack::new(&truth, TruthOptions::default()).unwrap();
                    associate_interpolated(&track, &estimate).unwrap()
                }
            };
            check(&format!("{name}, {kind}"), &found.pairs, method, case);
        }
    }
}

/// evo's quaternions are not brought to length 1 again after the 8 to 9 digits of a file; ours are.
const LENGTH: f64 = 2e-8;
const ANGLE: f64 = 1e-6;

fn hold(what: &str, got: &ErrorSummary, expected: &Summary, tolerance: f64) {
    assert_eq!(got.count, expected.count, "{what}");
    let figures = [
        ("rmse", got.rmse, expected.rmse),
        ("mean", got.mean, expected.mean),
        ("median", got.median, expected.median),
        ("max", got.max, expected.max),
    ];
    for (name, got, expected) in figures {
        assert!((got - expected).abs() < tolerance, "{what}: {name} {got}, evo {expected}");
    }
}

#[test]
fn the_same_poses_are_paired() {
    each(|name, pairs, method, _| {
        assert_eq!(pairs.len(), method.pairs, "{name}");
        let off =
            pairs[0].true_world_from_body.translation.vector - Vector3::from(method.first_truth_position);
        assert!(off.norm() < LENGTH, "{name}: {off}");
    });
}

#[test]
fn absolute_errors_and_alignments_are_evos() {
    let kinds = [
        ("position", AlignmentKind::Position),
        ("yaw_position", AlignmentKind::YawPosition),
        ("se3", AlignmentKind::Se3),
        ("sim3", AlignmentKind::Sim3),
    ];
    each(|name, pairs, method, _| {
        for (key, kind) in kinds {
            let (got, expected) = (ate(pairs, kind).unwrap(), &method.absolute[key]);
            let what = format!("{name}, {key}");
            hold(&what, &got.translation, &expected.translation, LENGTH);
            hold(&what, &got.rotation, &expected.rotation, ANGLE);
            let matrix = Matrix3::from(expected.rotation_matrix.unwrap()).transpose();
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
            let map = got.alignment.true_world_from_est_world;
            assert!(map.rotation.angle_to(&rotation) < 1e-7, "{what}");
            let off = map.translation.vector - Vector3::from(expected.offset.unwrap());
            assert!(off.norm() < 1e-6, "{what}: {off}");
            assert!((got.alignment.scale - expected.scale.unwrap()).abs() < 1e-7, "{what}");
        }
        let none = ate_aligned(pairs, Alignment::identity()).unwrap();
        hold(name, &none.translation, &method.absolute["none"].translation, LENGTH);
        hold(name, &none.rotation, &method.absolute["none"].rotation, ANGLE);
        let scale = method.absolute["sim3"].scale.unwrap();
        assert!((scale_error(pairs).unwrap() - (scale - 1.0)).abs() < 1e-7, "{name}");
    });
}

#[test]
fn relative_errors_are_evos() {
    each(|name, pairs, method, case| {
        // evo counts frames; the estimate's are evenly spaced, but for a jitter well below a quarter of their period.
        let times: Vec<i64> = case.estimate.iter().map(|row| row.0).collect();
        let period = (times[times.len() - 1] - times[0]) as f64 * 1e-9 / (times.len() - 1) as f64;
        let frames = |row| (RpeStep::Seconds(row_step(row) * period), 0.25 / row_step(row), row);
        let metres = |row| (RpeStep::Metres(row_step(row)), RPE_TOLERANCE, row);
        let by_path = method.by_metres.iter().map(metres);
        for (step, tolerance, expected) in method.by_frames.iter().map(frames).chain(by_path) {
            let got = rpe(pairs, step, tolerance).unwrap().unwrap();
            let what = format!("{name}, {step:?}");
            hold(&what, &got.translation, &expected.translation, LENGTH);
            hold(&what, &got.rotation, &expected.rotation, ANGLE);
        }
    });
}

#[test]
fn stretches_by_evos_names_are_evos() {
    each(|name, pairs, method, _| {
        assert_eq!(method.by_name.len(), 20);
        for (spec, expected) in &method.by_name {
            let got = rpe_by(pairs, &spec.parse().unwrap(), RPE_TOLERANCE).unwrap().unwrap();
            let what = format!("{name}, {spec}");
            hold(&what, &got.translation, &expected.translation, LENGTH);
            hold(&what, &got.rotation, &expected.rotation, ANGLE);
        }
    });
}

fn row_step(row: &Relative) -> f64 {
    row.step
}
