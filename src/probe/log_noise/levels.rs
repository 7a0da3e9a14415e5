//! How loud a log is at rest and in motion, from the samples alone: what a configuration's white noise is held against.
//!
//! A network says little of a flight that is louder than all it was trained on; the signal does not saturate. Of each axis the residual of a
//! Savitzky-Golay filter of second order over 55 ms (11 samples at 200 Hz) is taken, over its gain for white noise: what is faster than
//! some 10 Hz, so not the motion. Its deviation over a second is that of one sample.
//!
//! * *Floor*: median over the seconds at rest; where a log never rests, its quietest seconds, a twentieth from the lowest, as one carried by
//!   hand has them. Where these are louder than any sensor at rest, and are not ten seconds at rest, there is none: what shakes
//!   hides it.
//! * *In motion*: median and 95 % over the seconds in motion (else of motors on, else of all).
//!
//! Each is that of the loudest axis. Of the walk of a bias a log in motion shows an upper bound: its Allan variance is the walk's and the
//! motion's together, so K^2 tau / 3 stays below it at every tau, on every axis.

use crate::allan::deviation;
use crate::allan::mix_up::typical;
use crate::allan::{AllanLog, LEAST_S};
use crate::phases::{Phase, Stretch, longest_rest, phase_at};
use dpn_core::noise::Figure;
use dpn_core::signal::SavitzkyGolay;
use dpn_core::signal::stats::{self, Ddof};
use dpn_core::{ImuRecording, Recorded, SampleRate, Sensor};
use serde::Serialize;
use std::io;

/// Length of the filter \[s\]; 11 samples at 200 Hz.
const FILTER_S: f64 = 0.055;
/// A twentieth of the seconds lies beyond the envelope, or below the quietest.
const TAIL: f64 = 0.05;
/// Up to this many times the highest figure of a data sheet quiet seconds are those of a sensor that nothing shakes.
const CALM: f64 = 1.5;
/// Averaging times of the walk's bound: up to this share of the log, so that each is a mean over many.
const SHARE: usize = 10;

/// Where a floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorFrom {
    /// Seconds at rest.
    Rest,
    /// The quietest seconds of a log that never rests and that nothing shakes.
    Quietest,
}

/// How loud one sensor is: deviations of one sample of its loudest axis, in its unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SensorLevels {
    /// The sensor's own noise, where the log shows it.
    pub floor: Option<(f64, FloorFrom)>,
    /// Median in motion.
    pub in_motion: f64,
    /// What a twentieth of the seconds in motion exceeds.
    pub envelope: f64,
    /// What the walk of the bias stays below, whatever moved, as a density.
    pub walk_below: Option<f64>,
}

/// Both sensors, and the longest rest where it is long enough for an Allan plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Samples in the filter.
    pub window: usize,
    /// The accelerometer's.
    pub accel: SensorLevels,
    /// The gyroscope's.
    pub gyro: SensorLevels,
    /// The longest stretch at rest.
    pub rest: Option<AllanLog>,
}

impl Levels {
    /// Of a recording with its phases; none where it is shorter than a filter. Takes memory for one axis of the log and its longest rest.
    ///
    /// # Errors
    /// As [`Samples::piece`](dpn_core::Samples::piece).
    pub fn of(recording: &dyn Recorded, stretches: &[Stretch]) -> io::Result<Option<Self>> {
        let half = ((recording.rate().hz() * FILTER_S - 1.0) / 2.0).round().max(2.0) as usize;
        // Beyond 36 kHz the filter is shorter in time; no IMU is there.
        let window = 2 * half.min(SavitzkyGolay::WIDEST / 2) + 1;
        if recording.len() < window {
            return Ok(None);
        }
        let filter = SavitzkyGolay::new(window, 2).expect("an odd window of five samples or more");
        let block = (recording.rate().hz().round() as usize).clamp(8, recording.len().max(8));
        let start = recording.span()[0];
        let mut phases: Vec<Option<Phase>> = Vec::new();
        recording.pieces(0..recording.len(), block, &mut |chunk| {
            phases.push(phase_at(stretches, chunk[chunk.len() / 2].t.seconds_since(start)));
            Ok(())
        })?;
        let sensor = |sensor: Sensor| {
            let rate = recording.rate();
            let mut walk: Option<f64> = None;
            let mut axes = Vec::new();
            for axis in 0..3 {
                let signal = recording.signal(0..recording.len(), sensor, axis)?;
                axes.push(seconds(&filter, &signal, block));
                // The least walk that any axis allows.
                walk = walk.into_iter().chain(walk_below(&signal, rate)).reduce(f64::min);
            }
            Ok::<_, io::Error>(levels(calm(sensor, rate), &axes, &phases, walk))
        };
        let (accel, gyro) = (sensor(Sensor::Accel)?, sensor(Sensor::Gyro)?);
        Ok(Some(Self { window: filter.window(), accel, gyro, rest: rest(recording, stretches)? }))
    }

