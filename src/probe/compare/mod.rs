//! Two logs of one sensor: what has changed from the first to the second.
//!
//! * Levels of white noise, at rest by the whole spectrum and in motion over .1 s: ratio of the second to the first, its logarithm's variance the sum of both.
//! * Bias at rest: of the gyroscope the mean, of the accelerometer the length of the specific force; from means over eighths of the rest, whose scatter says how
//!   well they are known.
//! * Bands that shake, samples lost, findings.
//! * Whether it is one sensor at all: units, rates, converters' steps, low passes.

mod report;

use crate::allan::rest::rest;
use crate::doctor::values::steps_of;
use crate::doctor::vibration::{AxisSpectrum, Shaking, shaking};
use crate::doctor::{Examination, LogFigures};
use crate::finding::{Finding, Weight};
use crate::log_noise::EffectiveNoise;
use crate::phases::phases;
use crate::rest_noise::RestNoise;
use dpn_core::estimate::MOTION_HZ;
use dpn_core::noise::{Figure, Interval};
use dpn_core::signal::stats::{Ddof, deviation, mean};
use dpn_core::{Recorded, Sensor};
use serde::Serialize;
use std::io;

/// Parts of a rest that its bias is averaged over.
const PARTS: usize = 8;
/// 97.5 % of Student's distribution with seven degrees of freedom.
const STUDENT: f64 = 2.365;
/// Forces, steps and corners that differ by less are one sensor's.
const ALIKE: f64 = 1.25;
/// Rates that differ by less are one.
const SAME_RATE: f64 = 0.02;

/// One log, as far as it is compared.
#[derive(Debug, Clone)]
pub struct Side {
    rate_hz: f64,
    length_s: f64,
    figures: LogFigures,
    lost: f64,
    rest: Option<RestNoise>,
    effective: Option<EffectiveNoise>,
    bias: Option<[Known; 4]>,
    steps: [[Option<f64>; 3]; 2],
    shaking: Vec<Shaking>,
    findings: Vec<Finding>,
    /// Spectra of the six axes; none where the log is too short.
    pub spectra: Vec<AxisSpectrum>,
}

/// A mean and its deviation.
#[derive(Debug, Clone, Copy)]
struct Known {
    value: f64,
    std: f64,
}

impl Side {
    /// The gravest finding, where it is bad: what is to be mended before anything is compared.
    pub fn bad(&self) -> Option<&Finding> {
        self.findings.first().filter(|found| found.weight == Weight::Bad)
    }

    /// Of a log and its examination.
    ///
    /// # Errors
    /// As [`Samples::piece`](dpn_core::Samples::piece).
    pub fn of(recording: &dyn Recorded, examination: Examination) -> io::Result<Self> {
        let stretches = phases(recording)?;
        let effective = EffectiveNoise::of(recording, &stretches, examination.rest.as_ref())?;
        let bias = match &examination.rest {
            Some(_) => bias(recording)?,
            None => None,
        };
        let Examination { samples, length_s, rate_hz, figures, findings, spectra, rest } = examination;
        Ok(Self {
            rate_hz,
            length_s,
            figures,
            lost: figures.lost / (samples as f64 + figures.lost).max(1.0),
            rest,
            effective,
            bias,
            steps: steps_of(recording)?,
            shaking: shaking(&spectra),
            findings,
            spectra,
        })
    }

    /// Densities at rest.
    fn at_rest(&self, sensor: Sensor) -> Option<[Interval; 3]> {
        self.rest.as_ref()?.sensor(sensor).densities()
    }

    /// Densities in motion, and what the motion is.
    fn in_motion(&self, sensor: Sensor) -> Option<(String, [Interval; 3])> {
        let effective = self.effective.as_ref()?;
        let line = effective.paste.lines.iter().find(|line| line.figure == Figure::white(sensor))?;
        Some((effective.phase?.to_string(), line.density?))
    }

    fn step(&self, sensor: Sensor) -> Option<f64> {
        let steps = &self.steps[usize::from(sensor == Sensor::Gyro)];
        steps.iter().flatten().copied().min_by(f64::total_cmp)
    }
}

