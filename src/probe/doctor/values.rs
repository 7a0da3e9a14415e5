//! Gravity, units, swapped columns, clipped and dead axes, the converter's step.

use super::kept::Kept;
use super::{clock, mixed};
use crate::allan::rest::Rest;
use crate::finding::{Finding, Weight};
use dpn_core::check::{RecordingFault, stuck};
use dpn_core::signal::ranks::{Column, Level, levels};
use dpn_core::signal::stats;
use dpn_core::{GRAVITY, ImuRecording, ImuSample, Recorded, Sensor};
use std::io;
use std::ops::Range;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Share of the samples that may be outliers; where there are more, the unit is wrong.
const FEW: f64 = 0.01;
/// Length of a specific force beyond which neither m/s^2 nor g nor mg were meant \[m/s^2\].
const COUNTS: f64 = 50.0;

/// What no IMU measures: 5700 deg/s, 200 g \[rad/s, m/s^2\].
fn most(sensor: Sensor) -> f64 {
    match sensor {
        Sensor::Accel => 2000.0,
        Sensor::Gyro => 100.0,
    }
}

/// A recording without the few samples that no IMU measures, none where there are none, and what is to be said of them.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn without_outliers(recording: &dyn Recorded) -> io::Result<(Option<Kept<'_>>, Option<Finding>)> {
    let beyond = |s: &ImuSample| {
        Sensor::ALL.into_iter().find_map(|sensor| {
            let axis = s.of(sensor).iter().position(|v| v.abs() > most(sensor))?;
            Some((sensor, axis))
        })
    };
    let len = recording.len();
    let few = (FEW * len as f64) as usize;
    let (mut index, mut count, mut places, mut first) = (0, 0, Vec::new(), None);
    recording.each(0..len, &mut |s| {
        if let Some(found) = beyond(s) {
            count += 1;
            first.get_or_insert((*s, found));
            // Beyond the few that are left out, their places are of no use.
            if places.len() <= few {
                places.push(index);
            }
        }
        index += 1;
    })?;
    let Some((sample, (sensor, axis))) = first.filter(|_| count as f64 <= FEW * len as f64) else {
        return Ok((None, None));
    };
    let text = format!(
        "{sensor} {} reads {:.4e} {} at {:.3} s, more than any IMU measures; {count} sample(s) like it are left out of what follows",
        AXES[axis],
        sample.of(sensor)[axis],
        sensor.unit(),
        sample.t.seconds_since(recording.span()[0])
    );
    let remedy = "leave such samples out of the log: one of them throws an estimator off";
    Ok((Kept::new(recording, 0..len, places)?, Some(Finding::bad("outliers", text, remedy))))
}

/// What is to be said, and the length of the specific force.
pub(super) fn findings(recording: &dyn Recorded, rest: &Rest) -> io::Result<(Vec<Finding>, f64)> {
    let (mut findings, force) = gravity(recording, rest)?;
    if !is_mixed_up(&findings) {
        findings.extend(mixed::loud(recording)?);
    }
    for fault in stuck(recording)? {
        let about = match &fault {
            RecordingFault::Saturated { .. } => "clipped",
            RecordingFault::Constant { .. } => "dead",
            // `timing` says more about these.
            _ => continue,
        };
        let remedy = if about == "clipped" {
            "choose a larger measuring range; what is cut off cannot be integrated"
        } else {
            "look at the wiring or the column"
        };
        findings.push(Finding::bad(about, fault.to_string(), remedy));
    }
    findings.extend(steps(recording)?);
    Ok((findings, force))
}

/// Norm of a vector.
fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// What is so wrong with clock, gravity, columns or units that no figure of the log, or of the sensor that it has `alone`, means anything; units from some thousand of its samples.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub fn meaningless(recording: &dyn Recorded, alone: Option<Sensor>) -> io::Result<Vec<Finding>> {
    const SAMPLES: usize = 5000;
    let (part, jumps) = clock::without_jumps(recording)?;
    let recording = part.as_ref().map_or(recording, |part| part);
    let (measured, outliers) = without_outliers(recording)?;
    let every = recording.len().div_ceil(SAMPLES);
    let measured = measured.as_ref().map_or(recording, |measured| measured);
    let (mut index, mut thin) = (0_usize, Vec::new());
    measured.each(0..measured.len(), &mut |sample| {
        if index.is_multiple_of(every) {
            thin.push(*sample);
        }
        index += 1;
    })?;
    let thin =
        ImuRecording::new(thin).expect("every so manieth sample of a recording, thousands or all of them");
    let (mut findings, _) = gravity(&thin, &Rest::default())?;
    if !is_mixed_up(&findings) {
        findings.extend(mixed::loud(measured)?);
    }
    findings.extend(mixed::overflows(measured)?);
    findings.extend(jumps.into_iter().chain(clock::unlikely(recording.rate())).chain(outliers));
    findings.retain(|finding| finding.weight == Weight::Bad && !finding.is_of_zeros(alone));
    Ok(findings)
}

