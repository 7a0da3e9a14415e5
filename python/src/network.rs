//! A network's weights and its answers.

use crate::error::raise;
use dpn_pronet::Predictor;
use dpn_pronet::network;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A trained network of one sensor.
#[pyclass(frozen, module = "dpn._dpn")]
pub(crate) struct Network {
    pub(crate) inner: network::Network,
}

#[pymethods]
impl Network {
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { inner: network::Network::load(&path).map_err(|e| raise(&e))? })
    }

    #[staticmethod]
    fn shipped() -> PyResult<Vec<Self>> {
        let all = dpn_program::shipped().map_err(|e| raise(&e))?;
        Ok(all.into_iter().map(|inner| Self { inner }).collect())
    }

    #[getter]
    fn sensor(&self) -> &'static str {
        self.inner.sensor().name()
    }

    #[getter]
    fn tag(&self) -> String {
        self.inner.tag()
    }

    #[getter]
    fn rate(&self) -> f64 {
        self.inner.weights.card().rate.hz()
    }

    #[getter]
    fn window(&self) -> usize {
        self.inner.weights.config().window
    }

    /// `(b, window)` to `(b,)`; the caller has checked the shape.
    fn predict(&self, py: Python<'_>, windows: PyReadonlyArray2<'_, f32>) -> PyResult<Py<PyArray1<f32>>> {
        let count = windows.as_array().nrows();
        let windows = windows.as_slice()?;
        let mut sigma = vec![0.0; count];
        py.detach(|| Predictor::new(&self.inner.weights).predict(windows, &mut sigma));
        Ok(PyArray1::from_vec(py, sigma).unbind())
    }

    fn __repr__(&self) -> String {
        format!("Network({} {}, {} samples at {} Hz)", self.sensor(), self.tag(), self.window(), self.rate())
    }
}
