//! ONNX Runtime's answers (`golden/onnx/make.py`) against ours.

use crate::windows::{real, same};
use dpn_core::Sensor;
use dpn_pronet::{Predictor, Weights};
use dpn_testing::{golden, repository};
use serde::Deserialize;

/// What a model says of the windows of [`real`].
#[derive(Deserialize)]
struct Case {
    sensor: Sensor,
    network: String,
    /// SHA-256 of the model's file.
    model: String,
    sigma: Vec<f32>,
}

#[test]
fn onnx_runtime_says_the_same_of_the_same_models() {
    let cases: Vec<Case> = golden("onnx");
    assert!(cases.len() >= 4);
    for Case { sensor, network, model, sigma } in cases {
        let what = format!("{sensor} {network}");
        let weights =
            Weights::load(repository().join(format!("models/{sensor}/{network}.safetensors"))).unwrap();
        let bytes = dpn_onnx::to_bytes(&weights).unwrap();
        assert_eq!(dpn_core::checksum::of_bytes(&bytes), model, "{what}: run golden/onnx/make.py again");
        let windows = real(sensor, 200);
        let mut ours = vec![0.0; windows.len() / 200];
        Predictor::new(&weights).predict(&windows, &mut ours);
        same(&sigma, &ours, &what);
    }
}
