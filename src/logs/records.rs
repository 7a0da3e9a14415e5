//! IMUs of a log that names its records and numbers those who write them, as autopilots' do: one is chosen.

use crate::chosen::Chosen;
use crate::join::join;
use crate::{Kind, Log, LogError, LogOptions};
use dpn_core::ImuSample;
use dpn_io::{IoError, Sieve};
use std::path::Path;

/// What a record's axes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holds {
    Both,
    Gyro,
    Accel,
}

/// One that writes.
#[derive(Debug)]
struct Source {
    /// `IMU/0`, `sensor_combined/0`.
    name: String,
    holds: Holds,
    /// The lower the better.
    order: (u32, u32),
    records: u64,
    sieve: Sieve,
}

/// All of them.
#[derive(Debug, Default)]
pub(crate) struct Records(Vec<Source>);

/// Logs have a few; a damaged one may name thousands, and each would make room.
const MOST: usize = 64;

impl Records {
    /// The place of the source `name` with the number `instance`; `None` where there are too many.
    pub(crate) fn source(&mut self, name: &str, instance: u32, holds: Holds, order: u32) -> Option<usize> {
        let name = format!("{name}/{instance}");
        let found = self.0.iter().position(|source| source.name == name);
        found.or_else(|| {
            (self.0.len() < MOST).then(|| {
                let order = (order, instance);
                self.0.push(Source { name, holds, order, records: 0, sieve: Sieve::default() });
                self.0.len() - 1
            })
        })
    }

    pub(crate) fn push(&mut self, source: usize, sample: ImuSample) {
        let source = &mut self.0[source];
        source.records += 1;
        source.sieve.push(sample, source.records);
    }

    /// The wanted one, or the first; gyroscope and accelerometer of their own are joined where no source has both.
    ///
    /// # Errors
    /// None that is an IMU, or wanted; too few samples; a clock that runs back again and again.
    pub(crate) fn log(
        mut self,
        path: &Path,
        kind: Kind,
        damage: Option<String>,
        options: &LogOptions,
    ) -> Result<Log, LogError> {
        self.0.retain(|source| source.records > 0);
        self.0.sort_by_key(|source| source.order);
        let listed = self.0.iter().map(|source| source.name.clone()).collect::<Vec<_>>().join(", ");
        let wanted = options.topic.as_deref();
        let is_wanted = |source: &Source| {
            wanted.is_none_or(|wanted| {
                source.name == wanted || source.name.rsplit_once('/').is_some_and(|(name, _)| name == wanted)
            })
        };
        let first =
            |holds: Holds| self.0.iter().position(|source| source.holds == holds && is_wanted(source));
        let mut guesses = Vec::new();
        let mut remarks = Vec::new();
        let storing = |e| IoError::reading(path, e);
        let (topic, sifted) = match (first(Holds::Both), first(Holds::Gyro), first(Holds::Accel), wanted) {
            (Some(at), ..) => {
                let others = self.0.iter().filter(|source| source.holds == Holds::Both).count() - 1;
                let Source { name, sieve, .. } = self.0.swap_remove(at);
                if others > 0 && wanted.is_none_or(|wanted| wanted != name) {
                    let (record, instance) = name.rsplit_once('/').unwrap_or((&name, "0"));
                    guesses.push(format!(
                        "{record} of instance {instance}, of {} (--topic {record}/1)",
                        others + 1
                    ));
                }
                (name, sieve.done().map_err(storing)?)
            }
            (None, Some(gyro), Some(accel), _) => {
                // The later in the list first: taking one moves none before it.
                let mut take = |at: usize| {
                    let Source { name, sieve, .. } = self.0.remove(at);
                    sieve.done().map(|sifted| (name, sifted)).map_err(storing)
                };
                let (gyro, accel) = match gyro > accel {
                    true => (take(gyro)?, take(accel)?),
                    false => {
                        let accel = take(accel)?;
                        (take(gyro)?, accel)
                    }
                };
                let joined = join(&gyro.1.part.samples, &accel.1.part.samples).map_err(storing)?;
                guesses.push(joined.remark(&gyro.0, &accel.0));
                remarks.extend(joined.left_out());
                (gyro.0, gyro.1.with(joined.samples))
            }
            (.., Some(wanted)) if !self.0.is_empty() => {
                let wanted = wanted.to_owned();
                return Err(LogError::NoTopic {
                    path: path.to_path_buf(),
                    wanted,
                    similar: None,
                    topics: listed,
                });
            }
            _ => {
                return Err(LogError::NoImu { path: path.to_path_buf(), topics: listed, damage });
            }
        };
        Chosen { topic, sifted, clocks: None, remarks, guesses }.log(path, kind, "record", damage, options)
    }
}
