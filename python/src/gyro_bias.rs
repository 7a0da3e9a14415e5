//! A gyroscope's learned bias beside running samples.

use crate::error::raise;
use dpn_core::{ImuSample, Stamp};
use dpn_inertial::{Model, Running};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A network beside running samples.
#[pyclass(module = "dpn._dpn")]
pub(crate) struct GyroBias {
    running: Running,
}

#[pymethods]
impl GyroBias {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        Ok(Self { running: Running::new(Model::load(&path).map_err(|e| raise(&e))?) })
    }

    fn feed(&mut self, t_ns: i64, gyro: [f64; 3], accel: [f64; 3]) -> PyResult<()> {
        self.running.feed(&ImuSample { t: Stamp::from_ns(t_ns), gyro, accel }).map_err(|e| raise(&e))
    }

    /// Rows of the matrix, bias, its deviation, whether it is known, whether the rate fits.
    fn correction(&self) -> ([[f64; 3]; 3], [f64; 3], [f64; 3], bool, bool) {
        let of = self.running.correction();
        (of.matrix.transpose().data.0, of.bias.into(), of.deviation.into(), of.known, !of.wrong_rate)
    }
}