    /// One sensor's.
    pub fn sensor(&self, sensor: Sensor) -> &SensorLevels {
        match sensor {
            Sensor::Accel => &self.accel,
            Sensor::Gyro => &self.gyro,
        }
    }

    /// What the figures are, for people.
    pub fn words(&self) -> String {
        format!(
            "deviation of the residual of SG({},2) over each second, loudest axis; not the track's estimate",
            self.window
        )
    }
}

/// Deviations of the residual, a second each.
fn seconds(filter: &SavitzkyGolay, signal: &[f64], block: usize) -> Vec<f64> {
    let smooth = filter.smooth(signal).expect("a recording as long as the filter's window");
    let residual: Vec<f64> = signal.iter().zip(smooth).map(|(x, s)| x - s).collect();
    let gain = filter.residual_gain(signal.len());
    residual.chunks(block).map(|chunk| stats::deviation(chunk, Ddof::Zero) / gain).collect()
}

fn levels(calm: f64, axes: &[Vec<f64>], phases: &[Option<Phase>], walk_below: Option<f64>) -> SensorLevels {
    let in_phase = |phase| phases.contains(&Some(phase));
    let moving = [Phase::Moving, Phase::Motors].into_iter().find(|p| in_phase(*p));
    let loudest = |phase: Option<Phase>, level: f64| {
        let of = |seconds: &Vec<f64>| {
            let wanted = seconds.iter().zip(phases).filter(|(_, p)| phase.is_none() || **p == phase);
            stats::quantile(&wanted.map(|(s, _)| *s).collect::<Vec<_>>(), level)
        };
        axes.iter().map(of).fold(0.0, f64::max)
    };
    let quietest = loudest(None, TAIL);
    let at_rest = in_phase(Phase::Rest).then(|| (loudest(Some(Phase::Rest), 0.5), FloorFrom::Rest));
    let floor = at_rest.unwrap_or((quietest, FloorFrom::Quietest));
    let is_long = phases.iter().filter(|p| **p == Some(Phase::Rest)).count() as f64 >= LEAST_S;
    let floor = Some(floor).filter(|(sigma, _)| is_long || *sigma < calm);
    SensorLevels { floor, in_motion: loudest(moving, 0.5), envelope: loudest(moving, 1.0 - TAIL), walk_below }
}

/// The loudest that a sample of a sensor at rest may be.
fn calm(sensor: Sensor, rate: SampleRate) -> f64 {
    CALM * typical(Figure::white(sensor))[1] * rate.hz().sqrt()
}

/// The least walk that an axis allows at any averaging time from a second on.
fn walk_below(signal: &[f64], rate: SampleRate) -> Option<f64> {
    let most = signal.len() / SHARE;
    let mut averages = deviation::averages(signal.len());
    averages.retain(|m| *m <= most && *m as f64 >= rate.hz());
    deviation::variances(signal, rate, &averages)
        .into_iter()
        .zip(&averages)
        .map(|(variance, m)| (3.0 * variance / (*m as f64 * rate.period())).sqrt())
        .filter(|walk| *walk > 0.0)
        .reduce(f64::min)
}

