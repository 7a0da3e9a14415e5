//! IMUs of a log that names its records and numbers those who write them, as autopilots' do: one is chosen.

use crate::chosen::Chosen;
use crate::join::join;
use crate::{Kind, Log, LogError, LogOptions};
use dpn_core::{ImuSample, Stamp};
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
pub(crate) struct Records {
    sources: Vec<Source>,
    /// Means of the motors' outputs by time, and how good the record is that they are from, 0 the best.
    motors: Vec<(Stamp, f64)>,
    motors_order: u8,
}

/// Outputs of motors are kept so far apart \[s\].
const MOTORS_APART_S: f64 = 0.02;

/// Logs have a few; a damaged one may name thousands, and each would make room.
const MOST: usize = 64;

impl Records {
    /// The place of the source `name` with the number `instance`; `None` where there are too many.
    pub(crate) fn source(&mut self, name: &str, instance: u32, holds: Holds, order: u32) -> Option<usize> {
        let name = format!("{name}/{instance}");
        let found = self.sources.iter().position(|source| source.name == name);
        found.or_else(|| {
            (self.sources.len() < MOST).then(|| {
                let order = (order, instance);
                self.sources.push(Source { name, holds, order, records: 0, sieve: Sieve::default() });
                self.sources.len() - 1
            })
        })
    }

    /// Outputs of the motors, of which the finite ones count; what a better record has takes a worse one's place.
    pub(crate) fn motors(&mut self, order: u8, t: Stamp, outputs: impl Iterator<Item = f64>) {
        let outputs: Vec<f64> = outputs.filter(|output| output.is_finite()).collect();
        if outputs.is_empty() || (order > self.motors_order && !self.motors.is_empty()) {
            return;
        }
        if order < self.motors_order {
            self.motors.clear();
        }
        self.motors_order = order;
        if self.motors.last().is_none_or(|(last, _)| t.seconds_since(*last) >= MOTORS_APART_S) {
            self.motors.push((t, outputs.iter().sum::<f64>() / outputs.len() as f64));
        }
    }

    /// Whether nobody wrote.
    #[cfg(feature = "blackbox")]
    pub(crate) fn are_none(&self) -> bool {
        self.sources.iter().all(|source| source.records == 0)
    }

    pub(crate) fn push(&mut self, source: usize, sample: ImuSample) {
        let source = &mut self.sources[source];
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
        self.sources.retain(|source| source.records > 0);
        self.sources.sort_by_key(|source| source.order);
        let listed = self.sources.iter().map(|source| source.name.clone()).collect::<Vec<_>>().join(", ");
        let wanted = options.topic.as_deref();
        let is_wanted = |source: &Source| {
            wanted.is_none_or(|wanted| {
                source.name == wanted || source.name.rsplit_once('/').is_some_and(|(name, _)| name == wanted)
            })
        };
        let first =
            |holds: Holds| self.sources.iter().position(|source| source.holds == holds && is_wanted(source));
        let mut guesses = Vec::new();
        let mut remarks = Vec::new();
        let storing = |e| IoError::reading(path, e);
        let (topic, sifted) = match (first(Holds::Both), first(Holds::Gyro), first(Holds::Accel), wanted) {
            (Some(at), ..) => {
                let others = self.sources.iter().filter(|source| source.holds == Holds::Both).count() - 1;
                let Source { name, sieve, .. } = self.sources.swap_remove(at);
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
                    let Source { name, sieve, .. } = self.sources.remove(at);
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
            (.., Some(wanted)) if !self.sources.is_empty() => {
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
        let log = Chosen { topic, sifted, clocks: None, variances: [None; 2], remarks, guesses }
            .log(path, kind, "record", damage, options)?;
        Ok(Log { motors: self.motors, ..log })
    }
}
