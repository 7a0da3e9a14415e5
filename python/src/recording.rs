//! Samples in and out of arrays.

use crate::error::{parsed, raise, word};
use dpn_core::{ImuRecording, ImuSample, Recorded, Samples, Sensor, Stamp};
use dpn_io::CsvOptions;
use dpn_logs::{Kind, Log, LogOptions, Scales, read_log};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A log's samples and what was said of them. Arrays are made once, at the first question, and are read-only.
#[pyclass(frozen, module = "dpn")]
pub(crate) struct Recording {
    pub(crate) log: Log,
    stamps: OnceLock<Py<PyArray1<i64>>>,
    gyro: OnceLock<Py<PyArray2<f64>>>,
    accel: OnceLock<Py<PyArray2<f64>>>,
}

impl Recording {
    pub(crate) fn new(log: Log) -> Self {
        Self { log, stamps: OnceLock::new(), gyro: OnceLock::new(), accel: OnceLock::new() }
    }

    /// All samples in memory.
    pub(crate) fn held(&self) -> PyResult<ImuRecording> {
        let samples = self.log.recording.all().map_err(|e| raise(&e))?.into_owned();
        ImuRecording::new(samples).map_err(|e| raise(&e))
    }

    fn sensor(&self, py: Python<'_>, sensor: Sensor) -> PyResult<Py<PyArray2<f64>>> {
        let kept = if sensor == Sensor::Gyro { &self.gyro } else { &self.accel };
        if let Some(array) = kept.get() {
            return Ok(array.clone_ref(py));
        }
        let recording = &self.log.recording;
        let mut values = Vec::with_capacity(3 * recording.len());
        py.detach(|| recording.each(0..recording.len(), &mut |s| values.extend(s.of(sensor))))
            .map_err(|e| raise(&e))?;
        let array = PyArray1::from_vec(py, values).reshape([recording.len(), 3])?;
        Ok(kept.get_or_init(|| sealed(array)).clone_ref(py))
    }
}

/// A recording does not change: neither do its arrays.
fn sealed<T: numpy::Element, D: numpy::ndarray::Dimension>(
    array: Bound<'_, numpy::PyArray<T, D>>,
) -> Py<numpy::PyArray<T, D>> {
    array.readwrite().make_nonwriteable();
    array.unbind()
}

#[pymethods]
impl Recording {
    /// (n,) int64 stamps [ns].
    #[getter]
    fn t_ns(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i64>>> {
        if let Some(array) = self.stamps.get() {
            return Ok(array.clone_ref(py));
        }
        let recording = &self.log.recording;
        let mut stamps = Vec::with_capacity(recording.len());
        recording.each(0..recording.len(), &mut |s| stamps.push(s.t.ns())).map_err(|e| raise(&e))?;
        Ok(self.stamps.get_or_init(|| sealed(PyArray1::from_vec(py, stamps))).clone_ref(py))
    }

    /// (n,) seconds since the first sample; made anew each time.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let recording = &self.log.recording;
        let first = recording.span()[0];
        let mut seconds = Vec::with_capacity(recording.len());
        recording
            .each(0..recording.len(), &mut |s| seconds.push(s.t.seconds_since(first)))
            .map_err(|e| raise(&e))?;
        Ok(PyArray1::from_vec(py, seconds))
    }

    /// (n, 3) angular rate [rad/s], body frame.
    #[getter]
    fn gyro(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        self.sensor(py, Sensor::Gyro)
    }

    /// (n, 3) specific force [m/s^2], body frame; +9.81 on the axis that points up at rest.
    #[getter]
    fn accel(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        self.sensor(py, Sensor::Accel)
    }

    /// The median rate [Hz].
    #[getter]
    fn rate(&self) -> f64 {
        self.log.recording.rate().hz()
    }

    /// What the reader took for granted: columns, units.
    #[getter]
    fn assumed(&self) -> Vec<String> {
        self.log.guesses.clone()
    }

    /// Damage, samples left out, and what else should be known.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.log.warnings()
    }

    fn __len__(&self) -> usize {
        self.log.recording.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "Recording({} samples, {:.1} s, {:.2} Hz)",
            self.__len__(),
            self.log.recording.length_s(),
            self.rate()
        )
    }
}

/// Reads any log that the command line reads: CSV, bags, MCAP, ULog, ArduPilot, ASL folders, packed or not. The GIL is released.
///
/// Options are the command line's: topic; columns "T,GX,GY,GZ,AX,AY,AZ"; units of a CSV (time_unit days, s, ms, 100us, us, 100ns, ns; gyro_unit
/// rad/s, deg/s, mdeg/s, deg/h, rpm; accel_unit m/s^2, g, mg, cm/s^2, ft/s^2); sensor_scale such as "mpu6050-2g-250dps"; max_uncompressed in bytes.
///
/// Raises Error: nothing there, nothing of use in it, several IMUs and no topic.
#[pyfunction]
#[pyo3(signature = (path, *, topic=None, columns=None, time_unit=None, gyro_unit=None, accel_unit=None, sensor_scale=None, max_uncompressed=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn read(
    py: Python<'_>,
    path: PathBuf,
    topic: Option<String>,
    columns: Option<&str>,
    time_unit: Option<&str>,
    gyro_unit: Option<&str>,
    accel_unit: Option<&str>,
    sensor_scale: Option<&str>,
    max_uncompressed: Option<u64>,
) -> PyResult<Recording> {
    let csv = CsvOptions {
        columns: parsed("columns", columns)?,
        time: word("time_unit", time_unit)?,
        gyro: word("gyro_unit", gyro_unit)?,
        accel: word("accel_unit", accel_unit)?,
        rate: None,
    };
    let scales = parsed::<Scales>("sensor_scale", sensor_scale)?.unwrap_or_default();
    let options = LogOptions { csv, topic, max_uncompressed, scales, ..LogOptions::default() };
    let log = py.detach(|| read_log(&path, &options)).map_err(|e| raise(&e))?;
    Ok(Recording::new(log))
}

/// A recording of arrays: stamps `(n,)` in ns, `(n, 3)` in rad/s and m/s^2.
#[pyfunction]
pub(crate) fn from_arrays(
    t_ns: PyReadonlyArray1<'_, i64>,
    gyro: PyReadonlyArray2<'_, f64>,
    accel: PyReadonlyArray2<'_, f64>,
) -> PyResult<Recording> {
    let rows = |array: &PyReadonlyArray2<'_, f64>| -> PyResult<Vec<[f64; 3]>> {
        Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
    };
    let (gyro, accel) = (rows(&gyro)?, rows(&accel)?);
    let stamps = t_ns.as_slice()?.iter().map(|&ns| Stamp::from_ns(ns));
    let samples = stamps
        .zip(gyro.into_iter().zip(accel))
        .map(|(t, (gyro, accel))| ImuSample { t, gyro, accel })
        .collect();
    let recording = ImuRecording::new(samples).map_err(|e| raise(&e))?;
    Ok(Recording::new(Log::sound(Kind::Csv, recording)))
}
