//! A flight of known noise.

use crate::error::{Error, raise};
use crate::recording::Recording;
use dpn_logs::{Kind, Log};
use dpn_sim::{Flight, FlightConfig};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Recording; true deviations `(n, 6)`, accelerometer first; true positions `(n, 3)`; true orientations `(n, 4)`, w first.
type Flown = (Recording, Py<PyArray2<f64>>, Py<PyArray2<f64>>, Py<PyArray2<f64>>);

/// Flies.
#[pyfunction]
pub(crate) fn simulate(py: Python<'_>, flight: &str, seed: u64) -> PyResult<Flown> {
    let name: Flight = flight.parse().map_err(|error| Error::new_err(format!("flight: {error}")))?;
    let flown =
        py.detach(|| dpn_sim::simulate(name, seed, &FlightConfig::default())).map_err(|e| raise(&e))?;
    let white = &flown.truth.white_sigma;
    let sigma = white.accel.iter().zip(&white.gyro).flat_map(|(a, g)| [*a, *g]).flatten().collect();
    let poses = || flown.ground_truth.iter().map(|state| state.world_from_body);
    let position = poses().flat_map(|pose| <[f64; 3]>::from(pose.translation.vector)).collect();
    let orientation = poses()
        .flat_map(|pose| {
            let q = pose.rotation;
            [q.w, q.i, q.j, q.k]
        })
        .collect();
    let rows = flown.recording.samples().len();
    let array = |values: Vec<f64>, columns: usize| {
        PyArray1::from_vec(py, values).reshape([rows, columns]).map(Bound::unbind)
    };
    let arrays = (array(sigma, 6)?, array(position, 3)?, array(orientation, 4)?);
    Ok((Recording::new(Log::sound(Kind::Asl, flown.recording)), arrays.0, arrays.1, arrays.2))
}
