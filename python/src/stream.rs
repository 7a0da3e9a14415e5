//! Samples in as they come, deviations out.

use crate::error::{Error, raise};
use crate::network::Network;
use dpn_core::{ImuSample, Sensor, Stamp};
use dpn_pronet::{DualProNet, SampleStream};
use pyo3::prelude::*;

/// Accelerometer, gyroscope; whether they are known, out of range by sensor, and at a wrong rate.
type Answer = ([f64; 3], [f64; 3], bool, [bool; 2], bool);

/// Both networks beside running samples.
#[pyclass(module = "dpn._dpn")]
pub(crate) struct Stream {
    inner: SampleStream,
}

#[pymethods]
impl Stream {
    #[new]
    fn new(accel: &Network, gyro: &Network, every: usize) -> PyResult<Self> {
        let pair = DualProNet::new("python", &accel.inner.weights, &gyro.inner.weights, every);
        Ok(Self { inner: SampleStream::new(pair.map_err(|e| Error::new_err(format!("accel, gyro: {e}")))?) })
    }

    fn feed(&mut self, t_ns: i64, gyro: [f64; 3], accel: [f64; 3]) -> PyResult<()> {
        self.inner.feed(ImuSample { t: Stamp::from_ns(t_ns), gyro, accel }).map_err(|e| raise(&e))
    }

    fn sigma(&self) -> Answer {
        let found = self.inner.sigma();
        let of = |sensor| found.noise.of(sensor);
        (of(Sensor::Accel), of(Sensor::Gyro), found.known, found.out_of_range, found.wrong_rate)
    }
}
