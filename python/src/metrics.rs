//! Trajectories held against a truth.

use crate::error::{Error, raise};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_eval::metrics::{AlignmentKind, ErrorSummary, RPE_TOLERANCE, RpeStep, associate_nearest, ate, rpe};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Poses `(n, 7)`: x y z, then qw qx qy qz.
pub(crate) fn poses(
    t_ns: &PyReadonlyArray1<'_, i64>,
    rows: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<StampedPose>> {
    let rows = rows.as_slice()?.as_chunks::<7>().0;
    let pose = |(&ns, &[x, y, z, w, i, j, k]): (&i64, &[f64; 7])| StampedPose {
        t: Stamp::from_ns(ns),
        world_from_body: Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)),
        ),
    };
    Ok(t_ns.as_slice()?.iter().zip(rows).map(pose).collect())
}

/// ATE, and RPE where a step is given, as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn trajectory_errors(
    true_t_ns: PyReadonlyArray1<'_, i64>,
    true_poses: PyReadonlyArray2<'_, f64>,
    est_t_ns: PyReadonlyArray1<'_, i64>,
    est_poses: PyReadonlyArray2<'_, f64>,
    alignment: &str,
    max_diff_s: f64,
    step_m: Option<f64>,
    step_s: Option<f64>,
) -> PyResult<String> {
    let kind: AlignmentKind = serde_json::from_value(alignment.into()).map_err(|_| {
        Error::new_err(format!("align: {alignment:?}; known are position, yaw-position, se3, sim3"))
    })?;
    let (truth, estimate) = (poses(&true_t_ns, &true_poses)?, poses(&est_t_ns, &est_poses)?);
    let found = associate_nearest(&truth, &estimate, max_diff_s).map_err(|e| raise(&e))?;
    let figures =
        |t: &ErrorSummary, r: &ErrorSummary| serde_json::json!({ "translation_m": t, "rotation_rad": r });
    let step = step_m.map(RpeStep::Metres).or(step_s.map(RpeStep::Seconds));
    let Some(step) = step else {
        let ate = ate(&found.pairs, kind).map_err(|e| raise(&e))?;
        return Ok(figures(&ate.translation, &ate.rotation).to_string());
    };
    let rpe = rpe(&found.pairs, step, RPE_TOLERANCE).map_err(|e| raise(&e))?;
    Ok(rpe.map_or(serde_json::Value::Null, |rpe| figures(&rpe.translation, &rpe.rotation)).to_string())
}