/// Means of the gyroscope and of the specific force's length over the longest rest.
fn bias(recording: &dyn Recorded) -> io::Result<Option<[Known; 4]>> {
    let longest = rest(recording)?.longest;
    let part = longest.len() / PARTS;
    if part == 0 {
        return Ok(None);
    }
    let mut means: [Vec<f64>; 4] = Default::default();
    for i in 0..PARTS {
        let from = longest.start + i * part;
        let mut sum = [0.0; 6];
        recording.each(from..from + part, &mut |sample| {
            let all = Sensor::ALL.into_iter().flat_map(|sensor| sample.of(sensor));
            sum.iter_mut().zip(all).for_each(|(sum, v)| *sum += v / part as f64);
        })?;
        let force = (sum[0].powi(2) + sum[1].powi(2) + sum[2].powi(2)).sqrt();
        [force, sum[3], sum[4], sum[5]].into_iter().zip(&mut means).for_each(|(v, of)| of.push(v));
    }
    Ok(Some(
        means.map(|of| Known { value: mean(&of), std: deviation(&of, Ddof::One) / (PARTS as f64).sqrt() }),
    ))
}

/// A level of white noise in both logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Level {
    /// The sensor.
    pub sensor: Sensor,
    /// `at rest`, `moving`, `motors on`.
    pub when: String,
    /// Densities of x, y, z in the first log \[unit / sqrt(Hz)\], and in the second.
    pub densities: [[Interval; 3]; 2],
    /// The second over the first, by axis.
    pub ratios: [Interval; 3],
    /// Their geometric mean.
    pub ratio: Interval,
}

/// A mean at rest in both logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BiasChange {
    /// `gyro x`, or `specific force`.
    pub of: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// In the first log, and in the second.
    pub values: [f64; 2],
    /// The second less the first, with its 95 % interval.
    pub change: [f64; 3],
}

/// A band that shakes in either log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BandChange {
    /// The sensor.
    pub sensor: Sensor,
    /// `x`, `y` or `z`.
    pub axis: &'static str,
    /// In the first log, and in the second; none where it does not stand out.
    pub bands: [Option<Shaking>; 2],
}

/// What has changed from one log to another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Median rates \[Hz\].
    pub rate_hz: [f64; 2],
    /// Lengths \[s\].
    pub length_s: [f64; 2],
    /// Seconds at rest.
    pub rest_s: [f64; 2],
    /// Shares of the samples that were lost.
    pub lost: [f64; 2],
    /// Why they may not be one sensor's, or cannot be held against each other.
    pub remarks: Vec<String>,
    /// Levels that both logs tell.
    pub levels: Vec<Level>,
    /// Means at rest; none where not both rest.
    pub bias: Vec<BiasChange>,
    /// What shakes in either.
    pub bands: Vec<BandChange>,
    /// Findings that warn and that the other log has not.
    pub findings: [Vec<Finding>; 2],
}

impl Comparison {
    /// Of two logs; none where nothing in them can be held against each other.
    pub fn of(sides: [&Side; 2]) -> Option<Self> {
        let [a, b] = sides;
        let one_unit = alike(a.figures.gravity, b.figures.gravity);
        let mut levels = Vec::new();
        for sensor in Sensor::ALL.into_iter().filter(|sensor| one_unit || *sensor == Sensor::Gyro) {
            let level = |when: String, [a, b]: [[Interval; 3]; 2]| Level::new(sensor, when, [a, b]);
            if let (Some(a), Some(b)) = (a.at_rest(sensor), b.at_rest(sensor)) {
                levels.extend(level("at rest".to_owned(), [a, b]));
            }
            if let (Some((when, a)), Some((other, b))) = (a.in_motion(sensor), b.in_motion(sensor))
                && when == other
            {
                levels.extend(level(when, [a, b]));
            }
        }
        let bias = match (&a.bias, &b.bias) {
            (Some(a), Some(b)) => biases([a, b], one_unit),
            _ => Vec::new(),
        };
        let bands = bands(sides, one_unit);
        if levels.is_empty() && bias.is_empty() && bands.is_empty() {
            return None;
        }
        let others = |of: &Side, other: &Side| -> Vec<Finding> {
            let new = |f: &&Finding| {
                f.warns()
                    && f.about != "vibration"
                    && !other.findings.iter().any(|o| o.about == f.about && o.warns())
            };
            of.findings.iter().filter(new).cloned().collect()
        };
        Some(Self {
            rate_hz: sides.map(|side| side.rate_hz),
            length_s: sides.map(|side| side.length_s),
            rest_s: sides.map(|side| side.figures.rest_s),
            lost: sides.map(|side| side.lost),
            remarks: remarks(sides, one_unit, &levels),
            levels,
            bias,
            bands,
            findings: [others(a, b), others(b, a)],
        })
    }
}

