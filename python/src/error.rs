//! The one exception of the package.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;

create_exception!(
    _dpn,
    Error,
    PyValueError,
    "What was given cannot be used; says what, where and how to mend it."
);

/// The error and all of its causes in one line.
pub(crate) fn raise(error: &dyn std::error::Error) -> PyErr {
    Error::new_err(dpn_io::in_full(error))
}

/// `value`, or the exception about the argument `name`.
pub(crate) fn parsed<T: std::str::FromStr>(name: &str, text: Option<&str>) -> Result<Option<T>, PyErr>
where
    T::Err: std::fmt::Display,
{
    text.map(|text| text.parse().map_err(|error| Error::new_err(format!("{name}: {error}")))).transpose()
}

/// The choice that `text` names, as configurations spell it, or the exception about the argument `name`.
pub(crate) fn word<T>(name: &str, text: Option<&str>) -> Result<Option<T>, PyErr>
where
    T: for<'de> serde::Deserialize<'de>,
{
    let read = |text: &str| serde_json::from_value(text.into());
    text.map(|text| read(text).map_err(|error| Error::new_err(format!("{name}: {error}")))).transpose()
}
