//! Files of results that may not be there yet.

use dpn_io::IoError;
use std::io::ErrorKind;
use std::path::Path;

/// The text of a file, empty where there is none.
pub(crate) fn text_of(path: &Path) -> Result<String, IoError> {
    match std::fs::read(path) {
        // What is no text is damage, which whoever takes the lines apart finds.
        Ok(bytes) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(String::new()),
        Err(source) => Err(IoError::Read { path: path.to_path_buf(), source }),
    }
}
