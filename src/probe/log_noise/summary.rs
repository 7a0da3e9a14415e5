//! Quantiles of a track, per axis and phase.

use super::Track;
use super::track::{Answer, Judged};
use crate::phases::{Phase, Stretch};
use dpn_core::signal::stats;
use dpn_core::{ImuRecording, Sensor};
use serde::Serialize;

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
}

impl TrackSummary {
    /// Sums up. An answer counts for a phase when the `unknown_s` seconds behind it, the estimator's window, lie in that phase; the log's
    /// first ones, in which there was no estimate yet, count for nothing.
    pub fn of(track: &Track, recording: &ImuRecording, stretches: Vec<Stretch>, unknown_s: f64) -> Self {
        let start = recording.samples()[0].t;
        let known = |a: &&Answer| a.t.seconds_since(start) >= unknown_s;
        let whole = part(None, recording.duration(), track.answers.iter().filter(known));
        let mut phases = vec![whole];
        for phase in Phase::ALL {
            let of: Vec<&Stretch> = stretches.iter().filter(|s| s.phase == phase).collect();
            if of.is_empty() {
                continue;
            }
            let seconds = of.iter().map(|s| s.to_s - s.from_s).sum();
            let inside = |a: &&Answer| {
                let t = a.t.seconds_since(start);
                let at = stretches.partition_point(|s| s.to_s <= t);
                // The window behind the answer must lie in the phase too.
                let all_in = |s: &Stretch| s.phase == phase && t - s.from_s >= unknown_s;
                stretches.get(at).or(stretches.last()).is_some_and(all_in)
            };
            phases.push(part(Some(phase), seconds, track.answers.iter().filter(known).filter(inside)));
        }
        let outside = Sensor::ALL.into_iter().flat_map(|sensor| outside(track, recording, sensor)).collect();
        Self { phases, stretches, outside, unknown_s }
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
fn outside(track: &Track, recording: &ImuRecording, sensor: Sensor) -> Vec<OutsideSpan> {
    let start = recording.samples()[0].t;
    let mut spans: Vec<OutsideSpan> = Vec::new();
    let mut before_s = 0.0;
    for answer in &track.answers {
        let to_s = answer.t.seconds_since(start);
        if answer.judged.of(sensor).outside > 0 {
            match spans.last_mut() {
                Some(last) if before_s <= last.to_s + TOGETHER_S => last.to_s = to_s,
                _ => spans.push(OutsideSpan { sensor, from_s: before_s, to_s }),
            }
        }
        before_s = to_s;
    }
    spans
}

fn part<'a>(phase: Option<Phase>, seconds: f64, answers: impl Iterator<Item = &'a Answer>) -> PhaseSummary {
    let answers: Vec<&Answer> = answers.collect();
    let judged = answers.iter().fold(Judged::default(), |sum, a| sum.plus(&a.judged));
    let mut axes = Vec::new();
    let mut outside = Vec::new();
    for sensor in Sensor::ALL {
        let count = judged.of(sensor);
        if count.windows > 0 {
            let share = count.outside as f64 / count.windows as f64;
            outside.push(SensorOutside { sensor, windows: count.windows, share });
        }
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let values: Vec<f64> = answers.iter().map(|a| a.noise.of(sensor)[axis]).collect();
            if let [low, middle, high] = stats::quantiles(&values, &[0.05, 0.5, 0.95])[..]
                && !values.is_empty()
            {
                axes.push(AxisSummary { sensor, axis: name, sigma: Quantiles { low, middle, high } });
            }
        }
    }
    PhaseSummary { phase, seconds, axes, outside }
}
