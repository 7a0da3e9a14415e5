//! The white noise that a log's vibration amounts to, by the span of the factor that it is meant for.
//!
//! A configuration asks for one white noise; what sums of samples err by depends on the spectrum and the span
//! ([`Effective`](dpn_core::estimate::Effective)). Medians over the seconds in motion, else of motors on, else of all.

use super::seen::seen;
use super::summary::silent;
use crate::allan::report::PASTED;
use crate::doctor::values::steps_of;
use crate::paste::{FigureLine, Paste};
use crate::phases::{Phase, Stretch, phase_at};
use crate::rest_noise::{LowPass, RestNoise, Shape};
use dpn_core::estimate::{Effective, EffectiveStream, Fall, MOTION_HZ, SLOWEST, Seen};
use dpn_core::noise::{Figure, Interval};
use dpn_core::signal::stats::median;
use dpn_core::{ImuSample, Recorded, SampleRate, Sensor};
use dpn_io::noise_formats::{Format, Written};
use serde::Serialize;
use std::io;
use std::sync::Arc;

/// Spans \[s\] from a fast camera's interval to that between key frames.
const SPANS_S: [f64; 4] = [0.05, 0.1, 0.5, 1.0];
/// The span whose figures are written out to paste: two frames of a camera of 20 Hz, one of 10 Hz.
const PASTED_S: f64 = 0.1;

/// What the samples are summed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Increment {
    /// A sample alone.
    Sample,
    /// A sum: angle of a gyroscope, velocity of an accelerometer.
    Sum,
    /// A double sum of the accelerometer.
    Position,
}

/// One sensor over one span.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpanNoise {
    /// The sensor.
    pub sensor: Sensor,
    /// What its samples are summed to.
    pub of: Increment,
    /// Over how long \[s\].
    pub span_s: f64,
    /// Deviation of one sample of white noise that errs as much, x, y, z, in the sensor's unit.
    pub sigma: [f64; 3],
}

/// All spans, and what follows for configurations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectiveNoise {
    /// Whose seconds were used; none for the whole log.
    pub phase: Option<Phase>,
    /// A row a sensor and span.
    pub spans: Vec<SpanNoise>,
    /// White noises over .1 s as configurations have them, of the loudest axis where they have one for all; empty where the rate has no such span.
    pub pasted: Vec<Written>,
    /// Sensors whose spectrum in motion falls as behind a low pass that no rest has shown.
    pub behind: Vec<Behind>,
    /// Accelerometer, gyroscope: what the spectrum in motion says of a low pass that no rest has shown.
    #[serde(skip)]
    pub seen: [Seen; 2],
    /// Accelerometer, gyroscope: whether a low pass hides by how much the sensor's own noise grows in motion.
    pub growth_hidden: [bool; 2],
    /// The figures over .1 s as densities, where each comes from, or why it is not known.
    pub paste: Paste,
}

/// A sensor whose spectrum falls above motion, as behind a low pass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Behind {
    /// The sensor.
    pub sensor: Sensor,
    /// The filter that fits best.
    #[serde(flatten)]
    pub low_pass: LowPass,
    /// Its corner \[Hz\]; none of a moving mean.
    pub corner_hz: Option<f64>,
    /// What the density of its loudest axis lies between \[unit / sqrt(Hz)\], over all filters that fit.
    pub between: [f64; 2],
    /// Whether these agree, so that it is a figure; a bound otherwise.
    pub is_known: bool,
}

impl Behind {
    fn of(sensor: Sensor, fall: &Fall) -> Self {
        let corner_hz = (fall.low_pass.order() > 0).then_some(fall.corner_hz);
        let Fall { low_pass, between, density, .. } = *fall;
        Self { sensor, low_pass, corner_hz, between, is_known: density.is_some() }
    }
}

