//! A part of a recording, seen as a recording: nothing is copied.

use dpn_core::{ImuSample, Recorded, SampleRate, Samples, Stamp, median_rate};
use std::borrow::Cow;
use std::io;
use std::ops::Range;

/// The samples of a range but some.
pub(super) struct Kept<'a> {
    of: &'a dyn Recorded,
    first: usize,
    len: usize,
    /// Places in the range that are left out, ascending.
    out: Vec<usize>,
    rate: SampleRate,
    span: [Stamp; 2],
}

impl<'a> Kept<'a> {
    /// Those of `range` but the places `out` in it, ascending; none where fewer than two are left.
    pub(super) fn new(
        of: &'a dyn Recorded,
        range: Range<usize>,
        out: Vec<usize>,
    ) -> io::Result<Option<Self>> {
        let (rate, span) = (of.rate(), of.span());
        let mut kept = Self { of, first: range.start, len: range.len() - out.len(), out, rate, span };
        let Some(rate) = median_rate(&kept)? else { return Ok(None) };
        (kept.rate, kept.span) = (rate, [kept.at(0)?.t, kept.at(kept.len - 1)?.t]);
        Ok(Some(kept))
    }

    /// Where the sample at `index` stands in the range.
    fn place(&self, index: usize) -> usize {
        let (mut low, mut high) = (0, self.out.len());
        // As many are left out before it as have fewer than `index` + 1 kept ones before them.
        while low < high {
            let middle = (low + high) / 2;
            if self.out[middle] - middle <= index { low = middle + 1 } else { high = middle }
        }
        index + low
    }
}

impl Samples for Kept<'_> {
    fn len(&self) -> usize {
        self.len
    }

    fn piece(&self, range: Range<usize>) -> io::Result<Cow<'_, [ImuSample]>> {
        let Some(last) = range.clone().next_back() else { return Ok(Cow::Borrowed(&[])) };
        let places = self.place(range.start)..self.place(last) + 1;
        let piece = self.of.piece(self.first + places.start..self.first + places.end)?;
        if places.len() == range.len() {
            return Ok(piece);
        }
        let is_kept = |place: &usize| self.out.binary_search(place).is_err();
        Ok(places.zip(piece.iter()).filter(|(place, _)| is_kept(place)).map(|(_, s)| *s).collect())
    }
}

impl Recorded for Kept<'_> {
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
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;

    #[test]
    fn any_piece_of_a_part_is_that_of_the_samples_copied() {
        let samples = level(1);
        let recording = ImuRecording::new(samples.clone()).unwrap();
        for out in [vec![], vec![0, 1, 5, 6, 7, 100, 119], vec![60]] {
            let kept = Kept::new(&recording, 30..150, out.clone()).unwrap().unwrap();
            let copied: Vec<ImuSample> =
                (0..120).filter(|place| !out.contains(place)).map(|place| samples[30 + place]).collect();
            for range in [0..copied.len(), 0..3, 2..6, 57..60, copied.len() - 1..copied.len(), 9..9] {
                assert_eq!(*kept.piece(range.clone()).unwrap(), copied[range]);
            }
            assert_eq!(kept.span(), [copied[0].t, copied[copied.len() - 1].t]);
        }
        assert!(Kept::new(&recording, 30..32, vec![1]).unwrap().is_none());
    }
}
