//! Trajectories held against a truth.

use crate::error::{Error, raise};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_eval::closed_loop::run_nees;
use dpn_eval::metrics::{AlignmentKind, ErrorSummary, RPE_TOLERANCE, RpeStep, associate_nearest, ate, rpe};
use nalgebra::{Isometry3, Matrix6, Quaternion, Translation3, UnitQuaternion};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
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

/// Stamps and NEES `(k, 2)`, position and orientation, of the poses that have a truth.
type Nees = (Py<PyArray1<i64>>, Py<PyArray2<f64>>);

/// NEES under `covariances` `(n, 36)`, about `anchor` where there is one.
#[pyfunction]
pub(crate) fn trajectory_nees(
    py: Python<'_>,
    true_t_ns: PyReadonlyArray1<'_, i64>,
    true_poses: PyReadonlyArray2<'_, f64>,
    est_t_ns: PyReadonlyArray1<'_, i64>,
    est_poses: PyReadonlyArray2<'_, f64>,
    covariances: PyReadonlyArray2<'_, f64>,
    anchor: Option<(PyReadonlyArray1<'_, i64>, PyReadonlyArray2<'_, f64>)>,
) -> PyResult<Nees> {
    let (truth, estimate) = (poses(&true_t_ns, &true_poses)?, poses(&est_t_ns, &est_poses)?);
    let covariances: Vec<Matrix6<f64>> =
        covariances.as_slice()?.as_chunks::<36>().0.iter().map(|c| Matrix6::from_row_slice(c)).collect();
    let anchor = anchor.map(|(t_ns, rows)| poses(&t_ns, &rows)).transpose()?;
    let anchor = anchor.as_ref().and_then(|anchor| anchor.first());
    let found = run_nees(&truth, &estimate, &covariances, anchor).map_err(|e| raise(&e))?;
    let values = found.iter().flat_map(|nees| [nees.position, nees.orientation]).collect();
    let values = PyArray1::from_vec(py, values).reshape([found.len(), 2])?.unbind();
    Ok((PyArray1::from_vec(py, found.iter().map(|nees| nees.t.ns()).collect()).unbind(), values))
}
