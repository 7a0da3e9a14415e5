//! The odometry beside running sensors.

use crate::error::{Error, raise, word};
use crate::run::{Asked, Settings};
use dpn_core::{GrayView, ImuSample, Sensor, Stamp};
use dpn_live::{Fed, LiveError, Odometry as Live};
use dpn_vio::estimator::{Phase, Update};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};

/// An odometry; threads that use one take turns, without the interpreter while it computes.
#[pyclass(frozen, module = "dpn._dpn")]
pub(crate) struct Odometry {
    inner: Mutex<Live>,
}

fn refused(error: LiveError) -> PyErr {
    raise(&error)
}

impl Odometry {
    /// For a moment, with the interpreter held.
    fn briefly<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Live) -> R) -> R {
        work(&mut self.inner.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner))
    }

    /// For long, without the interpreter.
    fn meanwhile<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Live) -> R + Send) -> R {
        py.detach(|| work(&mut self.inner.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Odometry {
    #[new]
    fn new(asked: Asked, camera: &str) -> PyResult<Self> {
        let fed: Fed = word("camera", Some(camera))?.expect("a word was given");
        let Settings { noise, estimator, calibration, networks, seed, .. } = asked.read()?;
        let calibration = calibration.expect("Python asks for one");
        let live = Live::calibrated(calibration, fed, &noise, &estimator, networks, seed);
        Ok(Self { inner: Mutex::new(live.map_err(refused)?) })
    }

    /// Rows of a stamp, gyroscope, accelerometer; finite, in increasing time.
    fn feed_imu(
        &self,
        py: Python<'_>,
        t_ns: PyReadonlyArray1<'_, i64>,
        gyro: PyReadonlyArray2<'_, f64>,
        accel: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let (gyro, accel) = (gyro.as_slice()?.as_chunks::<3>().0, accel.as_slice()?.as_chunks::<3>().0);
        let t_ns = t_ns.as_slice()?;
        self.meanwhile(py, |live| {
            t_ns.iter().zip(gyro).zip(accel).try_for_each(|((&t_ns, &gyro), &accel)| {
                live.feed_sample(ImuSample { t: Stamp::from_ns(t_ns), gyro, accel })
            })
        })
        .map_err(refused)
    }

    /// An image whose rows are contiguous; copied while the interpreter is held, so that nobody changes it meanwhile.
    fn feed_image(&self, py: Python<'_>, t_ns: i64, image: PyReadonlyArray2<'_, u8>) -> PyResult<()> {
        let [height, width] = [image.shape()[0], image.shape()[1]];
        let view = GrayView::new(width, height, width, image.as_slice()?);
        let view = view.map_err(|error| Error::new_err(format!("image: {error}")))?;
        self.briefly(py, |live| live.feed_image(Stamp::from_ns(t_ns), view)).map_err(refused)
    }

    /// Ids and points of a frame.
    fn feed_tracks(
        &self,
        py: Python<'_>,
        t_ns: i64,
        ids: PyReadonlyArray1<'_, u64>,
        points: PyReadonlyArray2<'_, f64>,
        normalised: bool,
    ) -> PyResult<()> {
        let points = points.as_slice()?.as_chunks::<2>().0;
        let tracks = ids.as_slice()?.iter().copied().zip(points.iter().copied());
        self.briefly(py, |live| live.feed_tracks(Stamp::from_ns(t_ns), tracks, normalised)).map_err(refused)
    }

    fn end(&self, py: Python<'_>) -> PyResult<()> {
        self.meanwhile(py, Live::end).map_err(refused)
    }

    /// The next update as a dictionary.
    fn next_update<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let update = self.meanwhile(py, Live::next_update);
        update.map(|update| dictionary(py, &update)).transpose()
    }

    fn waiting(&self, py: Python<'_>) -> Option<String> {
        self.briefly(py, |live| live.waiting())
    }

    fn warnings(&self, py: Python<'_>) -> Vec<String> {
        self.briefly(py, |live| std::iter::from_fn(|| live.take_warning()).collect())
    }

    /// Rate, accelerometer, gyroscope, their walks, pixel, how unsure.
    #[allow(clippy::type_complexity)]
    fn noise(&self, py: Python<'_>) -> Option<(f64, [f64; 3], [f64; 3], f64, f64, f64, Option<[f64; 8]>)> {
        let found = self.briefly(py, |live| live.noise())?;
        let of = |sensor| found.sample.of(sensor);
        Some((
            found.rate.hz(),
            of(Sensor::Accel),
            of(Sensor::Gyro),
            found.accel_walk,
            found.gyro_walk,
            found.pixel,
            found.unsure,
        ))
    }
}

/// The fields of `dpn.Update`.
fn dictionary<'py>(py: Python<'py>, update: &Update) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let array = |values: Vec<f64>| PyArray1::from_vec(py, values);
    let waits_for = match &update.phase {
        Phase::Tracking => None,
        Phase::Initialising(reason) => Some(reason.to_string()),
        Phase::Restarted(reason) => Some(reason.to_string()),
    };
    let phase = match &update.phase {
        Phase::Tracking => "tracking",
        Phase::Initialising(_) => "initialising",
        Phase::Restarted(_) => "restarted",
    };
    dict.set_item("t_ns", update.t.ns())?;
    dict.set_item("phase", phase)?;
    dict.set_item("waits_for", waits_for)?;
    let state = update.state.as_ref();
    dict.set_item(
        "position",
        state.map(|s| array(s.world_from_body.translation.vector.as_slice().to_vec())),
    )?;
    let orientation = state.map(|s| {
        let q = s.world_from_body.rotation;
        array(vec![q.w, q.i, q.j, q.k])
    });
    dict.set_item("orientation", orientation)?;
    dict.set_item("velocity", state.map(|s| array(s.vel_in_world.as_slice().to_vec())))?;
    dict.set_item("accel_bias", state.map(|s| array(s.bias.accel.as_slice().to_vec())))?;
    dict.set_item("gyro_bias", state.map(|s| array(s.bias.gyro.as_slice().to_vec())))?;
    let covariance = update.covariance.as_ref().map(|c| array(c.transpose().as_slice().to_vec()));
    dict.set_item("covariance", covariance.map(|c| c.call_method1("reshape", (6, 6))).transpose()?)?;
    let levels = update.levels.as_deref();
    let levels = levels.map(|l| array(l.inertial.0.into_iter().chain([l.pixel]).collect()));
    dict.set_item("levels", levels)?;
    dict.set_item("scale_std", update.scale_std)?;
    dict.set_item("tracked", update.tracked)?;
    dict.set_item("landmarks", update.landmarks)?;
    Ok(dict)
}
