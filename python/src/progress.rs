//! Word to Python while work goes on without the interpreter, and Ctrl-C back from it.

use pyo3::prelude::*;
use std::ops::ControlFlow;

/// Who is told, and what Python answered: an exception of the callback's, or the `KeyboardInterrupt` of a Ctrl-C.
pub(crate) struct Listener {
    callback: Option<Py<PyAny>>,
    raised: Option<PyErr>,
}

impl Listener {
    pub(crate) fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { callback, raised: None }
    }

    /// Says how far the work is; `Break` where it is to end.
    pub(crate) fn step(&mut self, done: f64, total: f64) -> ControlFlow<()> {
        let answer = Python::attach(|py| {
            py.check_signals()?;
            self.callback.as_ref().map_or(Ok(()), |callback| callback.call1(py, (done, total)).map(|_| ()))
        });
        match answer {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised.get_or_insert(error);
                ControlFlow::Break(())
            }
        }
    }

    /// The exception that ended the work, else what the work came to.
    pub(crate) fn or<T>(self, done: PyResult<T>) -> PyResult<T> {
        self.raised.map_or(done, Err)
    }
}