/// Whether columns or the unit of a sensor are doubted already.
fn is_mixed_up(findings: &[Finding]) -> bool {
    findings.iter().any(|finding| ["units", "columns"].contains(&finding.about))
}

/// What a range of a log reads by its medians.
struct Middles {
    /// Axes of the accelerometer, and the length of its vector, which turning does not change.
    accel: [f64; 3],
    force: f64,
    /// The same of the gyroscope.
    gyro: [f64; 3],
    turn: f64,
    /// What a thousandth of all of the gyroscope's axes exceeds.
    fast: f64,
}

fn middles(recording: &dyn Recorded, range: Range<usize>) -> io::Result<Middles> {
    let median = Column { count: range.len(), levels: &[Level::Median] };
    let fast = Column { count: 3 * recording.len(), levels: &[Level::Quantile(0.999)] };
    let found = levels(&[median, median, median, median, median, median, median, median, fast], |take| {
        let mut index = 0;
        recording.each(0..recording.len(), &mut |s| {
            if range.contains(&index) {
                s.accel.into_iter().chain(s.gyro).enumerate().for_each(|(axis, v)| take(axis, v));
                take(6, norm(s.accel));
                take(7, norm(s.gyro));
            }
            s.gyro.into_iter().for_each(|v| take(8, v.abs()));
            index += 1;
        })
    })?;
    let of = |first: usize| std::array::from_fn(|axis| found[first + axis][0]);
    Ok(Middles { accel: of(0), gyro: of(3), force: found[6][0], turn: found[7][0], fast: found[8][0] })
}

/// Share of its length below which the medians of a vector's axes are none of its directions.
const TURNED: f64 = 0.9;

fn gravity(recording: &dyn Recorded, rest: &Rest) -> io::Result<(Vec<Finding>, f64)> {
    let at_rest = rest.longest.len() as f64 * recording.rate().period() >= 1.0;
    let range = if at_rest { rest.longest.clone() } else { 0..recording.len() };
    let when = if at_rest { "at rest" } else { "by the median of the whole log" };
    let Middles { accel, gyro, force, turn, fast } = middles(recording, range.clone())?;
    let mut findings = Vec::new();
    let read = format!("the accelerometer reads {force:.3} m/s^2 {when}");
    let units = [
        ("g", 0.9..1.1, "read the log with --accel-unit g"),
        ("cm/s^2", 970.0..990.3, "read the log with --accel-unit cm/s^2"),
        ("mg", 900.0..1100.0, "read the log with --accel-unit mg"),
        (
            "m/s^2, not in g",
            94.0..98.5,
            "read the log with --accel-unit m/s^2; see whether the gyroscope's unit is another than the header's too",
        ),
    ];
    if let Some((unit, _, remedy)) = units.into_iter().find(|(_, forces, _)| forces.contains(&force)) {
        findings.push(Finding::bad("units", format!("{read}: it counts in {unit}"), remedy));
    } else if force > COUNTS {
        let mut is_whole = true;
        recording.each(range, &mut |s| is_whole &= s.accel.iter().all(|v| v.fract() == 0.0))?;
        let whole = if is_whole { ", all of them whole numbers" } else { "" };
        findings.push(Finding::bad(
            "units",
            format!("{read}: raw counts{whole}? Some {force:.0} of them would make a g"),
            "say what a count is: --sensor-scale NAME-RANGE (mpu6050-2g), or --accel-scale [m/s^2] and --gyro-scale [rad/s] by the data sheet",
        ));
        // The gyroscope's columns are counts then too.
        return Ok((findings, force));
    } else if let Some(turn) = [turn, turn.to_degrees()].into_iter().find(|t| (t - GRAVITY).abs() < 0.5)
        && force < 3.0
    {
        // A gyroscope at 9.8 was taken for one in degrees.
        findings.push(Finding::bad(
            "columns",
            format!("gravity stands in the gyroscope's columns ({turn:.2} of its unit) and none in the accelerometer's ({force:.2})"),
            "say which column is which: --columns",
        ));
    } else if force < 3.0 {
        findings.push(Finding::bad(
            "gravity",
            format!("{read}: gravity is missing"),
            "log the specific force, not the `linear acceleration` from which a phone or driver has taken gravity; or the columns are mixed up",
        ));
    } else if (force - GRAVITY).abs() > if at_rest { 0.3 } else { 1.5 } {
        findings.push(Finding::warning(
            "gravity",
            format!("{read}, {:.1} % off 9.81", 100.0 * (force / GRAVITY - 1.0)),
            "calibrate its scale and bias, or look at the unit",
        ));
    } else {
        let up = (0..3).max_by(|a, b| accel[*a].abs().total_cmp(&accel[*b].abs())).expect("three axes");
        let sign = if accel[up] < 0.0 { "-" } else { "" };
        let tilt = (accel[up].abs() / force).clamp(-1.0, 1.0).acos().to_degrees();
        let up = if norm(accel) < TURNED * force {
            "it is turned over and over".to_owned()
        } else {
            format!("up is {sign}{}, {tilt:.0} degrees off", AXES[up])
        };
        findings.push(Finding::note("gravity", format!("{read}; {up}")));
    }
    if fast > 35.0 {
        findings.push(Finding::bad(
            "units",
            format!("the gyroscope turns at {fast:.0} rad/s: it counts in degrees, or clips"),
            "read the log with --gyro-unit deg/s",
        ));
    } else if at_rest && norm(gyro) > 0.2 && !findings.iter().any(|finding| finding.about == "columns") {
        findings.push(Finding::warning(
            "bias",
            format!("the gyroscope reads {:.3} rad/s at rest", norm(gyro)),
            "a bias this large is rare: look at the unit (--gyro-unit deg/s), or at what turned",
        ));
    }
    Ok((findings, force))
}

