//! What a log says of its IMU: the same calls as `dpn noise`, `dpn allan` and `dpn check`.

use crate::error::raise;
use crate::recording::Recording;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{Recorded, Sensor};
use dpn_probe::allan::AllanLog;
use dpn_probe::doctor::examine_log;
use dpn_probe::log_noise::{Along, Plan};
use dpn_pronet::network::load_all;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Stamps, deviations `(n, 6)`, windows judged and outside `(n, 2)`, summary as JSON.
type NoiseArrays = (Py<PyArray1<i64>>, Py<PyArray2<f64>>, Py<PyArray2<u64>>, Py<PyArray2<u64>>, String);

/// The noise along a log.
#[pyfunction]
pub(crate) fn noise(
    py: Python<'_>,
    recording: &Recording,
    spec: Option<&str>,
    every: usize,
    weights: Option<PathBuf>,
) -> PyResult<NoiseArrays> {
    let spec: Option<NoiseSpec> = crate::error::parsed("model", spec)?;
    let samples = &recording.log.recording;
    let (stamps, sigma, windows, outside, json) = py.detach(|| -> PyResult<_> {
        let mut networks = weights.map_or(Ok(Vec::new()), |dir| load_all(&dir)).map_err(|e| raise(&e))?;
        networks.extend(dpn_program::shipped().map_err(|e| raise(&e))?);
        let rate = samples.rate();
        let plan = match &spec {
            Some(spec) => Plan::new(spec, rate, every, &networks),
            None => Plan::fitting(rate, every, &networks).map(|(plan, _)| plan),
        };
        let plan = plan.map_err(|e| raise(&e))?;
        let along = Along::of(&plan, samples, None).map_err(|e| raise(&e))?;
        let (mut stamps, mut sigma, mut windows, mut outside) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let each = |answer: &dpn_probe::log_noise::Answer| {
            stamps.push(answer.t.ns());
            for sensor in Sensor::ALL {
                sigma.extend(answer.noise.of(sensor));
                windows.push(answer.judged.of(sensor).windows);
                outside.push(answer.judged.of(sensor).outside);
            }
            Ok(())
        };
        along.track.each(each).map_err(|e| raise(&e))?;
        let mut json = along.json("", &plan, samples).map_err(|e| raise(&e))?;
        // Arrays have no path.
        json.as_object_mut().map(|keys| keys.remove("log"));
        Ok((stamps, sigma, windows, outside, json.to_string()))
    })?;
    let rows = stamps.len();
    let two = |counts| PyArray1::from_vec(py, counts).reshape([rows, 2]).map(Bound::unbind);
    let sigma = PyArray1::from_vec(py, sigma).reshape([rows, 6])?.unbind();
    Ok((PyArray1::from_vec(py, stamps).unbind(), sigma, two(windows)?, two(outside)?, json))
}

/// Allan deviation and what it says; `log` and `figures` of `dpn allan --json`.
#[pyfunction]
pub(crate) fn allan(py: Python<'_>, recording: &Recording, all: bool) -> PyResult<String> {
    py.detach(|| {
        let allan = AllanLog::of(&recording.held()?, all).map_err(|e| raise(&e))?;
        Ok(serde_json::json!({ "log": allan, "figures": allan.figures() }).to_string())
    })
}

/// What is wrong with a log; `dpn check --json`.
#[pyfunction]
pub(crate) fn check(py: Python<'_>, recording: &Recording) -> PyResult<String> {
    py.detach(|| {
        let examination = examine_log(&recording.log).map_err(|e| raise(&e))?;
        serde_json::to_string(&examination).map_err(|e| raise(&e))
    })
}
