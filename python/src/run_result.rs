//! What a run left, as arrays.

use dpn_core::Sensor;
use dpn_eval::closed_loop::JudgedRun;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::{Phase, Update};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Factors learned: accelerometer x y z, gyroscope x y z, walks of their biases, pixel.
const LEVELS: usize = 9;

/// A finished run; becomes a dictionary of arrays, a row a frame, NaN where the estimator had nothing to say.
pub(crate) struct RunResult {
    report: String,
    warnings: Vec<String>,
    done: JudgedRun,
}

impl RunResult {
    pub(crate) fn new(report: serde_json::Value, estimator: &EstimatorConfig, done: JudgedRun) -> Self {
        let mut warnings = estimator.warnings();
        warnings.extend(done.report.warnings.iter().cloned());
        Self { report: report.to_string(), warnings, done }
    }
}

/// `width` numbers a frame.
fn rows<'py>(
    py: Python<'py>,
    updates: &[Update],
    width: usize,
    of: impl Fn(&Update) -> Option<Vec<f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let values = updates.iter().flat_map(|update| of(update).unwrap_or_else(|| vec![f64::NAN; width]));
    let array = PyArray1::from_vec(py, values.collect());
    Ok(if width == 1 { array.into_any() } else { array.reshape([updates.len(), width])?.into_any() })
}

impl<'py> IntoPyObject<'py> for RunResult {
    type Target = PyDict;
    type Output = Bound<'py, PyDict>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let updates = &self.done.output.updates;
        let dict = PyDict::new(py);
        let state = |width: usize, of: fn(&dpn_vio::state::NavState) -> Vec<f64>| {
            rows(py, updates, width, |update| update.state.as_ref().map(of))
        };
        let count = |of: fn(&Update) -> usize| {
            PyArray1::from_vec(py, updates.iter().map(|update| of(update) as i64).collect())
        };
        let phase = |update: &Update| match update.phase {
            Phase::Initialising(reason) => format!("initialising: {}", reason.name()),
            Phase::Tracking => "tracking".to_owned(),
            Phase::Restarted(_) => "restarted".to_owned(),
        };
        dict.set_item("t_ns", PyArray1::from_vec(py, updates.iter().map(|u| u.t.ns()).collect()))?;
        dict.set_item("phase", updates.iter().map(phase).collect::<Vec<_>>())?;
        dict.set_item("position", state(3, |s| s.world_from_body.translation.vector.as_slice().to_vec())?)?;
        let orientation = state(4, |s| {
            let q = s.world_from_body.rotation;
            vec![q.w, q.i, q.j, q.k]
        })?;
        dict.set_item("orientation", orientation)?;
        dict.set_item("velocity", state(3, |s| s.vel_in_world.as_slice().to_vec())?)?;
        dict.set_item("accel_bias", state(3, |s| s.bias.accel.as_slice().to_vec())?)?;
        dict.set_item("gyro_bias", state(3, |s| s.bias.gyro.as_slice().to_vec())?)?;
        let covariance =
            rows(py, updates, 36, |u| u.covariance.as_ref().map(|c| c.transpose().as_slice().to_vec()))?;
        let known = updates.iter().any(|update| update.covariance.is_some());
        let shape = (updates.len(), 6, 6);
        dict.set_item(
            "covariance",
            known.then(|| covariance.call_method1("reshape", (shape,))).transpose()?,
        )?;
        let levels = rows(py, updates, LEVELS, |update| {
            update
                .levels
                .as_deref()
                .map(|levels| levels.inertial.0.into_iter().chain([levels.pixel]).collect())
        })?;
        dict.set_item("levels", updates.iter().any(|update| update.levels.is_some()).then_some(levels))?;
        dict.set_item("whitened", rows(py, updates, 1, |update| update.whitened.map(|w| vec![w]))?)?;
        dict.set_item("tracked", count(|update| update.tracked as usize))?;
        dict.set_item("landmarks", count(|update| update.landmarks as usize))?;
        dict.set_item("outliers", count(|update| update.outliers as usize))?;
        dict.set_item("iterations", count(|update| update.iterations as usize))?;
        let noise = &self.done.noise;
        let sigma: Vec<f64> =
            noise.noises().iter().flat_map(|n| Sensor::ALL.map(|sensor| n.of(sensor))).flatten().collect();
        let stamps = noise.stamps().iter().map(|t| t.ns()).collect();
        dict.set_item("noise_t_ns", PyArray1::from_vec(py, stamps))?;
        dict.set_item("noise", PyArray1::from_vec(py, sigma).reshape([noise.noises().len(), 6])?)?;
        let anchor = self.done.output.report.anchor.map(|pose| {
            let (p, q) = (pose.world_from_body.translation.vector, pose.world_from_body.rotation);
            (pose.t.ns(), [p.x, p.y, p.z], [q.w, q.i, q.j, q.k])
        });
        dict.set_item("anchor", anchor)?;
        dict.set_item("warnings", self.warnings)?;
        dict.set_item("report", self.report)?;
        Ok(dict)
    }
}
