//! The recordings a run learns from and is judged on.

use crate::split::Side;
use crate::windows::WINDOW;
use dpn_core::{ImuRecording, Sensor};
use sha2::{Digest, Sha256};
use thiserror::Error;

/// Largest share by which a recording's rate may differ from 200 Hz: windows are counted in samples.
const RATE_TOLERANCE: f64 = 0.05;
/// The rate windows are cut for \[Hz\].
const RATE_HZ: f64 = 200.0;

/// One recording and the side of the split it stands on.
#[derive(Debug, Clone)]
pub struct Member {
    /// Name of the sequence.
    pub name: String,
    /// Its samples.
    pub recording: ImuRecording,
    /// Its side.
    pub side: Side,
}

/// Recordings of one kind.
#[derive(Debug, Clone)]
pub struct Corpus {
    /// Name of the collection, for example `euroc` or `simulated`.
    pub name: String,
    /// Its members, sorted by name.
    pub members: Vec<Member>,
}

/// Why recordings cannot be learned from.
#[derive(Debug, Error, PartialEq)]
pub enum CorpusError {
    /// A side has no recording.
    #[error("{corpus}: no {side} sequence among {names:?}; training needs sequences on both sides of the split")]
    EmptySide {
        /// The collection.
        corpus: String,
        /// The side.
        side: Side,
        /// Sequences there are.
        names: Vec<String>,
    },
    /// Too few samples for one window.
    #[error("{name}: {samples} samples are shorter than a window of {WINDOW}; leave the sequence out or record longer")]
    TooShort {
        /// The sequence.
        name: String,
        /// Its samples.
        samples: usize,
    },
    /// A rate that windows are not made for.
    #[error("{name}: {hz:.1} samples a second, but windows are cut for {RATE_HZ} Hz within 5 %; resample the recording")]
    Rate {
        /// The sequence.
        name: String,
        /// Its median rate.
        hz: f64,
    },
    /// An axis that never changes.
    #[error("{name}: {sensor} axis {axis} never changes from {value}; the sensor or its export is broken, leave the sequence out")]
    ConstantAxis {
        /// The sequence.
        name: String,
        /// The sensor.
        sensor: Sensor,
        /// The axis, from 0.
        axis: usize,
        /// The value it stands at.
        value: f64,
    },
}

impl Corpus {
    /// Checks every member and sorts them by name.
    ///
    /// # Errors
    /// A member shorter than a window, of another rate, or with an axis that never changes.
    pub fn new(name: impl Into<String>, mut members: Vec<Member>) -> Result<Self, CorpusError> {
        members.sort_by(|a, b| a.name.cmp(&b.name));
        for member in &members {
            check(member)?;
        }
        Ok(Self { name: name.into(), members })
    }

    /// Names and recordings of one side.
    pub fn side(&self, side: Side) -> Vec<(&str, &ImuRecording)> {
        self.members.iter().filter(|m| m.side == side).map(|m| (m.name.as_str(), &m.recording)).collect()
    }

    /// As [`side`](Self::side), refusing none.
    ///
    /// # Errors
    /// No member on that side.
    pub fn require(&self, side: Side) -> Result<Vec<(&str, &ImuRecording)>, CorpusError> {
        let members = self.side(side);
        if members.is_empty() {
            let names = self.members.iter().map(|m| m.name.clone()).collect();
            return Err(CorpusError::EmptySide { corpus: self.name.clone(), side, names });
        }
        Ok(members)
    }

    /// SHA-256 over names, sides, stamps and values: two runs with the same fingerprint saw the same input.
    pub fn fingerprint(&self) -> String {
        let mut hash = Sha256::new();
        for member in &self.members {
            hash.update(member.name.as_bytes());
            hash.update([0, u8::from(member.side == Side::Test)]);
            for sample in member.recording.samples() {
                hash.update(sample.t.ns().to_le_bytes());
                for value in sample.gyro.iter().chain(&sample.accel) {
                    hash.update(value.to_le_bytes());
                }
            }
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn check(member: &Member) -> Result<(), CorpusError> {
    let (name, recording) = (&member.name, &member.recording);
    if recording.len() < WINDOW {
        return Err(CorpusError::TooShort { name: name.clone(), samples: recording.len() });
    }
    let hz = recording.rate().hz();
    if (hz / RATE_HZ - 1.0).abs() > RATE_TOLERANCE {
        return Err(CorpusError::Rate { name: name.clone(), hz });
    }
    for sensor in Sensor::ALL {
        for axis in 0..3 {
            let value = recording.samples()[0].of(sensor)[axis];
            if recording.samples().iter().all(|s| s.of(sensor)[axis] == value) {
                return Err(CorpusError::ConstantAxis { name: name.clone(), sensor, axis, value });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuSample, Stamp};

    fn member(samples: usize, step_ns: i64, frozen: bool) -> Member {
        let samples = (0..samples as i64)
            .map(|i| {
                let v = (i % 7) as f64 * 0.01;
                ImuSample {
                    t: Stamp::from_ns(i * step_ns),
                    gyro: [v, v, if frozen { 0.5 } else { v }],
                    accel: [v, v, 9.8 + v],
                }
            })
            .collect();
        Member { name: "m".into(), recording: ImuRecording::new(samples).unwrap(), side: Side::Train }
    }

    #[test]
    fn broken_members_are_named() {
        assert_eq!(
            Corpus::new("c", vec![member(199, 5_000_000, false)]).unwrap_err(),
            CorpusError::TooShort { name: "m".into(), samples: 199 }
        );
        assert!(matches!(Corpus::new("c", vec![member(400, 10_000_000, false)]), Err(CorpusError::Rate { .. })));
        assert!(matches!(
            Corpus::new("c", vec![member(400, 5_000_000, true)]),
            Err(CorpusError::ConstantAxis { sensor: Sensor::Gyro, axis: 2, .. })
        ));
        let fine = Corpus::new("c", vec![member(400, 5_015_000, false)]).unwrap();
        assert!(fine.require(Side::Train).is_ok());
        assert!(matches!(fine.require(Side::Test), Err(CorpusError::EmptySide { side: Side::Test, .. })));
    }

    #[test]
    fn one_bit_changes_the_fingerprint() {
        let a = Corpus::new("c", vec![member(400, 5_000_000, false)]).unwrap();
        let mut other = member(400, 5_000_000, false);
        other.side = Side::Test;
        let b = Corpus::new("c", vec![other]).unwrap();
        assert_eq!(a.fingerprint(), a.clone().fingerprint());
        assert_ne!(a.fingerprint(), b.fingerprint());
    }
}
