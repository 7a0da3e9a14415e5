//! What a reader chose of a log, and the log it makes.

use crate::{Kind, Log, LogError, LogOptions};
use dpn_core::Samples;
use dpn_io::{IoError, SampleStore, Sieved};
use std::path::Path;

/// Share of the samples whose stamps may go back.
const TOLERATED: f64 = 0.1;

/// The samples of a topic, or of two that were joined.
#[derive(Debug)]
pub(crate) struct Chosen {
    pub(crate) topic: String,
    pub(crate) samples: SampleStore,
    pub(crate) sieved: Sieved,
    pub(crate) remarks: Vec<String>,
    /// What was taken for granted.
    pub(crate) guesses: Vec<String>,
}

impl Chosen {
    /// The log; `place` as in [`Log::place`].
    ///
    /// # Errors
    /// A clock that runs back again and again; fewer than two samples.
    pub(crate) fn log(
        self,
        path: &Path,
        kind: Kind,
        place: &'static str,
        damage: Option<String>,
        options: &LogOptions,
    ) -> Result<Log, LogError> {
        let Self { topic, samples, sieved, remarks, guesses } = self;
        let of = samples.len() + sieved.count();
        if let Some(first) = sieved.backward.first
            && sieved.backward.count as f64 > TOLERATED * of as f64
        {
            return Err(LogError::Backward {
                path: path.to_path_buf(),
                count: sieved.backward.count,
                of,
                first,
            });
        }
        let recording = options.scales.apply(samples).and_then(SampleStore::recording);
        match recording.map_err(|e| IoError::reading(path, e))? {
            Ok(recording) => Ok(Log {
                topic: Some(topic),
                sieved,
                place,
                damage,
                guesses,
                remarks,
                ..Log::sound(kind, recording)
            }),
            Err(found) => {
                let reason = damage.or_else(|| remarks.into_iter().next());
                Err(LogError::TooFew { path: path.to_path_buf(), topic, found, reason })
            }
        }
    }
}
