//! Whether a log is at rest, second by second.
//!
//! A second has moved when an axis
//! * scatters three times as much as in the middle second of the log, or has leapt, against the last second at rest, by ten times the usual
//!   leap, and not yet stayed there for ten seconds;
//! * scatters more, or is further from the log's middle, than any vehicle standing still: vibration of .5 m/s^2 or .1 rad/s, a tilt of
//!   .5 m/s^2, a turn of .05 rad/s.
//!
//! Slow drift of a bias does none of that.

use dpn_core::signal::stats::upper_median;
use dpn_core::{Recorded, Sensor};
use serde::Serialize;
use std::io;
use std::ops::Range;

/// Seconds at another level after which that is where the log rests.
const SETTLED: u32 = 10;

/// A stretch of a log.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Span {
    /// From the log's begin \[s\].
    pub from_s: f64,
    /// To \[s\].
    pub to_s: f64,
}

/// When a log moved, and its longest part that did not.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Rest {
    /// Where it moved, oldest first; neighbouring seconds are one span.
    pub moved: Vec<Span>,
    /// Seconds that moved.
    pub moved_s: f64,
    /// Holes of the log, which end a stretch at rest too.
    pub gaps: usize,
    /// Samples of the longest stretch at rest and without a hole.
    #[serde(skip)]
    pub longest: Range<usize>,
    /// That stretch.
    pub longest_span: Span,
}

/// Mean and standard deviation of one axis over a second.
#[derive(Debug, Clone, Copy)]
struct Second {
    mean: f64,
    std: f64,
}

/// Looks at every second of a log.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub fn rest(recording: &dyn Recorded) -> io::Result<Rest> {
    let rate = recording.rate();
    let block = (rate.hz().round() as usize).max(2);
    let blocks = (recording.len() / block).max(1);
    let mut moved = vec![false; blocks];
    let mut axes: [[Vec<Second>; 3]; 2] = Default::default();
    // What is left over behind the last whole second is none.
    recording.pieces(0..(blocks * block).min(recording.len()), block, &mut |chunk| {
        for (sensor, axes) in Sensor::ALL.into_iter().zip(&mut axes) {
            for (axis, seconds) in axes.iter_mut().enumerate() {
                seconds.push(second(chunk.iter().map(|s| s.of(sensor)[axis])));
            }
        }
        Ok(())
    })?;
    for (sensor, axes) in Sensor::ALL.into_iter().zip(&axes) {
        // Scatter, distance from the middle: beyond these nothing stands still.
        let (shaking, away) = match sensor {
            Sensor::Accel => (0.5, 0.5),
            Sensor::Gyro => (0.1, 0.05),
        };
        for seconds in axes {
            let of = |part: fn(&Second) -> f64| {
                upper_median(seconds.iter().map(part)).expect("there is a second or more")
            };
            let (usual, middle) = (of(|s| s.std), of(|s| s.mean));
            // One second alone leaps nowhere.
            let leap = upper_median(seconds.windows(2).map(|w| (w[1].mean - w[0].mean).abs())).unwrap_or(0.0);
            // A coarse converter can show the same count for seconds; then one count's scatter is usual.
            let least = seconds.iter().map(|s| s.std).filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
            let usual = if usual > 0.0 || !least.is_finite() { usual } else { least };
            let far = (10.0 * 1.48 * leap).max(usual);
            // The last second at rest, and for how many the axis has been away from it.
            let (mut before, mut away_for) = (seconds[0].mean, 0);
            for (i, second) in seconds.iter().enumerate() {
                let shakes = (usual > 0.0 && second.std > 3.0 * usual)
                    || second.std > shaking
                    || (second.mean - middle).abs() > away;
                let leapt = (second.mean - before).abs() > far && away_for < SETTLED;
                if shakes || leapt {
                    away_for += u32::from(leapt);
                } else {
                    (before, away_for) = (second.mean, 0);
                }
                moved[i] |= shakes || leapt;
            }
        }
    }
    assemble(recording, &moved, block)
}