impl EffectiveNoise {
    /// Of a recording with its phases, and what its rest says of the sensor's low pass; none where it has no second.
    ///
    /// # Errors
    /// As [`Samples::piece`](dpn_core::Samples::piece).
    pub fn of(
        recording: &dyn Recorded,
        stretches: &[Stretch],
        rest: Option<&RestNoise>,
    ) -> io::Result<Option<Self>> {
        let rate = recording.rate();
        let phase =
            [Phase::Moving, Phase::Motors].into_iter().find(|p| stretches.iter().any(|s| s.phase == *p));
        let start = recording.span()[0];
        let Ok(shortest) = Effective::sum(1.0, rate) else { return Ok(None) };
        let second = shortest.min_len().max(rate.hz().round() as usize);
        // A second counts where its middle is in the phase.
        let counts = |second: &[ImuSample]| {
            let t = second[second.len() / 2].t.seconds_since(start);
            phase.is_none() || phase_at(stretches, t) == phase
        };
        let whole = 0..recording.len() - recording.len() % second;
        let mut any = false;
        recording.pieces(whole.clone(), second, &mut |second| {
            any |= counts(second);
            Ok(())
        })?;
        if !any {
            return Ok(None);
        }
        let (mut spans, mut pasted_spans, mut constant) = (Vec::new(), [None; 2], [false; 2]);
        let shape = |sensor: Sensor, axis: usize| rest.and_then(|rest| rest.sensor(sensor).shape(axis, rate));
        let behind = |effective: Effective, shape: Shape| {
            effective.behind(|hz| shape.gain(hz), 2.0 * shape.density.powi(2))
        };
        // What a low pass leaves to tell by is the same for every span.
        let hides = |shape: Shape| {
            Effective::sum(1.0, rate).is_ok_and(|effective| !behind(effective, shape).tells_growth())
        };
        let growth_hidden =
            Sensor::ALL.map(|sensor| (0..3).any(|axis| shape(sensor, axis).is_some_and(hides)));
        let mut row = |sensor: Sensor, of: Increment, span_s: f64, plain: &dyn Fn() -> Option<Effective>| {
            let mut axes = Vec::with_capacity(3);
            for axis in 0..3 {
                let Some(mut effective) = plain() else { return Ok::<_, io::Error>(()) };
                if let Some(shape) = shape(sensor, axis) {
                    effective = behind(effective, shape);
                }
                axes.push((EffectiveStream::new(Arc::new(effective)), Vec::new()));
            }
            let mut signal = Vec::with_capacity(second);
            recording.pieces(whole.clone(), second, &mut |second| {
                for (axis, (stream, sigmas)) in axes.iter_mut().enumerate() {
                    signal.clear();
                    signal.extend(second.iter().map(|s| s.of(sensor)[axis]));
                    // All seconds are gone through: a rest before the motion shows the sensor's own noise.
                    let sigma = stream.sigma(&signal);
                    if counts(second) {
                        sigmas.push(sigma);
                    }
                }
                Ok(())
            })?;
            let found: [Interval; 3] = std::array::from_fn(|axis| median_of_seconds(&axes[axis].1));
            let sigma = found.map(|axis| axis.value);
            if of == Increment::Sum && span_s == PASTED_S {
                let density = found.map(|axis| axis.times(rate.period().sqrt()));
                let is_noise = |axis: &Interval| axis.value > 0.0 && axis.high.is_finite();
                let i = usize::from(sensor == Sensor::Gyro);
                pasted_spans[i] = density.iter().all(is_noise).then_some(density);
                constant[i] = density.iter().any(|axis| axis.value == 0.0);
            }
            spans.push(SpanNoise { sensor, of, span_s, sigma });
            Ok(())
        };
        for sensor in Sensor::ALL {
            let sample_s = rate.period() * (1.0 + 1e-9);
            row(sensor, Increment::Sample, rate.period(), &|| Effective::sum(sample_s, rate).ok())?;
            for span_s in SPANS_S {
                row(sensor, Increment::Sum, span_s, &|| Effective::sum(span_s, rate).ok())?;
                if sensor == Sensor::Accel {
                    row(sensor, Increment::Position, span_s, &|| Effective::double(span_s, rate).ok())?;
                }
            }
        }
        let silent = silent(recording)?;
        let steps = steps_of(recording)?;
        let mut behind: Vec<Behind> = Vec::new();
        let mut all_seen = [Seen::Untold; 2];
        let mut lines = Vec::new();
        for (i, sensor) in Sensor::ALL.into_iter().enumerate() {
            let known = (0..3).any(|axis| shape(sensor, axis).is_some());
            if phase.is_some() && !known {
                all_seen[i] = seen(recording, sensor, steps[i], whole.clone(), second, &counts)?;
            }
            let (fall, [less, more]) = match all_seen[i] {
                Seen::Falls(fall) => (Some(fall), [1.0; 2]),
                Seen::Flat { apart, .. } => (None, apart),
                Seen::Untold => (None, [1.0; 2]),
            };
            let wider = |axis: Interval| Interval { low: less * axis.low, high: more * axis.high, ..axis };
            let span = pasted_spans[i].map(|axes| axes.map(wider));
            behind.extend(fall.as_ref().map(|fall| Behind::of(sensor, fall)));
            // What never moves has its noise from all of the spectrum.
            let rest = rest.filter(|_| phase.is_none()).and_then(|rest| rest.sensor(sensor).densities());
            let hides = phase.is_some() && growth_hidden[i];
            // What is looked at above motion must be there.
            let slow = phase == Some(Phase::Moving) && rate.hz() < SLOWEST * MOTION_HZ;
            lines.extend(if silent == Some(sensor) {
                Some(FigureLine::unknown(Figure::white(sensor), "its values are zeros throughout"))
            } else if constant[i] {
                let why = "an axis never changes: it is off, or its steps are larger than its noise";
                Some(FigureLine::unknown(Figure::white(sensor), why))
            } else if slow {
                span.map(|axes| {
                    let seen = axes.iter().map(|axis| axis.high).fold(0.0, f64::max);
                    too_slow(sensor, rate, fall.map_or(seen, |fall| fall.between[1]))
                })
            } else {
                line(sensor, span, (rest, fall.as_ref(), hides))
            });
        }
        let paste = Paste { rate_hz: rate, lines };
        let pasted = paste.written(&PASTED);
        Ok(Some(Self { phase, spans, pasted, behind, seen: all_seen, growth_hidden, paste }))
    }

