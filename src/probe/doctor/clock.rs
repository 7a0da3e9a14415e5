//! Clocks that were set while a log was written, and rates that no IMU has.

use super::kept::Kept;
use crate::finding::Finding;
use dpn_core::{Recorded, SampleRate, Samples, Stamp};
use std::io;
use std::ops::Range;

/// A step between samples that is a jump of the clock: longer than this \[s\],
const JUMP_S: f64 = 3600.0;
/// and so many times as long as all that is recorded.
const JUMP_TIMES: f64 = 10.0;
/// Rates at which IMUs are read, a little wider \[Hz\].
const RATES: [f64; 2] = [9.0, 9000.0];
/// Beyond there is none at all \[Hz\].
const FASTEST: f64 = 4e4;

/// The longest part of a recording whose clock was left alone, none where that is all of it, and what is to be said of the jumps.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn without_jumps(recording: &dyn Recorded) -> io::Result<(Option<Kept<'_>>, Option<Finding>)> {
    let (mut long_s, mut longest_s) = (0.0, 0.0_f64);
    recording.pairs(&mut |a, b| {
        let step = b.t.seconds_since(a.t);
        if step > JUMP_S {
            (long_s, longest_s) = (long_s + step, longest_s.max(step));
        }
    })?;
    let recorded = recording.length_s() - long_s;
    if longest_s <= JUMP_TIMES * recorded {
        return Ok((None, None));
    }
    let (mut jumps, mut first): (usize, Option<(usize, f64, [Stamp; 2])>) = (0, None);
    let (mut index, mut begin, mut longest): (usize, usize, Range<usize>) = (0, 0, 0..0);
    // Of several as long the last.
    let part = |longest: &mut Range<usize>, part: Range<usize>| {
        if part.len() >= longest.len() {
            *longest = part;
        }
    };
    recording.pairs(&mut |a, b| {
        index += 1;
        let step = b.t.seconds_since(a.t);
        if step > JUMP_S && step > JUMP_TIMES * recorded {
            jumps += 1;
            first.get_or_insert((index, step, [a.t, b.t]));
            part(&mut longest, begin..index);
            begin = index;
        }
    })?;
    part(&mut longest, begin..recording.len());
    let (index, step, [from, to]) = first.expect("the longest step is a jump");
    let part = Kept::new(recording, longest, Vec::new())?;
    let looked_at = match &part {
        Some(part) => format!("looked at are the {} samples from {} on", part.len(), part.span()[0]),
        None => "no part of the log has two samples".to_owned(),
    };
    let text = format!(
        "the stamps jump {jumps} time(s), first by {} after sample {index}, from {from} to {to}; {looked_at}",
        span(step),
    );
    let finding = Finding::bad(
        "clock",
        text,
        "cut the log there; look for a clock that was set while it was written, or for two logs in one file",
    );
    Ok((part, Some(finding)))
}

/// What is to be said of a rate that IMUs do not have.
pub(super) fn unlikely(rate: SampleRate) -> Option<Finding> {
    let hz = rate.hz();
    let remedy = "look at the unit of the stamps: --time-unit s, ms, us or ns; or at their column: --columns";
    let likely = |hz: f64| (RATES[0]..=RATES[1]).contains(&hz);
    let factors = [1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9].into_iter();
    let other =
        factors.map(|factor| (factor, hz * factor)).find(|(_, hz)| likely(*hz)).map(|(factor, hz)| {
            let (times, words) = if factor < 1.0 { (1.0 / factor, "larger") } else { (factor, "smaller") };
            format!("; in a unit {times} times {words} it would be {hz:.1} Hz")
        });
    let other = other.unwrap_or_default();
    if hz > FASTEST {
        return Some(Finding::bad(
            "rate",
            format!("{hz:.0} Hz: no IMU is as fast; the stamps count in another unit{other}"),
            remedy,
        ));
    }
    let words = if hz > RATES[1] { "faster" } else { "slower" };
    (!likely(hz)).then(|| {
        let text = format!("{hz:.3} Hz is {words} than IMUs are read (10 to 8000 Hz){other}");
        Finding::warning("rate", text, remedy)
    })
}

/// `2.5 h`, `3.1 days`, `44.5 years`.
fn span(seconds: f64) -> String {
    match seconds {
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s if s < 31_557_600.0 => format!("{:.1} days", s / 86_400.0),
        s => format!("{:.1} years", s / 31_557_600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::examine;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, Stamp};

    #[test]
    fn a_first_stamp_of_nothing_before_real_ones_is_a_jump_and_the_rest_is_looked_at() {
        let mut samples = level(30);
        for s in &mut samples[1..] {
            s.t = Stamp::from_ns(1_403_715_285_000_000_000 + s.t.ns());
        }
        samples[0].t = Stamp::from_ns(976);
        let found = examine(&ImuRecording::new(samples).unwrap()).unwrap();
        assert_eq!((found.samples, found.length_s.round()), (5999, 30.0));
        assert_eq!(
            found.findings[0].text,
            "the stamps jump 1 time(s), first by 44.5 years after sample 1, from 976 ns to 1403715285005000000 ns; \
             looked at are the 5999 samples from 1403715285005000000 ns on"
        );
        assert!(found.findings.iter().all(|f| f.about != "jitter" && f.about != "gaps"), "{found:?}");
        assert!(!found.spectra.is_empty());
    }

    #[test]
    fn a_pause_of_hours_in_a_log_of_hours_is_no_jump_and_a_log_of_two_far_stamps_is_one() {
        let at = |seconds: &[i64]| {
            let sample = level(1)[0];
            let all = seconds
                .iter()
                .map(|s| dpn_core::ImuSample { t: Stamp::from_ns(s * 1_000_000_000), ..sample });
            ImuRecording::new(all.collect()).unwrap()
        };
        assert!(without_jumps(&at(&[0, 3000, 6000, 16_000])).unwrap().1.is_none());
        let two = at(&[0, 1_000_000]);
        let (part, said) = without_jumps(&two).unwrap();
        assert!(part.is_none() && said.unwrap().text.ends_with("no part of the log has two samples"));
    }

    #[test]
    fn rates_that_a_wrong_unit_makes_are_named() {
        let of = |hz: f64| unlikely(SampleRate::from_hz(hz).unwrap()).map(|f| f.text);
        for hz in [10.0, 200.0, 8000.0] {
            assert_eq!(of(hz), None);
        }
        assert_eq!(
            of(10_000.0).unwrap(),
            "10000.000 Hz is faster than IMUs are read (10 to 8000 Hz); in a unit 1000 times larger it would be 10.0 Hz"
        );
        assert_eq!(
            of(0.2).unwrap(),
            "0.200 Hz is slower than IMUs are read (10 to 8000 Hz); in a unit 1000 times smaller it would be 200.0 Hz"
        );
        assert_eq!(
            of(1e9).unwrap(),
            "1000000000 Hz: no IMU is as fast; the stamps count in another unit; in a unit 1000000 times larger it would be 1000.0 Hz"
        );
    }
}