impl Level {
    /// None where an axis has no noise.
    fn new(sensor: Sensor, when: String, densities: [[Interval; 3]; 2]) -> Option<Self> {
        let [a, b] = &densities;
        if a.iter().chain(b).any(|axis| axis.low.is_nan() || axis.low <= 0.0 || axis.high.is_infinite()) {
            return None;
        }
        let log = [0, 1, 2].map(|k| {
            let std = a[k].log_deviation().hypot(b[k].log_deviation());
            ((b[k].value / a[k].value).ln(), std)
        });
        let ratios = log.map(|(ln, std)| Interval::of_log(ln.exp(), std));
        let all = log.iter().map(|(ln, _)| ln).sum::<f64>() / 3.0;
        let std = log.iter().map(|(_, std)| std * std).sum::<f64>().sqrt() / 3.0;
        Some(Self { sensor, when, densities, ratios, ratio: Interval::of_log(all.exp(), std) })
    }
}

fn alike(a: f64, b: f64) -> bool {
    let ratio = b / a;
    ratio.is_finite() && (ALIKE.recip()..=ALIKE).contains(&ratio)
}

fn biases([a, b]: [&[Known; 4]; 2], one_unit: bool) -> Vec<BiasChange> {
    let names = [("specific force", "m/s^2"), ("gyro x", "rad/s"), ("gyro y", "rad/s"), ("gyro z", "rad/s")];
    let change = |((of, unit), (a, b)): ((&'static str, &'static str), (&Known, &Known))| {
        let (middle, spread) = (b.value - a.value, STUDENT * a.std.hypot(b.std));
        let change = [middle, middle - spread, middle + spread];
        BiasChange { of, unit, values: [a.value, b.value], change }
    };
    names.into_iter().zip(a.iter().zip(b)).skip(usize::from(!one_unit)).map(change).collect()
}

/// Bands of one axis belong together where they stand as near as rotors change their speed.
fn bands([a, b]: [&Side; 2], one_unit: bool) -> Vec<BandChange> {
    let near = |a: &Shaking, b: &Shaking| {
        (a.sensor, a.axis) == (b.sensor, b.axis) && (a.hz - b.hz).abs() < (0.05 * a.hz).max(2.0)
    };
    let of = |bands: [Option<Shaking>; 2]| {
        let one = bands[0].or(bands[1])?;
        Some(BandChange { sensor: one.sensor, axis: ["x", "y", "z"][one.axis], bands })
    };
    let mut left: Vec<Shaking> = b.shaking.clone();
    let mut all = Vec::new();
    for own in &a.shaking {
        let at = left.iter().position(|other| near(own, other));
        all.extend(of([Some(*own), at.map(|at| left.remove(at))]));
    }
    all.extend(left.into_iter().filter_map(|other| of([None, Some(other)])));
    all.retain(|change| one_unit || change.sensor == Sensor::Gyro);
    all
}

/// By how much the second log's spectra of a sensor are above the first's where no motion is, by the root of the powers; none where the log is too short or slow.
fn above_motion([a, b]: [&Side; 2], sensor: Sensor) -> Option<f64> {
    let power = |side: &Side| {
        let of = side.spectra.iter().filter(|axis| axis.sensor == sensor);
        of.map(|axis| axis.spectrum.band_power(MOTION_HZ, 0.5 * side.rate_hz)).sum::<f64>()
    };
    let ratio = (power(b) / power(a)).sqrt();
    (ratio.is_finite() && ratio > 0.0 && alike(a.rate_hz, b.rate_hz)).then_some(ratio)
}