    /// Deviations of one sample that err as much over the span that is pasted, x, y, z; none where the rate has no such span.
    pub(super) fn pasted_span(&self, sensor: Sensor) -> Option<[f64; 3]> {
        let of = |s: &&SpanNoise| (s.sensor, s.of) == (sensor, Increment::Sum) && s.span_s == PASTED_S;
        self.spans.iter().find(of).map(|s| s.sigma)
    }

    /// For people: the figures to paste, with the lines of `formats`.
    pub fn page(&self, formats: &[Format]) -> String {
        let when = self.phase.map_or_else(|| "whole log".to_owned(), |phase| phase.to_string());
        format!("{when}: the white noise that errs as much over {PASTED_S} s\n{}", self.paste.page(formats))
    }
}

/// That a rate is too slow to tell noise from motion, and where enough of it is above motion to see a low pass, a bound.
fn too_slow(sensor: Sensor, rate: SampleRate, most: f64) -> FigureLine {
    let most = if Seen::tells(rate) { format!("at most {most:.1e}: ") } else { String::new() };
    let why = format!(
        "{most}{:.0} Hz do not tell noise from motion; 30 s at rest do, or a trajectory (--against)",
        rate.hz()
    );
    FigureLine::unknown(Figure::white(sensor), why)
}

/// A figure to paste, and where it comes from or why it is not known.
fn line(
    sensor: Sensor,
    span: Option<[Interval; 3]>,
    (rest, fall, growth_hidden): (Option<[Interval; 3]>, Option<&Fall>, bool),
) -> Option<FigureLine> {
    let figure = Figure::white(sensor);
    if let Some(fall) = fall {
        let low_pass = fall.words();
        if let Some(density) = fall.density {
            return Some(FigureLine::known(
                figure,
                density,
                format!("in motion, by the shape of {low_pass}"),
            ));
        }
        let [low, high] = fall.between;
        return Some(FigureLine::unknown(
            figure,
            format!(
                "above {MOTION_HZ:.0} Hz the spectrum falls as behind {low_pass}, so that it lies between {low:.1e} and {high:.1e}; add ten seconds at rest to the log, \
                 or run the odometry (dpn run --noise self)"
            ),
        ));
    }
    if let Some(rest) = rest {
        return Some(FigureLine::known(figure, rest, "at rest, by the spectrum"));
    }
    let span = span?;
    if span.iter().any(|axis| axis.width() > Interval::WIDEST) {
        let [low, high] = [|axis: &Interval| axis.low, |axis: &Interval| axis.high]
            .map(|end| span.iter().map(end).fold(0.0, f64::max));
        let why = format!(
            "between {low:.1e} and {high:.1e}: too few seconds in motion tell whether a low pass is on"
        );
        return Some(FigureLine::unknown(figure, why));
    }
    let words = match growth_hidden {
        true => format!("over {PASTED_S} s; at least this, a low pass hides growth in motion"),
        false => format!("over {PASTED_S} s, vibration included"),
    };
    Some(FigureLine::known(figure, span, words))
}

