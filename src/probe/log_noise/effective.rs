//! The white noise that a log's vibration amounts to, by the span of the factor that it is meant for.
//!
//! A configuration asks for one white noise; what sums of samples err by depends on the spectrum and the span
//! ([`Effective`](dpn_core::estimate::Effective)). Medians over the seconds in motion, else of motors on, else of all.

use super::fall;
use super::report::two;
use crate::allan::report::PASTED;
use crate::phases::{Phase, Stretch, phase_at};
use crate::rest_noise::{RestNoise, Shape};
use crate::text::aligned;
use dpn_core::estimate::{Effective, EffectiveStream, MOTION_HZ};
use dpn_core::noise::{Axes, Figure, ImuFigures, Meaning};
use dpn_core::signal::Welch;
use dpn_core::signal::stats::median;
use dpn_core::{ImuSample, Recorded, SampleRate, Sensor};
use dpn_io::noise_formats::{Format, Written, write};
use serde::Serialize;
use std::fmt::Write;
use std::io;
use std::ops::Range;
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
    /// Sensors whose noise in motion a low pass hides that no rest has shown; nothing is pasted of them.
    pub hidden: Vec<Hidden>,
    /// Accelerometer, gyroscope: whether a low pass hides by how much the sensor's own noise grows in motion.
    pub growth_hidden: [bool; 2],
    /// The figures that are pasted.
    #[serde(skip)]
    figures: ImuFigures,
    /// What they are from, accelerometer and gyroscope.
    from: [FigureFrom; 2],
}

/// A sensor whose spectrum falls above motion, as behind a low pass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hidden {
    /// The sensor.
    pub sensor: Sensor,
    /// What the density of its loudest axis lies between \[unit / sqrt(Hz)\]: what is seen above motion, and what is seen with motion in it.
    pub between: [f64; 2],
}

/// Where a figure to paste is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum FigureFrom {
    /// The spectrum at rest.
    Rest,
    /// Sums over [`PASTED_S`].
    Span,
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
        let mut spans = Vec::new();
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
            let sigma = std::array::from_fn(|axis| median(&axes[axis].1));
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
        let Some(mut figures) = over_span(&spans, rate) else { return Ok(None) };
        let mut from = [FigureFrom::Span; 2];
        // What never moves has its noise from all of the spectrum.
        if let (None, Some(rest)) = (phase, rest) {
            for (sensor, from) in Sensor::ALL.into_iter().zip(&mut from) {
                let Some(densities) = rest.sensor(sensor).densities() else { continue };
                if figures.set(Figure::white(sensor), Meaning::Density, Axes::Each(densities), rate).is_ok() {
                    *from = FigureFrom::Rest;
                }
            }
        }
        let mut hidden = Vec::new();
        for sensor in Sensor::ALL {
            let known = (0..3).any(|axis| shape(sensor, axis).is_some());
            if phase.is_none() || known {
                continue;
            }
            if let Some(between) = self::between(recording, sensor, whole.clone(), second, &counts)? {
                hidden.push(Hidden { sensor, between });
                match sensor {
                    Sensor::Accel => figures.accel_white = None,
                    Sensor::Gyro => figures.gyro_white = None,
                }
            }
        }
        let pasted = written(&figures, from, &PASTED);
        Ok(Some(Self { phase, spans, pasted, hidden, growth_hidden, figures, from }))
    }

    /// What is pasted, in other formats than those of `pasted`.
    pub fn in_formats(&self, formats: &[Format]) -> Vec<Written> {
        written(&self.figures, self.from, formats)
    }

    /// For people: a table a sensor, then what to paste.
    pub fn page(&self) -> String {
        let when = self.phase.map_or_else(|| "whole log".to_owned(), |phase| phase.to_string());
        let mut text = String::new();
        for sensor in Sensor::ALL {
            let _ = writeln!(
                text,
                "\n{sensor} {when}: white noise that errs as much over a span, deviation of one sample [{}]",
                sensor.unit()
            );
            let mut rows = vec![["", "x", "y", "z"].map(str::to_owned)];
            for row in self.spans.iter().filter(|s| s.sensor == sensor) {
                let what = match (row.of, sensor) {
                    (Increment::Sample, _) => "one sample".to_owned(),
                    (Increment::Sum, Sensor::Gyro) => format!("angle over {} s", row.span_s),
                    (Increment::Sum, Sensor::Accel) => format!("velocity over {} s", row.span_s),
                    (Increment::Position, _) => format!("position over {} s", row.span_s),
                };
                let [x, y, z] = row.sigma.map(two);
                rows.push([format!("  {what}"), x, y, z]);
            }
            text.push_str(&aligned(&rows));
            for Hidden { between: [low, high], .. } in self.hidden.iter().filter(|h| h.sensor == sensor) {
                let _ = writeln!(
                    text,
                    "  not known: above {MOTION_HZ:.0} Hz the spectrum falls as behind a low pass, so that the density lies between {low:.1e} and {high:.1e} {}/sqrt(Hz);\n  \
                     add ten seconds at rest to the log, which show the low pass, or run the odometry (--noise self)",
                    sensor.unit()
                );
            }
            if self.phase.is_some() && self.growth_hidden[usize::from(sensor == Sensor::Gyro)] {
                let _ = writeln!(
                    text,
                    "  behind this low pass growth in motion is not seen: at least this; a trajectory would tell"
                );
            }
        }
        for written in &self.pasted {
            let _ = write!(text, "\n--- {} ---\n{}", written.format, written.text);
        }
        text
    }
}