fn remarks([a, b]: [&Side; 2], one_unit: bool, levels: &[Level]) -> Vec<String> {
    let mut all = Vec::new();
    for level in levels.iter().filter(|level| level.when != "at rest") {
        let Some(spectrum) = above_motion([a, b], level.sensor) else { continue };
        let Interval { low, high, .. } = level.ratio;
        if (high < 1.0 && spectrum > ALIKE) || (low > 1.0 && spectrum < ALIKE.recip()) {
            all.push(format!(
                "the {}'s spectrum above {MOTION_HZ:.0} Hz is {spectrum:.2} times A's, its noise over .1 s {:.2} times: what shakes in lines averages out over .1 s and hides what is white; neither is the sensor's own noise, which 10 s at rest in both would tell",
                level.sensor, level.ratio.value
            ));
        }
    }
    let (g, h) = (a.figures.gravity, b.figures.gravity);
    if !one_unit {
        all.push(format!(
            "the specific force is {g:.3} m/s^2 in A and {h:.3} in B: not in one unit, the accelerometers are not compared; dpn convert with --accel-unit makes one of both"
        ));
    }
    if (b.rate_hz / a.rate_hz - 1.0).abs() > SAME_RATE {
        all.push(format!(
            "A has {:.1} Hz and B {:.1}: densities do not depend on it, lost bands and folded ones do",
            a.rate_hz, b.rate_hz
        ));
    }
    for sensor in Sensor::ALL {
        if let (Some(one), Some(other)) = (a.step(sensor), b.step(sensor))
            && !alike(one, other)
            && (one_unit || sensor == Sensor::Gyro)
        {
            all.push(format!(
                "the {sensor} counts in steps of {one:.2e} {unit} in A and {other:.2e} in B: another sensor, or another range",
                unit = sensor.unit()
            ));
        }
        let corner = |side: &Side| Some(side.rest.as_ref()?.sensor(sensor).filter()?.corner_hz.value);
        match (corner(a), corner(b)) {
            (Some(one), Some(other)) if !alike(one, other) => all.push(format!(
                "the {sensor} is behind a low pass of {one:.0} Hz in A and of {other:.0} Hz in B: another sensor, or other settings"
            )),
            _ => {}
        }
        if levels.iter().all(|level| level.sensor != sensor) && (one_unit || sensor == Sensor::Gyro) {
            let does = |side: &Side| match (&side.rest, side.effective.as_ref().and_then(|e| e.phase)) {
                (Some(_), None) => "only rests",
                (Some(_), Some(_)) => "rests and moves",
                (None, Some(_)) => "only moves",
                (None, None) => "tells no noise",
            };
            all.push(format!(
                "of the {sensor}'s noise nothing is compared: A {}, B {}; ten seconds at rest in both make it known",
                does(a),
                does(b)
            ));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::examine;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;

    /// 30 s at rest at 200 Hz: noise, a gyroscope's bias on x, a shake of the accelerometer on z at a frequency.
    fn side(seed: u64, noise: f64, bias: f64, shake: (f64, f64)) -> Side {
        let mut rng = Stream::new(seed).named("compare").rng();
        let mut draw = || -> f64 { rng.sample(StandardNormal) };
        let sample = |i: i64| {
            let t = i as f64 * 0.005;
            let mut three = |sigma: f64| [draw(), draw(), draw()].map(|v| sigma * v);
            let (mut gyro, mut accel) = (three(0.002 * noise), three(0.02 * noise));
            gyro[0] += bias;
            accel[2] += 9.81 + shake.0 * (std::f64::consts::TAU * shake.1 * t).sin();
            ImuSample { t: Stamp::from_ns(i * 5_000_000), gyro, accel }
        };
        let recording = ImuRecording::new((0..6000).map(sample).collect()).unwrap();
        Side::of(&recording, examine(&recording).unwrap()).unwrap()
    }

    #[test]
    fn a_louder_sensor_with_another_bias_and_a_new_band_is_told() {
        let (a, b) = (side(1, 1.0, 0.0, (0.0, 0.0)), side(2, 1.5, 0.001, (0.1, 61.0)));
        let found = Comparison::of([&a, &b]).unwrap();
        assert_eq!(found.remarks, Vec::<String>::new());
        for level in found.levels.iter().filter(|level| level.sensor == Sensor::Gyro) {
            assert!(level.ratio.low > 1.4 && level.ratio.high < 1.6, "{level:?}");
        }
        let x = found.bias.iter().find(|bias| bias.of == "gyro x").unwrap();
        assert!(x.change[1] > 0.0008 && x.change[2] < 0.0012, "{x:?}");
        let y = found.bias.iter().find(|bias| bias.of == "gyro y").unwrap();
        assert!(y.change[1] < 0.0 && y.change[2] > 0.0, "{y:?}");
        let [band] = &found.bands[..] else { panic!("{:?}", found.bands) };
        let new = band.bands[1].unwrap();
        assert!(
            band.bands[0].is_none() && (new.hz - 61.0).abs() < 0.2 && (new.rms - 0.0707).abs() < 0.01,
            "{new:?}"
        );
        // Against itself nothing has changed, and the band is found again.
        let same = Comparison::of([&b, &b]).unwrap();
        assert!(same.levels.iter().all(|level| (level.ratio.value - 1.0).abs() < 1e-12), "{same:?}");
        assert!(same.bands[0].bands.iter().all(Option::is_some));
    }

    #[test]
    fn other_units_are_no_comparison_of_accelerometers() {
        let (a, mut b) = (side(1, 1.0, 0.0, (0.0, 0.0)), side(2, 1.0, 0.0, (0.0, 0.0)));
        b.figures.gravity = 1.0;
        let found = Comparison::of([&a, &b]).unwrap();
        assert!(found.levels.iter().all(|level| level.sensor == Sensor::Gyro));
        assert!(
            found.remarks[0].starts_with("the specific force is 9.81") && found.remarks.len() == 1,
            "{found:?}"
        );
    }
}