/// Spans that moved, and the longest between them and the gaps.
fn assemble(recording: &dyn Recorded, moved: &[bool], block: usize) -> io::Result<Rest> {
    let (start, len) = (recording.span()[0], recording.len());
    let seconds = |index: usize| Ok::<_, io::Error>(recording.at(index.min(len - 1))?.t.seconds_since(start));
    let mut spans: Vec<Span> = Vec::new();
    let (mut longest, mut begin, mut gaps) = (0..0, 0, 0);
    let mut close = |begin: usize, end: usize| {
        if end > begin && end - begin > longest.len() {
            longest = begin..end;
        }
    };
    let limit = 1.5 * recording.rate().period();
    let is_moved = |at: usize| moved[(at / block).min(moved.len() - 1)];
    let (mut before, mut at) = (start, 0);
    // Places where a second that moved begins or ends, in pairs.
    let mut bounds: Vec<usize> = Vec::new();
    recording.each(0..len, &mut |sample| {
        match (at > 0 && is_moved(at - 1), is_moved(at)) {
            (false, true) => {
                close(begin, at);
                bounds.push(at);
            }
            (true, false) => {
                begin = at;
                bounds.push(at);
            }
            _ => {}
        }
        if at > 0 && !is_moved(at) && sample.t.seconds_since(before) > limit {
            gaps += 1;
            close(begin, at);
            begin = at;
        }
        (before, at) = (sample.t, at + 1);
    })?;
    if bounds.len() % 2 == 1 {
        begin = len;
        bounds.push(len);
    }
    close(begin, len);
    for pair in bounds.chunks_exact(2) {
        spans.push(Span { from_s: seconds(pair[0])?, to_s: seconds(pair[1])? });
    }
    let longest_span = Span { from_s: seconds(longest.start)?, to_s: seconds(longest.end)? };
    let moved_s = spans.iter().map(|s| s.to_s - s.from_s).sum();
    Ok(Rest { moved_s, moved: spans, gaps, longest, longest_span })
}

fn second(values: impl Iterator<Item = f64> + Clone) -> Second {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let std = (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    Second { mean, std }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::simulate::at_rest;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, SampleRate, Stamp};

    /// A minute at 100 Hz of white noise and a walking bias.
    fn still(seconds: usize) -> Vec<ImuSample> {
        let mut rng = Stream::new(4).named("rest").rng();
        let rate = SampleRate::from_hz(100.0).unwrap();
        let mut axis = |scale: f64| {
            at_rest(&[0.0, scale * scale, 0.0, 1e-3 * scale * scale, 0.0], seconds * 100, rate, &mut rng)
        };
        let axes: Vec<Vec<f64>> = [1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3].map(&mut axis).to_vec();
        (0..seconds * 100)
            .map(|i| ImuSample {
                t: Stamp::from_ns(i as i64 * 10_000_000),
                gyro: [axes[0][i], axes[1][i], axes[2][i]],
                accel: [axes[3][i], axes[4][i], axes[5][i] + 9.81],
            })
            .collect()
    }

    fn of(samples: Vec<ImuSample>) -> Rest {
        rest(&ImuRecording::new(samples).unwrap()).unwrap()
    }

    #[test]
    fn a_still_log_with_a_walking_bias_is_at_rest() {
        let rest = of(still(300));
        assert_eq!(rest.moved, []);
        assert_eq!((rest.longest, rest.gaps), (0..30_000, 0));
    }

    #[test]
    fn a_knock_a_turn_and_a_tilt_are_named_with_their_seconds() {
        let mut samples = still(120);
        for s in &mut samples[2050..2060] {
            s.accel[0] += 1.0;
        }
        for s in &mut samples[5000..5400] {
            s.gyro[2] += 0.02;
        }
        // Put down again a little askew.
        for s in &mut samples[5400..] {
            s.accel[1] += 0.1;
        }
        let rest = of(samples);
        let spans: Vec<(i32, i32)> =
            rest.moved.iter().map(|s| (s.from_s.round() as i32, s.to_s.round() as i32)).collect();
        // Four seconds of turning, then ten until the new attitude counts as rest.
        assert_eq!(spans, [(20, 21), (50, 64)]);
        assert_eq!(rest.longest, 6400..12_000);
    }

    #[test]
    fn a_hole_ends_a_stretch() {
        let mut samples = still(60);
        samples.drain(2000..2010);
        let rest = of(samples);
        assert_eq!((rest.gaps, rest.longest), (1, 2000..5990));
        assert_eq!(rest.moved, []);
    }
}