/// What a sensor's density lies between, its loudest axis, where the seconds that count fall as behind a low pass.
fn between(
    recording: &dyn Recorded,
    sensor: Sensor,
    range: Range<usize>,
    second: usize,
    counts: &dyn Fn(&[ImuSample]) -> bool,
) -> io::Result<Option<[f64; 2]>> {
    let rate = recording.rate();
    let Ok(welch) = Welch::new(second) else { return Ok(None) };
    let mut axes = [(); 3].map(|()| welch.averaging());
    let mut signal = Vec::with_capacity(second);
    recording.pieces(range, second, &mut |second| {
        for (axis, averaging) in axes.iter_mut().enumerate().filter(|_| counts(second)) {
            signal.clear();
            signal.extend(second.iter().map(|s| s.of(sensor)[axis]));
            averaging.take(&signal);
        }
        Ok(())
    })?;
    let motion = MOTION_HZ.min(0.25 * rate.hz());
    let all = axes.into_iter().filter_map(|averaging| averaging.spectrum(rate));
    let found: Vec<[f64; 2]> = all.filter_map(|spectrum| fall::between(&spectrum, motion)).collect();
    // A low pass is on all axes; what shakes, on one more than on the others.
    let loudest = found.iter().copied().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    // A bound has no more digits than these.
    let short = |density: f64| {
        let text = format!("{:.2e}", (0.5 * density).sqrt());
        text.parse().expect("Rust reads its own numbers")
    };
    Ok(loudest.filter(|_| found.len() == 3).map(|of| of.map(short)))
}

/// White noises over the pasted span; none where one is no noise.
fn over_span(spans: &[SpanNoise], rate: SampleRate) -> Option<ImuFigures> {
    let mut figures = ImuFigures { rate: Some(rate), ..ImuFigures::default() };
    for row in spans.iter().filter(|s| s.of == Increment::Sum && s.span_s == PASTED_S) {
        figures.set(Figure::white(row.sensor), Meaning::SampleStd, Axes::Each(row.sigma), rate).ok()?;
    }
    Some(figures)
}

/// Those of `formats` that can be written: a rate too slow for the span leaves nothing to write.
fn written(figures: &ImuFigures, from: [FigureFrom; 2], formats: &[Format]) -> Vec<Written> {
    let note = |figure: Figure| {
        let words = match from[usize::from(figure.sensor() == Sensor::Gyro)] {
            FigureFrom::Rest => "at rest, by the spectrum".to_owned(),
            FigureFrom::Span => format!("over {PASTED_S} s, vibration included"),
        };
        (!figure.is_walk()).then_some(words)
    };
    formats.iter().filter_map(|format| write(figures, *format, note).ok()).collect()
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
        let more = noise.in_formats(&[Format::Okvis2, Format::Ros]);
        assert_eq!(more.len(), 2);
        assert!(
            more.iter().all(|m| m.text.contains("vibration included") || !m.steps.is_empty()),
            "{more:?}"
        );
        assert!(
            noise.page().contains("velocity over 0.1 s") && noise.page().contains("acc_n"),
            "{}",
            noise.page()
        );
    }
}
