//! Quantiles of a track, per axis and phase.

use super::Track;
use super::track::Answer;
use crate::phases::{Phase, Stretch};
use dpn_core::signal::ranks::{Column, Level, levels};
use dpn_core::{ImuSample, Recorded, Sensor, Stamp};
use dpn_noise::Judged;
use serde::Serialize;
use std::io;

/// Levels of a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantiles {
    /// A twentieth lies below.
    pub low: f64,
    /// The median.
    pub middle: f64,
    /// A twentieth lies above.
    pub high: f64,
}

/// One axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisSummary {
    /// The sensor.
    pub sensor: Sensor,
    /// `x`, `y` or `z`.
    pub axis: &'static str,
    /// Of the deviation of one sample, in the sensor's unit.
    pub sigma: Quantiles,
}

/// Windows of a sensor that are unlike those of its network's training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SensorOutside {
    /// The sensor.
    pub sensor: Sensor,
    /// Windows judged, an axis each.
    pub windows: u64,
    /// Share of them that are outside; 0 where none was judged.
    pub share: f64,
}

/// One phase, or the whole log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseSummary {
    /// Which; none for the whole log.
    pub phase: Option<Phase>,
    /// How long it lasts \[s\].
    pub seconds: f64,
    /// Accelerometer x, y, z, gyroscope x, y, z; none where no answer falls into the phase.
    pub axes: Vec<AxisSummary>,
    /// Accelerometer and gyroscope; none where nothing is judged.
    pub outside: Vec<SensorOutside>,
}

/// A stretch of time in which windows of a sensor are unlike those of its network's training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OutsideSpan {
    /// The sensor.
    pub sensor: Sensor,
    /// From the log's begin \[s\].
    pub from_s: f64,
    /// To \[s\].
    pub to_s: f64,
}

/// Seconds between two windows outside that are one span.
const TOGETHER_S: f64 = 1.0;

/// A track by phase.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackSummary {
    /// The whole log, then its phases in the order of [`Phase::ALL`], without those that it does not have.
    pub phases: Vec<PhaseSummary>,
    /// When is which.
    pub stretches: Vec<Stretch>,
    /// Where windows are outside, sensor by sensor.
    pub outside: Vec<OutsideSpan>,
    /// Seconds at the log's begin in which the estimator had no full window and said a constant.
    pub unknown_s: f64,
    /// The sensor that the log does not have: nothing is said of its zeros.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub silent: Option<Sensor>,
}

/// The sensor whose values are zeros throughout, as the other's are of a log with one alone.
pub(super) fn silent(recording: &dyn Recorded) -> io::Result<Option<Sensor>> {
    let mut is_silent = Sensor::ALL.map(|_| true);
    // Nearly every log tells by its first samples.
    for count in [recording.len().min(8), recording.len()] {
        if is_silent.contains(&true) {
            recording.each(0..count, &mut |s: &ImuSample| {
                let all = is_silent.iter_mut().zip(Sensor::ALL);
                all.for_each(|(is, sensor)| *is &= s.of(sensor) == [0.0; 3]);
            })?;
        }
    }
    Ok(match is_silent {
        [true, false] => Some(Sensor::Accel),
        [false, true] => Some(Sensor::Gyro),
        _ => None,
    })
}

