//! Whether a log's rate changes on the way, as where a driver is told another one, or two logs were put together.
//!
//! The median step of every second tells. Samples lost and stamps of arrival leave it as it is; a second whose steps are not even says nothing.

use crate::finding::Finding;
use dpn_core::Recorded;
use dpn_core::signal::stats;
use std::io;

/// A rate that differs by less is the same one.
const SAME: f64 = 1.07;
/// Share of a second's steps that are within a quarter of their median, or it says nothing.
const EVEN: f64 = 0.8;
/// Seconds of one rate that are no accident.
const LASTS_S: f64 = 3.0;
/// Steps that tell a second's rate.
const STEPS: usize = 8;

/// A stretch of one rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Part {
    /// From the log's begin, to \[s\].
    pub(crate) span_s: [f64; 2],
    hz: f64,
}

/// The parts of a log with a rate each, where there is more than one.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(crate) fn parts(recording: &dyn Recorded) -> io::Result<Vec<Part>> {
    let start = recording.span()[0];
    let (mut steps, mut from_s) = (Vec::new(), 0.0);
    let mut parts: Vec<Part> = Vec::new();
    recording.pairs(&mut |a, b| {
        steps.push(b.t.seconds_since(a.t));
        let to_s = b.t.seconds_since(start);
        if to_s - from_s < 1.0 || steps.len() < STEPS {
            return;
        }
        let step = stats::median(&steps);
        let even = steps.iter().filter(|s| (**s / step - 1.0).abs() < 0.25).count();
        if step > 0.0 && even as f64 > EVEN * steps.len() as f64 {
            match parts.last_mut().filter(|part| (1.0 / SAME..SAME).contains(&(part.hz * step))) {
                Some(part) => part.span_s[1] = to_s,
                None => parts.push(Part { span_s: [from_s, to_s], hz: step.recip() }),
            }
        }
        (steps, from_s) = (Vec::new(), to_s);
    })?;
    parts.retain(|part| part.length_s() >= LASTS_S);
    // What a short accident lay between is one.
    parts.dedup_by(|next, part| {
        let same = (1.0 / SAME..SAME).contains(&(next.hz / part.hz));
        part.span_s[1] = if same { next.span_s[1] } else { part.span_s[1] };
        same
    });
    Ok(if parts.len() > 1 { parts } else { Vec::new() })
}

impl Part {
    fn length_s(&self) -> f64 {
        self.span_s[1] - self.span_s[0]
    }
}

/// The longest of parts.
pub(crate) fn longest(parts: &[Part]) -> Option<&Part> {
    parts.iter().max_by(|a, b| a.length_s().total_cmp(&b.length_s()))
}

/// That the rate changes, and what to do.
pub(crate) fn finding(parts: &[Part]) -> Option<Finding> {
    let [first, second, ..] = parts else { return None };
    let [from, to] = longest(parts)?.span_s;
    let more = if parts.len() > 2 { format!(", and {} times more", parts.len() - 2) } else { String::new() };
    let text = format!(
        "the rate changes at {:.1} s from {:.1} to {:.1} Hz{more}: noise per sample changes with it, and what counts samples is wrong in one of them; the longest \
         part is that from {from:.0} to {to:.0} s",
        second.span_s[0], first.hz, second.hz
    );
    Some(Finding::bad("rate", text, "look at each part for itself: --from, --to"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use crate::phases::phases;
    use crate::rest_noise::RestNoise;
    use dpn_core::{ImuRecording, ImuSample, Stamp};

    /// Of 200 Hz, every second sample left out from 20 s on, and a few more.
    fn halved() -> ImuRecording {
        let samples = level(60).into_iter().enumerate();
        let kept = samples.filter(|(i, _)| (*i < 4000 || i % 2 == 0) && i % 701 != 0);
        ImuRecording::new(kept.map(|(_, sample)| sample).collect()).unwrap()
    }

    #[test]
    fn a_change_is_found_and_losses_and_jitter_are_none() {
        let found = parts(&halved()).unwrap();
        assert_eq!(found.len(), 2, "{found:?}");
        let text = finding(&found).unwrap().text;
        assert!(text.contains("at 20.0 s from 200.0 to 100.0 Hz"), "{text}");
        let uneven = |i: usize, s: &ImuSample| ImuSample {
            t: Stamp::from_ns(s.t.ns() + if i.is_multiple_of(3) { 1_500_000 } else { 0 }),
            ..*s
        };
        let lost = level(60)
            .iter()
            .enumerate()
            .filter(|(i, _)| i % 7 != 0 || *i > 4000)
            .map(|(i, s)| uneven(i, s))
            .collect();
        assert_eq!(parts(&ImuRecording::new(lost).unwrap()).unwrap(), []);
    }

    #[test]
    fn a_rest_is_looked_at_where_it_has_one_rate() {
        let log = halved();
        let found = RestNoise::of(&log, &phases(&log).unwrap()).unwrap().unwrap();
        assert!(found.from_s > 18.0 && found.to_s > 58.0, "{found:?}");
        // Half of the samples of the same deviation: the density is larger by the root of two.
        for axis in found.sensors[1].axes.iter().flatten() {
            assert!((axis.density.unwrap().value / (0.0024 / 10.0) - 1.0).abs() < 0.05, "{axis:?}");
        }
    }
}
