//! What a reader chose of a log, and the log it makes.

use crate::log::other_parts;
use crate::{Kind, Log, LogError, LogOptions};
use dpn_core::Samples;
use dpn_io::{IoError, Part, SampleStore, Sifted};
use std::path::Path;

/// Share of the samples whose stamps may go back.
const TOLERATED: f64 = 0.1;

/// The samples of a topic, or of two that were joined.
#[derive(Debug)]
pub(crate) struct Chosen {
    pub(crate) topic: String,
    pub(crate) sifted: Sifted,
    /// That there were two clocks.
    pub(crate) clocks: Option<String>,
    /// As [`Log::variances`].
    pub(crate) variances: [Option<[f64; 3]>; 2],
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
        options.without_columns(path, kind.name())?;
        let Self { topic, sifted, clocks, variances, remarks, guesses } = self;
        let Sifted { part: Part { samples, places }, others, sieved } = sifted;
        let of = samples.len() + others.iter().map(|part| part.samples.len()).sum::<usize>() + sieved.count();
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
        let storing = |e| IoError::reading(path, e);
        let others = other_parts(others, places, |samples| options.settled(samples)).map_err(storing)?;
        let recording = options.settled(samples).and_then(SampleStore::recording);
        match recording.map_err(storing)? {
            Ok(recording) => Ok(Log {
                topic: Some(topic),
                places,
                others,
                clocks,
                variances,
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