/// The Allan plot of the longest rest.
fn rest(recording: &dyn Recorded, stretches: &[Stretch]) -> io::Result<Option<AllanLog>> {
    let Some(longest) = longest_rest(stretches) else { return Ok(None) };
    let start = recording.span()[0];
    let inside = |t: f64| (longest.from_s..longest.to_s).contains(&t);
    let mut samples = Vec::new();
    recording.each(0..recording.len(), &mut |s| {
        if inside(s.t.seconds_since(start)) {
            samples.push(*s);
        }
    })?;
    let part = ImuRecording::new(samples).ok().filter(|part| part.duration() >= LEAST_S);
    // A hole ends what is used; seconds that swing do not.
    Ok(part.and_then(|part| AllanLog::of(&part, false).ok()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use crate::phases::phases;

    fn of(samples: Vec<dpn_core::ImuSample>) -> Levels {
        let recording = ImuRecording::new(samples).unwrap();
        Levels::of(&recording, &phases(&recording).unwrap()).unwrap().unwrap()
    }

    #[test]
    fn floor_and_envelope_are_those_of_the_samples_however_loud() {
        let mut samples = level(60);
        for s in &mut samples {
            let t = s.t.ns() as f64 * 1e-9;
            if t >= 30.0 {
                // Far above what the shipped networks can say; and a motion that is no noise.
                s.accel[0] += 4.0 * 2f64.sqrt() * (2.0 * std::f64::consts::PI * 87.0 * t).sin();
                s.accel[1] += 5.0 * (2.0 * t).sin();
                s.gyro[0] += 0.6 * (2.0 * t).sin();
            }
        }
        let levels = of(samples);
        let (floor, from) = levels.accel.floor.unwrap();
        assert!(from == FloorFrom::Rest && (floor / 0.028 - 1.0).abs() < 0.05, "{levels:?}");
        let (floor, _) = levels.gyro.floor.unwrap();
        assert!((floor / 0.0024 - 1.0).abs() < 0.05, "{levels:?}");
        // At 87 Hz the filter's complement lets 1.08 pass, and its correction for white noise is 1 / .89.
        assert!((levels.accel.in_motion / (4.0 * 1.08 / 0.89) - 1.0).abs() < 0.02, "{levels:?}");
        assert!(levels.accel.envelope >= levels.accel.in_motion && levels.accel.envelope < 5.0);
        // The gyroscope only turns.
        assert!((levels.gyro.in_motion / 0.0024 - 1.0).abs() < 0.1, "{levels:?}");
        assert!(levels.rest.is_some_and(|rest| (rest.length_s - 30.0).abs() < 2.0));
    }

    #[test]
    fn a_log_that_never_rests_has_a_floor_only_where_nothing_shakes() {
        let turning = |shake: f64| {
            let mut samples = level(30);
            for s in &mut samples {
                let t = s.t.ns() as f64 * 1e-9;
                s.gyro[0] += 0.6 * (2.0 * t).sin();
                s.accel[0] += shake * (2.0 * std::f64::consts::PI * 87.0 * t).sin();
            }
            of(samples)
        };
        let carried = turning(0.0);
        assert_eq!(carried.accel.floor.map(|f| f.1), Some(FloorFrom::Quietest));
        assert!((carried.gyro.floor.unwrap().0 / 0.0024 - 1.0).abs() < 0.15, "{carried:?}");
        assert_eq!(turning(1.0).accel.floor, None);
        assert!(carried.rest.is_none());
    }

    #[test]
    fn a_walk_is_bounded_by_the_stillest_axis_of_a_log_in_motion() {
        let mut samples = level(120);
        for s in &mut samples {
            let t = s.t.ns() as f64 * 1e-9;
            s.gyro[0] += 0.6 * (0.5 * t).sin();
        }
        // y and z have white noise alone: sqrt(3 N^2) / tau at a tenth of the log.
        let bound = of(samples).gyro.walk_below.unwrap();
        let white = 0.0024 / 200f64.sqrt();
        assert!(
            bound > 0.3 * 3f64.sqrt() * white / 12.0 && bound < 3.0 * 3f64.sqrt() * white / 12.0,
            "{bound}"
        );
    }
}