/// Median of the seconds' deviations, and how well so many seconds know it.
fn median_of_seconds(sigmas: &[f64]) -> Interval {
    /// The median's deviation over the mean's, and a normal deviation over the median of distances.
    const OF_MEDIAN: [f64; 2] = [1.2533, 1.4826];
    /// What chance makes of a second, and how many seconds that is worth: a few may agree by accident.
    const SECOND: [f64; 2] = [0.1, 4.0];
    let (middle, count) = (median(sigmas), sigmas.len() as f64);
    let apart: Vec<f64> = sigmas.iter().map(|sigma| (sigma / middle).ln().abs()).collect();
    let own = (OF_MEDIAN[1] * median(&apart)).powi(2);
    let spread = (count * own + SECOND[1] * SECOND[0].powi(2)) / (count + SECOND[1]);
    Interval::of_log(middle, OF_MEDIAN[0] * (spread / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use crate::phases::phases;
    use dpn_core::ImuRecording;

    #[test]
    fn a_rotor_counts_less_the_longer_the_span_and_motion_not_at_all() {
        let mut samples = level(40);
        for s in &mut samples {
            let t = s.t.ns() as f64 * 1e-9;
            s.gyro[0] += 0.8 * (6.0 * t).sin();
            s.accel[0] += (2.0 * std::f64::consts::PI * 91.3 * t).sin();
        }
        let recording = ImuRecording::new(samples).unwrap();
        let noise = EffectiveNoise::of(&recording, &phases(&recording).unwrap(), None).unwrap().unwrap();
        assert_eq!(noise.phase, Some(Phase::Moving));
        let of = |sensor, of, span_s: f64| {
            noise
                .spans
                .iter()
                .find(|s| (s.sensor, s.of) == (sensor, of) && (s.span_s - span_s).abs() < 1e-3)
                .unwrap()
                .sigma
        };
        let gyro = of(Sensor::Gyro, Increment::Sum, 0.1);
        assert!(gyro.iter().all(|g| (g / 0.0024 - 1.0).abs() < 0.15), "{gyro:?}");
        let [sample, short, long] =
            [(Increment::Sample, 0.005), (Increment::Sum, 0.05), (Increment::Sum, 0.5)]
                .map(|(what, span)| of(Sensor::Accel, what, span)[0]);
        // A tone of angular step w adds up over n samples to |sin(n w/2) / sin(w/2)| times itself, white noise to sqrt(n).
        let half = std::f64::consts::PI * 91.3 / 200.0;
        let sum = |n: f64| ((n * half).sin() / half.sin()).abs() / n.sqrt() * 0.5f64.sqrt();
        for (found, expected) in [(sample, sum(1.0)), (short, sum(10.0)), (long, sum(100.0))] {
            assert!((found / expected - 1.0).abs() < 0.15, "{found} {expected}");
        }
        assert_eq!(noise.pasted.len(), PASTED.len());
        let more = noise.paste.written(&[Format::Okvis2, Format::Ros]);
        assert_eq!(more.len(), 2);
        let page = noise.page(&[Format::Vins]);
        assert!(page.contains("over 0.1 s, vibration included") && page.contains("acc_n: "), "{page}");
    }
}
