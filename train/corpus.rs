//! The recordings a run learns from and is judged on.

use crate::rate::{RateError, at_rate};
use crate::split::Side;
use crate::windows::WINDOW;
use dpn_core::check::{CheckOptions, RecordingFault, check};
use dpn_core::checksum::hex;
use dpn_core::{ImuRecording, SampleRate};
use dpn_pronet::DualProNet;
use sha2::{Digest, Sha256};
use thiserror::Error;

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

/// Recordings of one kind, at one rate.
#[derive(Debug, Clone)]
pub struct Corpus {
    /// Name of the collection, for example `euroc` or `simulated`.
    pub name: String,
    /// The rate that they have, to 5 %.
    pub rate: SampleRate,
    /// Its members, sorted by name.
    pub members: Vec<Member>,
}

/// Why recordings cannot be learned from.
#[derive(Debug, Error, PartialEq)]
pub enum CorpusError {
    /// A side has no recording.
    #[error(
        "{corpus}: no {side} sequence among {names:?}; training needs sequences on both sides of the split"
    )]
    EmptySide {
        /// The collection.
        corpus: String,
        /// The side.
        side: Side,
        /// Sequences there are.
        names: Vec<String>,
    },
    /// A recording that cannot be brought to the rate.
    #[error("{name}: {source}")]
    Rate {
        /// The sequence.
        name: String,
        /// Why.
        source: RateError,
    },
    /// A recording that windows cannot be cut from, or that holds a broken axis.
    #[error("{name}: {fault}")]
    Recording {
        /// The sequence.
        name: String,
        /// What is wrong.
        fault: RecordingFault,
    },
}

impl CorpusError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::EmptySide { .. } => None,
            Self::Rate { source: RateError::Slower { found_hz, .. }, .. } => Some(format!(
                "train networks of its rate (dpn train --rate {found_hz:.0}), or leave the sequence out"
            )),
            Self::Rate { .. } => Some("record longer, or leave the sequence out".into()),
            Self::Recording { fault, .. } => {
                fault.hint().map(|hint| format!("{hint}; or leave the sequence out"))
            }
        }
    }
}

/// The collection that is trained on: the first with sequences to train on, else the first.
pub fn to_train(mut corpora: Vec<Corpus>) -> Option<Corpus> {
    let place = corpora.iter().position(|corpus| !corpus.side(Side::Train).is_empty()).unwrap_or(0);
    (place < corpora.len()).then(|| corpora.swap_remove(place))
}

impl Corpus {
    /// At the paper's rate: checks every member and sorts them by name.
    ///
    /// # Errors
    /// A member shorter than a window, of another rate, or with an axis that is saturated or never changes.
    pub fn new(name: impl Into<String>, members: Vec<Member>) -> Result<Self, CorpusError> {
        Self::of(name.into(), members, SampleRate::HZ_200)
    }

    /// Brings every member to `rate` ([`at_rate`]) and goes on as [`new`](Self::new).
    ///
    /// # Errors
    /// As [`new`](Self::new), but for members that are faster.
    pub fn brought_to(
        rate: SampleRate,
        name: impl Into<String>,
        members: Vec<Member>,
    ) -> Result<Self, CorpusError> {
        let brought = members.into_iter().map(|member| {
            let Member { name, recording, side } = member;
            match at_rate(recording, rate) {
                Ok(recording) => Ok(Member { name, recording, side }),
                Err(source) => Err(CorpusError::Rate { name, source }),
            }
        });
        Self::of(name.into(), brought.collect::<Result<_, _>>()?, rate)
    }

    fn of(name: String, mut members: Vec<Member>, rate: SampleRate) -> Result<Self, CorpusError> {
        members.sort_by(|a, b| a.name.cmp(&b.name));
        for member in &members {
            refuse(member, rate)?;
        }
        Ok(Self { name, rate, members })
    }

    /// Names and recordings of one side.
    pub fn side(&self, side: Side) -> Vec<(&str, &ImuRecording)> {
        self.members.iter().filter(|m| m.side == side).map(|m| (m.name.as_str(), &m.recording)).collect()
    }

    /// As [`side`](Self::side), refusing none.
    ///
    /// # Errors
    /// No member on that side.
    pub(crate) fn require(&self, side: Side) -> Result<Vec<(&str, &ImuRecording)>, CorpusError> {
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
        hex(hash.finalize())
    }
}

/// Refuses what windows cannot be cut from. Gaps are no fault: no window crosses one.
fn refuse(member: &Member, rate: SampleRate) -> Result<(), CorpusError> {
    let options = CheckOptions {
        expected_rate: Some(rate),
        rate_tolerance: DualProNet::RATE_TOLERANCE,
        min_samples: (WINDOW as f64 * rate.hz() / SampleRate::HZ_200.hz()).round() as usize,
        ..CheckOptions::default()
    };
    let faults = check(&member.recording, &options).faults;
    match faults.into_iter().find(|fault| !matches!(fault, RecordingFault::Gaps { .. })) {
        Some(fault) => Err(CorpusError::Recording { name: member.name.clone(), fault }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuSample, Sensor, Stamp};

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
        let fault = |m: Member| match Corpus::new("c", vec![m]).unwrap_err() {
            CorpusError::Recording { fault, .. } => fault,
            other => panic!("{other}"),
        };
        assert!(matches!(
            fault(member(199, 5_000_000, false)),
            RecordingFault::TooShort { found: 199, needed: 200 }
        ));
        assert!(matches!(fault(member(400, 10_000_000, false)), RecordingFault::WrongRate { .. }));
        assert!(matches!(
            fault(member(400, 5_000_000, true)),
            RecordingFault::Constant { sensor: Sensor::Gyro, axis: 2, .. }
        ));
        let fine = Corpus::new("c", vec![member(400, 5_015_000, false)]).unwrap();
        assert!(fine.require(Side::Train).is_ok());
        assert!(matches!(fine.require(Side::Test), Err(CorpusError::EmptySide { side: Side::Test, .. })));
    }

    #[test]
    fn members_are_brought_to_the_rate_and_a_slower_one_is_told_what_it_can_do() {
        let to = |hz: f64| SampleRate::from_hz(hz).unwrap();
        let corpus = Corpus::brought_to(to(100.0), "c", vec![member(800, 5_000_000, false)]).unwrap();
        assert!((corpus.members[0].recording.rate().hz() - 100.0).abs() < 0.01);
        let slower = Corpus::brought_to(to(200.0), "c", vec![member(800, 10_000_000, false)]).unwrap_err();
        assert!(slower.hint().unwrap().contains("dpn train --rate 100"), "{slower}");
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
