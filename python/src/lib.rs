//! The compiled half of the Python package `dpn`. Arguments were checked and brought to C-contiguous arrays of the right type by
//! `dpn/__init__.py`, which has the documentation; what is a table of figures comes back as JSON, the same text that the command line prints.
//! Long work lets go of the interpreter; a panic becomes `pyo3_runtime.PanicException`.

mod error;
mod gyro_bias;
mod metrics;
mod network;
mod noise_formats;
mod odometry;
mod probe;
mod progress;
mod recording;
mod run;
mod run_result;
mod sensors;
mod simulate;
mod stream;
mod train;

use pyo3::prelude::*;

/// Compiled half of `dpn`.
#[pymodule]
mod _dpn {
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::gyro_bias::GyroBias;
    #[pymodule_export]
    use crate::metrics::{trajectory_errors, trajectory_nees};
    #[pymodule_export]
    use crate::network::Network;
    #[pymodule_export]
    use crate::noise_formats::convert;
    #[pymodule_export]
    use crate::odometry::Odometry;
    #[pymodule_export]
    use crate::probe::{allan, check, noise};
    #[pymodule_export]
    use crate::recording::{Recording, from_arrays, read};
    #[pymodule_export]
    use crate::run::{run_arrays, run_source};
    #[pymodule_export]
    use crate::sensors::Sensors;
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::stream::Stream;
    #[pymodule_export]
    use crate::train::train;
    use pyo3::prelude::*;

    /// Runs the command line; gives the exit code.
    #[pyfunction]
    fn main(py: Python<'_>, args: Vec<std::ffi::OsString>) -> u8 {
        py.detach(|| dpn_program::main_with(args))
    }

    /// Says where this module's file is, which it does not know by itself.
    #[pyfunction]
    fn code_is_in(file: std::path::PathBuf) {
        dpn_program::code_is_in(file);
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("DEFAULT_TAG", dpn_core::estimate::DEFAULT_TAG)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