/// Samples that tell a step.
const TELLING: usize = 20_000;

/// The step between two neighbouring values of an axis, where its values are whole numbers of one.
pub(crate) fn step(signal: &[f64]) -> Option<f64> {
    let mut values = signal.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let apart: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    // Of a converter coarser than the noise a log shows two or three values; a short log shows no more of any.
    if apart.is_empty() || (apart.len() < 3 && signal.len() < 1000) {
        return None;
    }
    // Printed decimals blur a step: the least distance that is not the blur of another.
    let least = stats::quantile(&apart, 0.05);
    let whole = |d: &&f64| {
        let count = *d / least;
        count > 0.5 && (count - count.round()).abs() < 0.05 * count.max(1.0).sqrt()
    };
    let share = apart.iter().filter(whole).count() as f64 / apart.len() as f64;
    // Of numbers without a step a tenth or so would pass by chance.
    (share > 0.95 && values.len() < signal.len() / 2).then_some(least)
}

/// Noise of a sample, in steps, of which rounding to steps (1 / sqrt(12) of one) makes half: sqrt(2 / 12).
const CONVERTER: f64 = 0.408;

/// Converters' steps of the six axes, where they have one.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(crate) fn steps_of(recording: &dyn Recorded) -> io::Result<[[Option<f64>; 3]; 2]> {
    let told = recording.piece(0..recording.len().min(TELLING))?;
    let step_of =
        |sensor: Sensor, axis: usize| step(&told.iter().map(|s| s.of(sensor)[axis]).collect::<Vec<_>>());
    Ok(Sensor::ALL.map(|sensor| [0, 1, 2].map(|axis| step_of(sensor, axis))))
}

fn steps(recording: &dyn Recorded) -> io::Result<Vec<Finding>> {
    let steps = steps_of(recording)?;
    if steps.iter().flatten().all(Option::is_none) {
        return Ok(Vec::new());
    }
    let noises = noises(recording)?;
    let mut findings = Vec::new();
    for ((sensor, steps), noises) in Sensor::ALL.into_iter().zip(steps).zip(noises) {
        let mut said = Vec::new();
        let mut coarse = false;
        for ((name, step), noise) in AXES.into_iter().zip(steps).zip(noises) {
            let Some(step) = step else { continue };
            coarse |= noise < CONVERTER * step;
            said.push(format!("{name} {step:.3e}"));
        }
        if said.is_empty() {
            continue;
        }
        let text = format!("{sensor} counts in steps of {} {}", said.join(", "), sensor.unit());
        findings.push(if coarse {
            Finding::warning(
                "steps",
                format!("{text}, so coarse that they make more than half of its noise"),
                "choose a smaller measuring range; `dpn allan` shows the converter's noise then, not the sensor's",
            )
        } else {
            Finding::note("steps", text)
        });
    }
    Ok(findings)
}

