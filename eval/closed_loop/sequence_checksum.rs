//! Checksums of what sequences are read from: results are named by them.

use super::error::ClosedLoopError;
use super::sequence_set::{SequenceSet, Sequences, TrackSource, tracks_file};
use dpn_core::checksum::{hex, of_parts, of_source};
use dpn_io::asl::Sequence;
use dpn_io::{ImageFolder, IoError};
use dpn_logs::LogOptions;
use dpn_sim::Flight;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::Path;

impl SequenceSet {
    /// SHA-256 over the files that the sequence at `place` is read from, its images among them; of a flight, over nothing but its name.
    /// Images are read anew each time: a second for some gigabytes in the system's cache, and nothing remembered that may have changed.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn checksum(&self, place: usize) -> Result<String, ClosedLoopError> {
        let mut hash = Sha256::new();
        match &self.of {
            Sequences::Recorded(sequences) => {
                let (sequence, _) = &sequences[place];
                for sum in checksums(sequence, &self.tracks) {
                    hash.update(sum?);
                }
                if self.imu != LogOptions::default() {
                    hash.update(format!("{:?}", self.imu));
                }
                if let TrackSource::Images { .. } = self.tracks {
                    let folder = ImageFolder::open(sequence)?;
                    let sums = folder.files().par_iter().map(|(t, path)| Ok((t, checksum_of_image(path)?)));
                    for (t, sum) in sums.collect::<Result<Vec<_>, IoError>>()? {
                        hash.update(t.ns().to_le_bytes());
                        hash.update(sum);
                    }
                }
            }
            Sequences::Logged(log) => hash.update(log.checksum()?),
            Sequences::Flights(_) => hash.update(Flight::ALL[place].name()),
        }
        Ok(hex(hash.finalize()))
    }

    /// The same of a sequence that need not be whole, without its images: what its samples are read from, as far as it is there.
    pub(super) fn checksum_of_samples(&self, place: usize) -> String {
        match &self.of {
            Sequences::Recorded(sequences) => {
                // A file that cannot be read has no checksum, and one that is empty has.
                of_parts(
                    checksums(&sequences[place].0, &self.tracks).into_iter().map(Result::unwrap_or_default),
                )
            }
            Sequences::Logged(log) => log.checksum().unwrap_or_default(),
            Sequences::Flights(_) => Flight::ALL[place].name().to_owned(),
        }
    }
}

/// SHA-256 of an image's file; zeros of one that is not there.
fn checksum_of_image(path: &Path) -> Result<[u8; 32], IoError> {
    // Opening a pipe of that name would wait for a writer.
    if !path.is_file() {
        return Ok([0; 32]);
    }
    let mut hash = Sha256::new();
    std::fs::File::open(path)
        .and_then(|mut file| std::io::copy(&mut file, &mut hash))
        .map_err(|source| IoError::Read { path: path.to_path_buf(), source })?;
    Ok(hash.finalize().into())
}

/// SHA-256 of the files that a sequence is read from, but for its images.
fn checksums(sequence: &Sequence, tracks: &TrackSource) -> Vec<Result<String, IoError>> {
    let mut sums = sequence.checksums();
    if let TrackSource::File(dir) = tracks {
        let file = tracks_file(dir, sequence);
        let read = std::fs::File::open(&file).and_then(of_source);
        sums.push(read.map_err(|e| IoError::reading(&file, e)));
    }
    sums
}
