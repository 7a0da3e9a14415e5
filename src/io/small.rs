//! Files that people write by hand: read whole, once through, and refused where no hand wrote so much.

use crate::IoError;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The largest configuration \[bytes\]: parsed, a byte of YAML can take forty.
pub(crate) const LARGEST_CONFIG: u64 = 4 << 20;

/// The bytes of the configuration at `path`, which may be a pipe.
///
/// # Errors
/// A file that cannot be read or has more than [`LARGEST_CONFIG`] bytes.
pub(crate) fn read_config(path: &Path) -> Result<Vec<u8>, IoError> {
    let file = File::open(path).map_err(|e| IoError::reading(path, e))?;
    read_config_from(file, path)
}

/// The same from any source; `path` is for messages.
pub(crate) fn read_config_from(source: impl Read, path: &Path) -> Result<Vec<u8>, IoError> {
    let what = "configuration";
    let too_large = || IoError::TooLarge { path: path.to_path_buf(), what, most: LARGEST_CONFIG };
    bounded(source).map_err(|e| IoError::reading(path, e))?.ok_or_else(too_large)
}

/// All bytes; none where there are more than [`LARGEST_CONFIG`].
pub(crate) fn bounded(source: impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    source.take(LARGEST_CONFIG + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= LARGEST_CONFIG).then_some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_given_for_a_configuration_is_refused_after_its_first_megabytes() {
        let path = Path::new("log.csv");
        let error = read_config_from(std::io::repeat(b'1'), path).unwrap_err();
        assert_eq!(error.to_string(), "log.csv: more than 4194304 bytes; no configuration is as large");
        assert_eq!(read_config_from(&b"a: 1"[..], path).unwrap(), b"a: 1");
    }
}
