//! What a bag's IMU and camera say, one by one.

use crate::error::raise;
use dpn_io::calibration;
use dpn_logs::{ImageLogOptions, LogOptions, SensorEvent, read_sensors};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, sync_channel};

/// Messages that wait.
const QUEUE: usize = 64;

enum Said {
    Event(SensorEvent),
    /// What was wrong where the bag ended early.
    Damage(String),
    Fault(PyErr),
}

/// A bag that is read on a thread of its own, which ends with this.
#[pyclass(frozen, module = "dpn._dpn")]
pub(crate) struct Sensors {
    said: Mutex<Receiver<Said>>,
}

#[pymethods]
impl Sensors {
    /// Images have the size that the calibration says, or `size`.
    #[new]
    fn new(
        path: PathBuf,
        calibration_file: Option<PathBuf>,
        size: Option<[usize; 2]>,
        topic: Option<String>,
        image_topic: Option<String>,
    ) -> PyResult<Self> {
        let size = match (calibration_file, size) {
            (Some(file), _) => {
                calibration::read(&file).map_err(|e| raise(&e))?.camera.resolution.map(|side| side as usize)
            }
            (None, size) => size.expect("Python asks for one"),
        };
        let imu = LogOptions { topic, ..LogOptions::default() };
        let options = ImageLogOptions { imu, image_topic, ..ImageLogOptions::default() };
        let (sender, said) = sync_channel(QUEUE);
        std::thread::spawn(move || {
            let read =
                read_sensors(&path, &options, size, &mut |event| match sender.send(Said::Event(event)) {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(_) => ControlFlow::Break(()),
                });
            // Nobody may be there any more.
            let _ = match read {
                Ok(None) => Ok(()),
                Ok(Some(damage)) => sender.send(Said::Damage(damage)),
                Err(error) => sender.send(Said::Fault(raise(&error))),
            };
        });
        Ok(Self { said: Mutex::new(said) })
    }

    /// A stamp and gyroscope, accelerometer; a stamp and an image (height, width); or words of what was passed over; None at the end.
    fn next<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let said = py.detach(|| self.said.lock().ok()?.recv().ok());
        let words = |words: String| Ok(Some(words.into_pyobject(py)?.into_any()));
        match said {
            None => Ok(None),
            Some(Said::Fault(error)) => Err(error),
            Some(Said::Damage(damage)) => words(format!("{damage}; what came before was used")),
            Some(Said::Event(SensorEvent::PassedOver(why))) => words(why),
            Some(Said::Event(SensorEvent::Image(_, Err(error)))) => words(error.to_string()),
            Some(Said::Event(SensorEvent::Sample(sample))) => {
                let row = (
                    sample.t.ns(),
                    PyArray1::from_slice(py, &sample.gyro),
                    PyArray1::from_slice(py, &sample.accel),
                );
                Ok(Some(row.into_pyobject(py)?.into_any()))
            }
            Some(Said::Event(SensorEvent::Image(t, Ok(image)))) => {
                let shape = [image.height(), image.width()];
                let pixels = PyArray1::from_slice(py, image.pixels()).reshape(shape)?;
                Ok(Some((t.ns(), pixels).into_pyobject(py)?.into_any()))
            }
        }
    }
}
