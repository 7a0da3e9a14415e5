//! ONNX Runtime's answers (`golden/onnx/make.py`) against ours.

use crate::models::all;
use dpn_testing::golden;
use serde::{Deserialize, Serialize};

/// What ONNX Runtime says of a model.
#[derive(Deserialize)]
struct Case {
    name: String,
    /// SHA-256 of the model's file.
    model: String,
    /// By output.
    answers: Vec<Vec<f32>>,
}

#[test]
fn onnx_runtime_says_the_same_of_the_same_models() {
    let cases: Vec<Case> = golden("onnx");
    let models = all();
    assert_eq!(cases.len(), models.len(), "run golden/onnx/make.py again");
    for (case, model) in cases.iter().zip(&models) {
        let what = &model.name;
        assert_eq!(case.name, *what, "run golden/onnx/make.py again");
        assert_eq!(
            dpn_core::checksum::of_bytes(&model.bytes),
            case.model,
            "{what}: run golden/onnx/make.py again"
        );
        assert_eq!(case.answers.len(), model.ours.len(), "{what}");
        for (theirs, ours) in case.answers.iter().zip(&model.ours) {
            assert_eq!(theirs.len(), ours.len(), "{what}");
            for (i, (t, o)) in theirs.iter().zip(ours).enumerate() {
                assert!(
                    (t - o).abs() <= 1e-5 * o.abs(),
                    "{what}: answer {i}: {t} by ONNX Runtime, {o} by ours"
                );
            }
        }
    }
}

/// What `make.py` reads: models/N.onnx and models.json.
#[derive(Serialize)]
struct Asked {
    name: String,
    shape: Vec<usize>,
    input: Vec<f32>,
}

#[test]
#[ignore = "writes the models that golden/onnx/make.py asks ONNX Runtime about, into DPN_ONNX"]
fn models_are_written() {
    let folder = std::path::PathBuf::from(std::env::var_os("DPN_ONNX").expect("DPN_ONNX names a folder"));
    let mut asked = Vec::new();
    for (number, model) in all().into_iter().enumerate() {
        std::fs::write(folder.join(format!("{number}.onnx")), &model.bytes).unwrap();
        asked.push(Asked { name: model.name, shape: model.shape, input: model.input });
    }
    std::fs::write(folder.join("models.json"), serde_json::to_string(&asked).unwrap()).unwrap();
}
