//! Samples of a log of any length.
//!
//! What is read may be larger than the memory and come through a pipe, once; medians, spectra and pictures go through it several times.

use super::store::{Row, Store};
use dpn_core::imu::{ImuRecording, ImuSample};
use dpn_core::time::{SampleRate, Stamp};
use dpn_core::{Recorded, Samples, median_rate};
use std::borrow::Cow;
use std::io;
use std::ops::Range;

/// Stamp, gyroscope, accelerometer.
impl Row for ImuSample {
    const BYTES: usize = 7 * 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.t.ns().to_le_bytes());
        bytes.extend(self.gyro.iter().chain(&self.accel).flat_map(|v| v.to_le_bytes()));
    }

    fn read(words: &[[u8; 8]]) -> Self {
        let [gyro, accel] = [1, 4].map(|at| std::array::from_fn(|axis| f64::from_le_bytes(words[at + axis])));
        Self { t: Stamp::from_ns(i64::from_le_bytes(words[0])), gyro, accel }
    }
}

/// Samples that are added one by one; see [`Store`].
#[derive(Debug, Default)]
pub struct SampleStore {
    rows: Store<ImuSample>,
    last: Option<Stamp>,
}

impl SampleStore {
    /// Adds a sample. A file that cannot be written is told by [`done`](Self::done).
    pub fn push(&mut self, sample: ImuSample) {
        self.last = Some(sample.t);
        self.rows.push(sample);
    }

    /// Stamp of the last sample.
    pub fn last(&self) -> Option<Stamp> {
        self.last
    }

    /// The same, if all could be kept.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn done(self) -> io::Result<Self> {
        Ok(Self { rows: self.rows.done()?, ..self })
    }

    /// What `change` makes of every sample, without those of which it makes none.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub fn changed(self, mut change: impl FnMut(ImuSample) -> Option<ImuSample>) -> io::Result<Self> {
        let mut changed = Self::default();
        let all = self.done()?;
        all.each(0..all.len(), &mut |sample| {
            if let Some(sample) = change(*sample) {
                changed.push(sample);
            }
        })?;
        changed.done()
    }

    /// As a recording; the number of samples where that is below two.
    ///
    /// # Errors
    /// A file that cannot be read.
    ///
    /// # Panics
    /// Where stamps do not increase.
    pub fn recording(self) -> io::Result<Result<StoredRecording, usize>> {
        let store = self.done()?;
        let Some(rate) = median_rate(&store)? else { return Ok(Err(store.len())) };
        let span = [store.at(0)?.t, store.at(store.len() - 1)?.t];
        Ok(Ok(StoredRecording { store, rate, span }))
    }
}

impl Samples for SampleStore {
    fn len(&self) -> usize {
        self.rows.len()
    }

    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>> {
        self.rows.piece(range)
    }
}

/// A recording of any length.
#[derive(Debug)]
pub struct StoredRecording {
    store: SampleStore,
    rate: SampleRate,
    span: [Stamp; 2],
}

impl StoredRecording {
    /// All of it in memory.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn held(self) -> io::Result<ImuRecording> {
        let samples = match self.store.rows.into_held() {
            Ok(samples) => samples,
            Err(rows) => rows.piece(0..rows.len())?.into_owned(),
        };
        Ok(ImuRecording::new(samples).expect("finite samples in increasing time were put in"))
    }

    /// Back to samples.
    pub fn into_store(self) -> SampleStore {
        self.store
    }
}

impl From<ImuRecording> for StoredRecording {
    fn from(recording: ImuRecording) -> Self {
        let (rate, span) = (recording.rate(), recording.span());
        let rows = Store::from(recording.into_samples());
        Self { store: SampleStore { rows, last: Some(span[1]) }, rate, span }
    }
}

impl Samples for StoredRecording {
    fn len(&self) -> usize {
        self.store.len()
    }

    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>> {
        self.store.piece(range)
    }
}

impl Recorded for StoredRecording {
    fn rate(&self) -> SampleRate {
        self.rate
    }

    fn span(&self) -> [Stamp; 2] {
        self.span
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of which some hundred thousand bytes go to the file.
    const HELD: usize = 40_000;

    fn sample(i: i64) -> ImuSample {
        let value = i as f64 * 0.1;
        ImuSample { t: Stamp::from_ns(i * 5_000_000), gyro: [value, -value, 0.0], accel: [1.0, value, 9.81] }
    }

    #[test]
    fn what_goes_to_the_file_comes_back_to_the_bit_whatever_part_is_asked_for() {
        let count = 2 * HELD + 1000;
        let mut store = SampleStore::default();
        (0..count as i64).for_each(|i| store.push(sample(i)));
        let store = store.done().unwrap();
        assert_eq!((store.len(), store.last()), (count, Some(sample(count as i64 - 1).t)));
        assert!(matches!(store.piece(0..1).unwrap(), Cow::Owned(_)), "read from a file");
        for range in
            [0..count, 5..HELD + 3, 2 * HELD - 1..2 * HELD + 1, 2 * HELD + 10..count, 7..7, count..count]
        {
            let expected: Vec<ImuSample> = range.clone().map(|i| sample(i as i64)).collect();
            assert_eq!(&*store.piece(range).unwrap(), &expected[..]);
        }
        let odd = store
            .changed(|s| (s.t.ns() % 10_000_000 != 0).then_some(ImuSample { gyro: [1.0; 3], ..s }))
            .unwrap();
        assert_eq!((odd.len(), odd.at(HELD).unwrap().accel), (count / 2, sample(2 * HELD as i64 + 1).accel));
        let recording = odd.recording().unwrap().unwrap();
        assert_eq!(recording.span(), [sample(1).t, sample(count as i64 - 1).t]);
        let rate = recording.rate();
        let held = recording.held().unwrap();
        assert_eq!((held.len(), held.rate()), (count / 2, rate));
        assert_eq!(SampleStore::default().recording().unwrap().unwrap_err(), 0);
    }
}
