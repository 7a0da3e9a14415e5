//! Samples that are looked at a piece at a time, wherever they lie: a log of hours need not be in memory for its medians.
//!
//! What goes through them several times asks for [`pieces`](Samples::pieces); an [`ImuRecording`] lends its own, a file reads them anew.

use crate::imu::{ImuRecording, ImuSample, Sensor};
use crate::signal::ranks::{Column, Level, levels};
use crate::time::{SampleRate, Stamp};
use std::borrow::Cow;
use std::io;
use std::ops::Range;

/// Samples of a piece that is read at a time, about: 230 kB.
const PIECE: usize = 4096;

/// Samples in increasing time, finite, that can be gone through as often as is asked.
pub trait Samples: Sync {
    /// Number of samples.
    fn len(&self) -> usize;

    /// Those of `range`.
    ///
    /// # Errors
    /// A file that cannot be read.
    ///
    /// # Panics
    /// When `range` ends behind the last.
    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>>;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All of them: where memory is no matter.
    ///
    /// # Errors
    /// As [`piece`](Self::piece).
    fn all(&self) -> io::Result<Cow<'_, [ImuSample]>> {
        self.piece(0..self.len())
    }

    /// One sample.
    ///
    /// # Errors
    /// As [`piece`](Self::piece).
    fn at(&self, index: usize) -> io::Result<ImuSample> {
        Ok(self.piece(index..index + 1)?[0])
    }

    /// Hands `range` to `take`, `size` samples at a time and fewer at the end.
    ///
    /// # Errors
    /// As [`piece`](Self::piece), and `take`'s own.
    fn pieces(
        &self,
        range: Range<usize>,
        size: usize,
        take: &mut dyn FnMut(&[ImuSample]) -> io::Result<()>,
    ) -> io::Result<()> {
        let size = size.max(1);
        let many = size * (PIECE / size).max(1);
        for from in range.clone().step_by(many) {
            let read = self.piece(from..from.saturating_add(many).min(range.end))?;
            read.chunks(size).try_for_each(&mut *take)?;
        }
        Ok(())
    }

    /// Hands every sample of `range` to `take`.
    ///
    /// # Errors
    /// As [`piece`](Self::piece).
    fn each(&self, range: Range<usize>, take: &mut dyn FnMut(&ImuSample)) -> io::Result<()> {
        self.pieces(range, PIECE, &mut |piece| {
            piece.iter().for_each(&mut *take);
            Ok(())
        })
    }

    /// Hands every sample but the first to `take`, behind the one before it.
    ///
    /// # Errors
    /// As [`piece`](Self::piece).
    fn pairs(&self, take: &mut dyn FnMut(&ImuSample, &ImuSample)) -> io::Result<()> {
        let mut before: Option<ImuSample> = None;
        self.each(0..self.len(), &mut |sample| {
            if let Some(before) = &before {
                take(before, sample);
            }
            before = Some(*sample);
        })
    }

    /// One axis (0, 1, 2) of a sensor over `range`.
    ///
    /// # Errors
    /// As [`piece`](Self::piece).
    ///
    /// # Panics
    /// When `axis` is above 2.
    fn signal(&self, range: Range<usize>, sensor: Sensor, axis: usize) -> io::Result<Vec<f64>> {
        Ok(self.piece(range)?.iter().map(|s| s.of(sensor)[axis]).collect())
    }
}

/// Samples, at least two, whose rate is known.
pub trait Recorded: Samples {
    /// The median rate.
    fn rate(&self) -> SampleRate;

    /// Stamps of the first and the last sample.
    fn span(&self) -> [Stamp; 2];

    /// From the first to the last stamp \[s\].
    fn length_s(&self) -> f64 {
        let [first, last] = self.span();
        last.seconds_since(first)
    }
}

impl Samples for ImuRecording {
    fn len(&self) -> usize {
        self.samples().len()
    }

    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>> {
        Ok(Cow::Borrowed(&self.samples()[range]))
    }
}

impl Recorded for ImuRecording {
    fn rate(&self) -> SampleRate {
        self.rate()
    }

    fn span(&self) -> [Stamp; 2] {
        [self.samples()[0].t, self.samples()[self.len() - 1].t]
    }
}

impl Samples for &[ImuSample] {
    fn len(&self) -> usize {
        <[ImuSample]>::len(self)
    }

    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>> {
        Ok(Cow::Borrowed(&self[range]))
    }
}

/// The median rate of samples in increasing time, as [`ImuRecording::rate`] has it; none for fewer than two.
///
/// # Errors
/// As [`Samples::piece`].
pub fn median_rate(samples: &dyn Samples) -> io::Result<Option<SampleRate>> {
    let count = samples.len().saturating_sub(1);
    let step = levels(&[Column { count, levels: &[Level::UpperMedian] }], |take| {
        samples.pairs(&mut |a, b| take(0, b.t.ns().saturating_sub(a.t.ns()) as f64))
    })?;
    Ok(SampleRate::from_hz(1e9 / step[0][0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_a_range_once_and_the_rate_is_the_recordings() {
        let at = |i: i64| ImuSample {
            t: Stamp::from_ns(i * 5_000_000 + i % 3),
            gyro: [i as f64; 3],
            accel: [0.0; 3],
        };
        let samples: Vec<ImuSample> = (0..10_000).map(at).collect();
        let recording = ImuRecording::new(samples.clone()).unwrap();
        for (range, size) in [(0..10_000, 1), (17..9999, 200), (5..6, 9000), (3..3, 7), (0..10_000, 5000)] {
            let mut seen = Vec::new();
            let mut sizes = Vec::new();
            recording
                .pieces(range.clone(), size, &mut |piece| {
                    seen.extend_from_slice(piece);
                    sizes.push(piece.len());
                    Ok(())
                })
                .unwrap();
            assert_eq!(seen, samples[range]);
            assert!(sizes.iter().rev().skip(1).all(|n| *n == size));
        }
        assert_eq!(median_rate(&recording).unwrap(), Some(recording.rate()));
        assert_eq!(median_rate(&&samples[..1]).unwrap(), None);
    }
}
