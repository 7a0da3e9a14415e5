//! Corpora from folders of ASL sequences.

use crate::corpus::{Corpus, CorpusError, Member};
use crate::split::{Side, assign, paper_side};
use dpn_core::SampleRate;
use dpn_io::IoError;
use dpn_io::asl::{Sequence, discover};
use rayon::prelude::*;
use std::path::Path;
use thiserror::Error;

/// Name of the collection of EuRoC's sequences.
pub const EUROC: &str = "euroc";
/// Name of the collection of TUM-VI's rooms.
pub const TUM_VI: &str = "tumvi";

/// Why a folder gives no corpus.
#[derive(Debug, Error)]
pub enum LoadError {
    /// A file or folder cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// What was read does not serve.
    #[error(transparent)]
    Corpus(#[from] CorpusError),
}

impl LoadError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Io(error) => error.hint(),
            Self::Corpus(error) => error.hint(),
        }
    }
}

/// Every corpus under `dir`, brought to `rate`: EuRoC's sequences, TUM-VI's rooms, and the rest under the folder's own name.
///
/// `dir` may be a folder of data sets (then its `euroc` and `tumvi` are looked at), a folder of sequences, or one
/// sequence. EuRoC's sequences are split as in the paper; of TUM-VI room1 and room2 are for development, room3 and room4
/// test; the rest alternates.
///
/// # Errors
/// No sequence; a file that cannot be read; a recording that is slower or that windows cannot be cut from.
pub fn load(dir: &Path, rate: SampleRate) -> Result<Vec<Corpus>, LoadError> {
    let sets: Vec<_> =
        [EUROC, TUM_VI].iter().map(|name| dir.join(name)).filter(|path| path.is_dir()).collect();
    let mut sequences = Vec::new();
    if sets.is_empty() {
        sequences = discover(dir)?;
    }
    for set in sets {
        sequences.extend(discover(&set)?);
    }
    let own_name = dir.file_name().map_or_else(|| "data".into(), |name| name.to_string_lossy().into_owned());
    let mut groups: [(String, Vec<&Sequence>); 3] =
        [(EUROC.to_owned(), Vec::new()), (TUM_VI.to_owned(), Vec::new()), (own_name, Vec::new())];
    for sequence in &sequences {
        let at = match sequence.short_name() {
            name if paper_side(name).is_some() => 0,
            name if tum_vi_side(name).is_some() => 1,
            _ => 2,
        };
        groups[at].1.push(sequence);
    }
    groups
        .into_iter()
        .filter(|(_, members)| !members.is_empty())
        .map(|(name, members)| corpus(name, &members, rate))
        .collect()
}

fn corpus(name: String, sequences: &[&Sequence], rate: SampleRate) -> Result<Corpus, LoadError> {
    let rest = assign(sequences.iter().map(|s| s.short_name()));
    let members: Result<Vec<Member>, IoError> = sequences
        .par_iter()
        .map(|sequence| {
            let short = sequence.short_name().to_owned();
            let known = paper_side(&short).or_else(|| tum_vi_side(&short));
            let side = known.unwrap_or_else(|| {
                rest.iter().find(|(n, _)| *n == short).expect("every name was given a side").1
            });
            Ok(Member { recording: sequence.imu()?, side, name: short })
        })
        .collect();
    Ok(Corpus::brought_to(rate, name, members?)?)
}

/// Side of a TUM-VI room sequence; `None` for any other name.
fn tum_vi_side(name: &str) -> Option<Side> {
    match name {
        "room1" | "room2" => Some(Side::Train),
        "room3" | "room4" => Some(Side::Test),
        _ => None,
    }
}
