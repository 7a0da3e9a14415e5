//! Noise figures from one program's configuration to another's: `dpn noise convert`.

use crate::error::{Error, parsed, raise};
use dpn_core::SampleRate;
use dpn_io::noise_formats::{Format, Given, read, write};
use pyo3::prelude::*;
use std::path::PathBuf;

/// The JSON of `dpn noise convert --json`.
#[pyfunction]
pub(crate) fn convert(
    path: PathBuf,
    to: &str,
    from_format: Option<&str>,
    rate: Option<f64>,
    to_rate: Option<f64>,
) -> PyResult<String> {
    let checked = |name: &str, hz: Option<f64>| {
        hz.map(|hz| {
            SampleRate::from_hz(hz)
                .ok_or_else(|| Error::new_err(format!("{name}: {hz}; expected Hz above zero")))
        })
        .transpose()
    };
    let to: Format = to.parse().map_err(|error| Error::new_err(format!("to: {error}")))?;
    let from = parsed("from_format", from_format)?;
    let given = Given { rate: checked("rate", rate)?, ..Given::default() };
    let source = read(&path, from, &given).map_err(|e| raise(&e))?;
    let mut figures = source.figures;
    figures.rate = checked("to_rate", to_rate)?.or(figures.rate);
    let written = write(&figures, to, |_| None).map_err(|e| raise(&e))?;
    Ok(serde_json::json!({
        "from": source.format, "to": written.format, "rate_hz": figures.rate, "figures": figures,
        "steps": source.steps.iter().chain(&written.steps).collect::<Vec<_>>(),
        "remarks": source.remarks.iter().chain(&written.remarks).collect::<Vec<_>>(),
        "text": written.text,
    })
    .to_string())
}