/// Noise of the axes of both sensors by the scatter of their second differences.
fn noises(recording: &dyn Recorded) -> io::Result<[[f64; 3]; 2]> {
    let count = recording.len().saturating_sub(2) as f64;
    // Moments in passes, as `stats::variance` has them: the sum, what rounding left of it, the squares.
    let pass = |of: &dyn Fn(f64, f64) -> f64, centre: &[[f64; 3]; 2]| {
        let mut sums = [[0.0; 3]; 2];
        let mut last: [Option<ImuSample>; 2] = [None; 2];
        recording.each(0..recording.len(), &mut |s| {
            if let [Some(a), Some(b)] = &last {
                for (k, sensor) in Sensor::ALL.into_iter().enumerate() {
                    let (a, b, c) = (a.of(sensor), b.of(sensor), s.of(sensor));
                    for axis in 0..3 {
                        sums[k][axis] += of((c[axis] - b[axis]) - (b[axis] - a[axis]), centre[k][axis]);
                    }
                }
            }
            last = [last[1], Some(*s)];
        })?;
        Ok::<_, io::Error>(sums.map(|sums| sums.map(|sum| sum / count)))
    };
    let rough = pass(&|v, _| v, &[[0.0; 3]; 2])?;
    let off = pass(&|v, rough| v - rough, &rough)?;
    let mean = [0, 1].map(|k| [0, 1, 2].map(|axis| rough[k][axis] + off[k][axis]));
    let squares = pass(&|v, mean| (v - mean) * (v - mean), &mean)?;
    Ok(squares.map(|axes| axes.map(|square| square.sqrt() / stats::difference_gain(2))))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::doctor::examine;
    use dpn_core::Stamp;
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};

    /// A still, level sensor at 200 Hz with noise of the ADIS16448, unquantised.
    pub(crate) fn level(seconds: usize) -> Vec<ImuSample> {
        let mut rng = Stream::new(2).named("doctor").rng();
        let mut noise = |sigma: f64| -> f64 {
            sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng)
        };
        (0..seconds as i64 * 200)
            .map(|i| ImuSample {
                t: Stamp::from_ns(i * 5_000_000),
                gyro: std::array::from_fn(|_| noise(0.0024)),
                accel: [noise(0.028), noise(0.028), 9.81 + noise(0.028)],
            })
            .collect()
    }

    fn said(samples: Vec<ImuSample>, about: &str) -> Vec<String> {
        let all = examine(&ImuRecording::new(samples).unwrap()).unwrap().findings;
        all.into_iter().filter(|f| f.about == about).map(|f| format!("{}: {}", f.weight, f.text)).collect()
    }

    #[test]
    fn units_columns_and_missing_gravity_are_told_apart() {
        let with = |change: fn(&mut ImuSample)| {
            let mut samples = level(20);
            samples.iter_mut().for_each(change);
            samples
        };
        assert!(
            said(level(20), "gravity")[0].ends_with("m/s^2 at rest; up is z, 0 degrees off"),
            "{:?}",
            said(level(20), "gravity")
        );
        assert!(
            said(with(|s| s.accel = s.accel.map(|v| v / 9.80665)), "units")[0].ends_with("it counts in g")
        );
        assert!(
            said(with(|s| s.accel = s.accel.map(|v| v * 101.97)), "units")[0].ends_with("it counts in mg")
        );
        let gal = said(with(|s| s.accel = s.accel.map(|v| v * 100.0)), "units");
        assert!(gal[0].ends_with("it counts in cm/s^2"), "{gal:?}");
        assert!(
            said(with(|s| std::mem::swap(&mut s.accel, &mut s.gyro)), "columns")[0]
                .starts_with("bad: gravity stands in the gyroscope's")
        );
        assert!(said(with(|s| s.accel[2] -= 9.81), "gravity")[0].ends_with("gravity is missing"));
        assert!(
            said(with(|s| s.accel = [-s.accel[2], s.accel[0], s.accel[1]]), "gravity")[0]
                .contains("up is -x")
        );
        // As the reader leaves it, who takes 9.81 for degrees.
        let swapped = with(|s| {
            std::mem::swap(&mut s.accel, &mut s.gyro);
            s.gyro = s.gyro.map(f64::to_radians);
        });
        let words = "gravity stands in the gyroscope's columns (9.81 of its unit)";
        assert!(said(swapped.clone(), "columns")[0].contains(words), "{:?}", said(swapped, "columns"));
        let quick =
            |samples: Vec<ImuSample>| meaningless(&ImuRecording::new(samples).unwrap(), None).unwrap();
        assert_eq!(quick(level(40)), []);
        assert_eq!(quick(with(|s| s.accel[2] -= 9.81))[0].about, "gravity");
        let spun = with(|s| s.gyro[1] = 90.0 * (s.t.ns() as f64 * 1e-9).sin());
        assert!(said(spun, "units")[0].contains("it counts in degrees"));
    }

    #[test]
    fn one_sample_beyond_any_imu_is_named_and_spoils_no_other_check() {
        let sound = examine(&ImuRecording::new(level(20)).unwrap()).unwrap();
        let mut samples = level(20);
        samples[1000].gyro[0] = 1000.0;
        samples[2000].accel[2] = 1e11;
        let recording = ImuRecording::new(samples).unwrap();
        let sick = examine(&recording).unwrap();
        assert_eq!(
            sick.findings[0].text,
            "gyro x reads 1.0000e3 rad/s at 5.000 s, more than any IMU measures; 2 sample(s) like it are left out of what follows"
        );
        let others = |e: &crate::doctor::Examination| e.findings.iter().map(|f| f.about).collect::<Vec<_>>();
        assert_eq!(others(&sick)[1..], others(&sound)[..]);
        assert_eq!(meaningless(&recording, None).unwrap().len(), 1);
        assert!(!sick.findings.iter().any(|f| f.text.contains("inf") || f.text.contains("NaN")), "{sick:?}");
    }

    #[test]
    fn raw_counts_are_asked_about_and_not_per_cent_off() {
        let counts = |whole: bool| {
            let mut samples = level(20);
            for s in &mut samples {
                s.accel = s.accel.map(|v| v / GRAVITY * 4096.0).map(|v| if whole { v.round() } else { v });
                s.gyro = s.gyro.map(|v| (v.to_degrees() * 16.4).round());
            }
            said(samples, "units")
        };
        let words = ": raw counts, all of them whole numbers? Some 4096 of them would make a g";
        assert!(
            counts(true)[0].starts_with("bad: ") && counts(true)[0].ends_with(words),
            "{:?}",
            counts(true)
        );
        assert!(counts(false)[0].contains(": raw counts? Some 4096 "), "{:?}", counts(false));
    }

    #[test]
    fn gravity_is_the_median_length_however_the_sensor_is_turned() {
        // Six positions, each for a while, none for most of it.
        let mut samples = level(60);
        for (i, s) in samples.iter_mut().enumerate() {
            let (axis, sign) = (i / 2000 % 3, if i / 6000 == 0 { 1.0 } else { -1.0 });
            s.accel = std::array::from_fn(|k| s.accel[(k + 2 - axis) % 3] * sign);
        }
        let found = gravity(&ImuRecording::new(samples).unwrap(), &Rest::default()).unwrap().0;
        assert!(found[0].text.starts_with("the accelerometer reads 9.81"), "{found:?}");
        assert!(found[0].text.ends_with("it is turned over and over") && !found[0].warns(), "{found:?}");
    }

    #[test]
    fn steps_are_coarse_only_where_rounding_makes_most_of_the_noise() {
        let stepped = |sigmas: f64| {
            let mut samples = level(20);
            let step = 0.028 / sigmas;
            samples.iter_mut().for_each(|s| s.accel = s.accel.map(|v| (v / step).round() * step));
            said(samples, "steps")
        };
        assert!(stepped(0.8)[0].starts_with("note: accel counts in steps of "), "{:?}", stepped(0.8));
        assert!(stepped(0.25)[0].ends_with("so coarse that they make more than half of its noise"));
    }

    #[test]
    fn a_converters_step_is_found_and_a_smooth_axis_has_none() {
        let mut rng = Stream::new(3).named("step").rng();
        let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
        let smooth: Vec<f64> = (0..8000).map(|_| noise()).collect();
        assert_eq!(step(&smooth), None);
        let count = 9.80665 / 1200.0;
        let counted: Vec<f64> = smooth.iter().map(|v| (v * 0.1 / count).round() * count).collect();
        assert!((step(&counted).unwrap() / count - 1.0).abs() < 1e-6);
        // Printed with seven decimals.
        let printed: Vec<f64> = counted.iter().map(|v| (v * 1e7).round() * 1e-7).collect();
        assert!((step(&printed).unwrap() / count - 1.0).abs() < 1e-3);
    }
}
