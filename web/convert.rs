//! `dpn noise convert` for the page.

use crate::failure::Failure;
use dpn_core::SampleRate;
use dpn_io::noise_formats::{Conversion, Given, NoiseCalibration, parse};
use std::path::Path;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// Figures of a configuration, or typed ones, as the format `to`; what `dpn noise convert --json` prints. `typed` are accelerometer noise and
/// walk, gyroscope noise and walk, each empty where it is not given; rates are empty or in Hz.
///
/// # Errors
/// A sentence: what is no figure, no rate, no format or no configuration.
#[wasm_bindgen]
#[allow(clippy::needless_pass_by_value, reason = "strings cross to JavaScript by value")]
pub fn convert(
    config: &str,
    name: &str,
    typed: Vec<String>,
    rate: &str,
    to: &str,
    to_rate: &str,
) -> Result<String, JsError> {
    Ok(converted(config, name, &typed, [rate, to_rate], to)?)
}

fn converted(
    config: &str,
    name: &str,
    typed: &[String],
    rates: [&str; 2],
    to: &str,
) -> Result<String, Failure> {
    let [from_rate, to_rate] = rates.map(rate);
    let figure = |at: usize| typed.get(at).map(|text| text.trim()).filter(|text| !text.is_empty());
    let given = Given { rate: from_rate?, ..Given::default() }.with_typed(std::array::from_fn(figure))?;
    let source = match config.trim() {
        "" => NoiseCalibration::typed(&given)?,
        _ => parse(config.as_bytes(), Path::new(name), None, &given)?,
    };
    let to =
        to.parse().map_err(|e: dpn_io::noise_formats::UnknownFormat| Failure::new(e.to_string(), None))?;
    Ok(Conversion::of(source, to, to_rate?)?.json().to_string() + "\n")
}

fn rate(text: &str) -> Result<Option<SampleRate>, Failure> {
    if text.trim().is_empty() {
        return Ok(None);
    }
    let rate = text.trim().parse().ok().and_then(SampleRate::from_hz);
    let remedy = "give samples a second, such as 200".to_owned();
    rate.map(Some).ok_or_else(|| Failure::new(format!("`{}` is no rate", text.trim()), remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_figures_become_a_configuration_and_nonsense_a_sentence() {
        let typed = ["0.2 mg/sqrt(Hz)", "", "0.005 deg/s/sqrt(Hz)", ""].map(str::to_owned);
        let json = converted("", "typed", &typed, ["200", ""], "kalibr").unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(json["text"].as_str().unwrap().contains("accelerometer_noise_density: 0.00196133"), "{json}");
        assert!(converted("", "typed", &typed, ["fast", ""], "kalibr").is_err());
        assert!(converted("", "typed", &typed, ["200", ""], "kalibrate").is_err());
        assert!(converted("a: [", "a.yaml", &typed, ["200", ""], "kalibr").is_err());
    }
}
