//! A result of a stage: read where its file is there, made and written where it is not.

use super::error::PaperError;
use dpn_io::{ResultPath, write_json};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Reads `path`, or makes it and writes it. A file that does not read is an error: it is not ours to throw away.
pub(super) fn cached<T: Serialize + DeserializeOwned>(
    path: &ResultPath,
    make: impl FnOnce() -> Result<T, PaperError>,
) -> Result<(T, bool), PaperError> {
    match path.read()? {
        Some(bytes) => {
            let value = serde_json::from_slice(&bytes).map_err(|error| PaperError::Stale {
                path: path.path().to_path_buf(),
                message: format!("it does not read ({error})"),
            })?;
            Ok((value, true))
        }
        None => {
            let value = make()?;
            write_json(path, &value)?;
            Ok((value, false))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_read_and_what_does_not_read_is_named_and_kept() {
        let dir = tempfile::tempdir().unwrap();
        let path = ResultPath::from(dir.path()).join("a/rows.json");
        let numbers = vec![0.1, 1.0 / 3.0];
        assert_eq!(cached(&path, || Ok(numbers.clone())).unwrap(), (numbers.clone(), false));
        let never = || -> Result<Vec<f64>, PaperError> { panic!("made again") };
        assert_eq!(cached(&path, never).unwrap(), (numbers, true));
        std::fs::write(path.path(), "[0.1, ").unwrap();
        let text = cached(&path, never).unwrap_err().to_string();
        assert!(text.contains("rows.json: it does not read") && text.ends_with("made again"), "{text}");
        assert!(path.is_file());
    }
}
