//! What a log says of its IMU: the same calls as `dpn noise`, `dpn allan` and `dpn check`.

use crate::error::{Error, raise};
use crate::recording::Recording;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{Recorded, Samples};
use dpn_core::{SampleRate, Sensor};
use dpn_probe::allan::AllanLog;
use dpn_probe::doctor::examine_log;
use dpn_probe::log_noise::{EffectiveNoise, LogNoiseError, Plan, TrackSummary, report, track};
use dpn_probe::phases::phases;
use dpn_pronet::network::{Network, load_all};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;

/// What stands in for the networks where they cannot be asked, as on the command line.
const SIMPLE: &str = "diff2";

/// Stamps, deviations `(n, 6)`, windows judged and outside `(n, 2)`, summary as JSON.
type NoiseArrays = (Py<PyArray1<i64>>, Py<PyArray2<f64>>, Py<PyArray2<u64>>, Py<PyArray2<u64>>, String);

fn plan<'a>(
    spec: Option<&NoiseSpec>,
    rate: SampleRate,
    every: usize,
    networks: &'a [Network],
) -> Result<Plan<'a>, LogNoiseError> {
    let parse = |text: &str| text.parse::<NoiseSpec>().expect("a spec of our own");
    match spec {
        Some(spec) => Plan::new(spec, rate, every, networks),
        None => match Plan::new(&parse("dualpronet"), rate, every, networks) {
            Err(LogNoiseError::Rate { .. }) => Plan::new(&parse(SIMPLE), rate, every, networks),
            other => other,
        },
    }
}

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
        let plan = plan(spec.as_ref(), samples.rate(), every, &networks).map_err(|e| raise(&e))?;
        let unknown_s = plan.unknown_s();
        if samples.length_s() <= unknown_s {
            return Err(Error::new_err(format!(
                "recording: {:.2} s; the first window alone has {unknown_s:.2} s; record for longer, or ask constants (model=\"x1\")",
                samples.length_s()
            )));
        }
        let track = track(&plan, samples).map_err(|e| raise(&e))?;
        let summary = phases(samples)
            .and_then(|stretches| TrackSummary::of(&track, samples, stretches, unknown_s))
            .map_err(|e| raise(&e))?;
        let effective = EffectiveNoise::of(samples, &summary.stretches).map_err(|e| raise(&e))?;
        let (mut stamps, mut sigma, mut windows, mut outside) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let each = |answer: &dpn_probe::log_noise::Answer| {
            stamps.push(answer.t.ns());
            for sensor in Sensor::ALL {
                sigma.extend(answer.noise.of(sensor));
                windows.push(answer.judged.of(sensor).windows);
                outside.push(answer.judged.of(sensor).outside);
            }
            Ok(())
        };
        track.each(each).map_err(|e| raise(&e))?;
        let json = serde_json::json!({
            "samples": samples.len(), "rate_hz": samples.rate().hz(), "noise": plan.spec(), "every": plan.every(),
            "thinned_to_every": plan.thin(), "warnings": report::warnings(&plan, &summary), "summary": summary,
            "effective": effective,
        });
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