impl TrackSummary {
    /// Sums up. An answer counts for a phase when the `unknown_s` seconds behind it, the estimator's window, lie in that phase; the log's
    /// first ones, in which there was no estimate yet, count for nothing.
    ///
    /// # Errors
    /// A temporary file that cannot be read.
    pub fn of(
        track: &Track,
        recording: &dyn Recorded,
        stretches: Vec<Stretch>,
        unknown_s: f64,
    ) -> io::Result<Self> {
        let start = recording.span()[0];
        let known = |a: &Answer| a.t.seconds_since(start) >= unknown_s;
        let mut phases = vec![part(None, recording.length_s(), track, &known)?];
        for phase in Phase::ALL {
            let of: Vec<&Stretch> = stretches.iter().filter(|s| s.phase == phase).collect();
            if of.is_empty() {
                continue;
            }
            let seconds = of.iter().map(|s| s.length_s()).sum();
            let inside = |a: &Answer| {
                let t = a.t.seconds_since(start);
                let at = stretches.partition_point(|s| s.to_s <= t);
                // The window behind the answer must lie in the phase too.
                let all_in = |s: &Stretch| s.phase == phase && t - s.from_s >= unknown_s;
                stretches.get(at).or(stretches.last()).is_some_and(all_in)
            };
            phases.push(part(Some(phase), seconds, track, &|a| known(a) && inside(a))?);
        }
        let silent = silent(recording)?;
        let mut spans = Vec::new();
        for sensor in Sensor::ALL.into_iter().filter(|sensor| Some(*sensor) != silent) {
            spans.extend(outside(track, start, sensor)?);
        }
        Ok(Self { phases, stretches, outside: spans, unknown_s, silent })
    }

    /// The sensors that the log has.
    pub fn sensors(&self) -> impl Iterator<Item = Sensor> + use<> {
        let silent = self.silent;
        Sensor::ALL.into_iter().filter(move |sensor| Some(*sensor) != silent)
    }

    /// One phase.
    pub fn phase(&self, phase: Phase) -> Option<&PhaseSummary> {
        self.phases.iter().find(|p| p.phase == Some(phase) && !p.axes.is_empty())
    }
}

impl PhaseSummary {
    /// The axes of a sensor.
    pub fn of(&self, sensor: Sensor) -> impl Iterator<Item = &AxisSummary> {
        self.axes.iter().filter(move |a| a.sensor == sensor)
    }
}

/// Where one sensor's windows are outside.
fn outside(track: &Track, start: Stamp, sensor: Sensor) -> io::Result<Vec<OutsideSpan>> {
    let mut spans: Vec<OutsideSpan> = Vec::new();
    let mut before_s = 0.0;
    track.each(|answer| {
        let to_s = answer.t.seconds_since(start);
        if answer.judged.of(sensor).outside > 0 {
            match spans.last_mut() {
                Some(last) if before_s <= last.to_s + TOGETHER_S => last.to_s = to_s,
                _ => spans.push(OutsideSpan { sensor, from_s: before_s, to_s }),
            }
        }
        before_s = to_s;
        Ok(())
    })?;
    Ok(spans)
}

/// Of the answers that count.
fn part(
    phase: Option<Phase>,
    seconds: f64,
    track: &Track,
    counts: &dyn Fn(&Answer) -> bool,
) -> io::Result<PhaseSummary> {
    let each = |take: &mut dyn FnMut(&Answer)| {
        track.each(|answer| {
            if counts(answer) {
                take(answer);
            }
            Ok(())
        })
    };
    let (mut count, mut judged) = (0, Judged::default());
    each(&mut |answer| (count, judged) = (count + 1, judged.plus(&answer.judged)))?;
    let asked = [0.05, 0.5, 0.95].map(Level::Quantile);
    let found = levels(&[Column { count, levels: &asked }; 6], |take| {
        each(&mut |answer| {
            let all = Sensor::ALL.into_iter().flat_map(|sensor| answer.noise.of(sensor));
            all.enumerate().for_each(|(column, sigma)| take(column, sigma));
        })
    })?;
    let mut axes = Vec::new();
    let mut outside = Vec::new();
    for (sensor, found) in Sensor::ALL.into_iter().zip(found.chunks(3)) {
        let windows = judged.of(sensor).windows;
        if windows > 0 {
            let share = judged.of(sensor).outside as f64 / windows as f64;
            outside.push(SensorOutside { sensor, windows, share });
        }
        if count > 0 {
            axes.extend(["x", "y", "z"].into_iter().zip(found).map(|(axis, levels)| AxisSummary {
                sensor,
                axis,
                sigma: Quantiles { low: levels[0], middle: levels[1], high: levels[2] },
            }));
        }
    }
    Ok(PhaseSummary { phase, seconds, axes, outside })
}
