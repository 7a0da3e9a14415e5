//! A network trained as `dpn train` does.

use crate::error::{Error, raise};
use crate::progress::Listener;
use crate::recording::Recording;
use dpn_core::Sensor;
use dpn_core::progress::Progress;
use dpn_train::Device;
use dpn_train::corpus::{Corpus, Member, to_train};
use dpn_train::run::Run;
use dpn_train::split::Side;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Steps done are told to Python, and its exception ends the training at the next one.
struct Steps<'a> {
    listener: &'a mut Listener,
    stop: &'a AtomicBool,
    total: u64,
}

impl Progress for Steps<'_> {
    fn start(&mut self, _what: &str, total: u64) {
        self.total = total;
    }

    fn step(&mut self, done: u64, _note: &str) {
        if self.listener.step(done as f64, self.total as f64).is_break() {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn finish(&mut self, _note: &str) {}
}

/// Trains on the folder `data` or on `recordings` by name, in the folder `out`; gives the weights' file and the summary as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn train(
    py: Python<'_>,
    data: Option<PathBuf>,
    recordings: Vec<(String, PyRef<'_, Recording>)>,
    sensor: &str,
    out: PathBuf,
    config_file: Option<PathBuf>,
    config_text: &str,
    resume: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(PathBuf, String)> {
    let sensor: Sensor = serde_json::from_value(sensor.into())
        .map_err(|_| Error::new_err(format!("sensor: {sensor:?}; known are accel, gyro")))?;
    let config = match &config_file {
        Some(path) => dpn_train::config::load(path, sensor),
        None => dpn_train::config::parse(config_text, Path::new("config"), sensor),
    };
    let config = config.map_err(|e| raise(&e))?;
    if config.sensor() != sensor {
        return Err(Error::new_err(format!("config: for the sensor {}; expected {sensor}", config.sensor())));
    }
    let mut members = Vec::new();
    for (name, recording) in &recordings {
        members.push(Member { name: name.clone(), recording: recording.held()?, side: Side::Train });
    }
    let mut listener = Listener::new(progress);
    let stop = AtomicBool::new(false);
    let done = py.detach(|| {
        let corpus = match &data {
            Some(dir) => to_train(dpn_train::asl::load(dir, config.rate_hz).map_err(|e| raise(&e))?)
                .ok_or_else(|| Error::new_err(format!("data: no sequence in {}", dir.display())))?,
            None => Corpus::brought_to(config.rate_hz, "python", members).map_err(|e| raise(&e))?,
        };
        let run = Run::open(&out, &config, &corpus, &Device::Cpu, resume).map_err(|e| raise(&e))?;
        let mut steps = Steps { listener: &mut listener, stop: &stop, total: 0 };
        let (summary, path) = run.train(&stop, &mut steps).map_err(|e| raise(&e))?;
        let summary = serde_json::to_string(&summary).map_err(|e| raise(&e))?;
        Ok((path.path().to_path_buf(), summary))
    });
    listener.or(done)
}
