//! Gravity, units, swapped columns, clipped and dead axes, the converter's step.

use super::{Finding, Weight};
use crate::allan::rest::Rest;
use dpn_core::check::{CheckOptions, RecordingFault, check};
use dpn_core::signal::stats::{self, Ddof};
use dpn_core::{GRAVITY, ImuRecording, ImuSample, Sensor};

const AXES: [&str; 3] = ["x", "y", "z"];

pub(super) fn findings(recording: &ImuRecording, rest: &Rest) -> Vec<Finding> {
    let mut findings = gravity(recording, rest);
    for fault in check(recording, &CheckOptions::default()).faults {
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
    findings.extend(steps(recording));
    findings
}

/// Norm of a vector.
fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Median of each axis over the stretch at rest, or over all.
fn middle(samples: &[ImuSample], sensor: Sensor) -> [f64; 3] {
    std::array::from_fn(|axis| stats::median(&samples.iter().map(|s| s.of(sensor)[axis]).collect::<Vec<_>>()))
}

/// What is so wrong with gravity, columns or units that no figure of the log means anything; from some thousand of its samples.
pub fn meaningless(recording: &ImuRecording) -> Vec<Finding> {
    const SAMPLES: usize = 5000;
    let every = recording.len().div_ceil(SAMPLES);
    let thin = ImuRecording::new(recording.samples().iter().step_by(every).copied().collect())
        .expect("every so manieth sample of a recording, thousands or all of them");
    let mut findings = gravity(&thin, &Rest::default());
    findings.retain(|finding| finding.weight == Weight::Bad);
    findings
}

fn gravity(recording: &ImuRecording, rest: &Rest) -> Vec<Finding> {
    let at_rest = rest.longest.len() as f64 * recording.rate().period() >= 1.0;
    let samples = if at_rest { &recording.samples()[rest.longest.clone()] } else { recording.samples() };
    let when = if at_rest { "at rest" } else { "by the median of the whole log" };
    let (accel, gyro) = (middle(samples, Sensor::Accel), middle(samples, Sensor::Gyro));
    let (force, turn) = (norm(accel), norm(gyro));
    let mut findings = Vec::new();
    let read = format!("the accelerometer reads {force:.3} m/s^2 {when}");
    if (0.9..1.1).contains(&force) {
        findings.push(Finding::bad(
            "units",
            format!("{read}: it counts in g"),
            "read the log with --accel-unit g",
        ));
    } else if (900.0..1100.0).contains(&force) {
        findings.push(Finding::bad(
            "units",
            format!("{read}: it counts in mg"),
            "read the log with --accel-unit mg",
        ));
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
        findings.push(Finding::note(
            "gravity",
            format!("{read}; up is {sign}{}, {tilt:.0} degrees off", AXES[up]),
        ));
    }
    let fast = stats::quantile(&samples_of(recording, Sensor::Gyro), 0.999);
    if fast > 35.0 {
        findings.push(Finding::bad(
            "units",
            format!("the gyroscope turns at {fast:.0} rad/s: it counts in degrees, or clips"),
            "read the log with --gyro-unit deg/s",
        ));
    } else if at_rest && turn > 0.2 {
        findings.push(Finding::warning(
            "bias",
            format!("the gyroscope reads {turn:.3} rad/s at rest"),
            "a bias this large is rare: look at the unit (--gyro-unit deg/s), or at what turned",
        ));
    }
    findings
}

fn samples_of(recording: &ImuRecording, sensor: Sensor) -> Vec<f64> {
    recording.samples().iter().flat_map(|s| s.of(sensor)).map(f64::abs).collect()
}

/// The step between two neighbouring values of an axis, where its values are whole numbers of one.
pub(super) fn step(signal: &[f64]) -> Option<f64> {
    let mut values: Vec<f64> = signal.iter().take(20_000).copied().collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let apart: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    if apart.len() < 3 {
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
    (share > 0.95 && values.len() < signal.len().min(20_000) / 2).then_some(least)
}

fn steps(recording: &ImuRecording) -> Vec<Finding> {
    let mut findings = Vec::new();
    for sensor in Sensor::ALL {
        let mut said = Vec::new();
        let mut coarse = false;
        for (axis, name) in AXES.into_iter().enumerate() {
            let signal = recording.axis(sensor, axis);
            let Some(step) = step(&signal) else { continue };
            let noise =
                stats::deviation(&stats::differences(&signal, 2), Ddof::Zero) / stats::difference_gain(2);
            coarse |= noise < step;
            said.push(format!("{name} {step:.3e}"));
        }
        if said.is_empty() {
            continue;
        }
        let text = format!("{sensor} counts in steps of {} {}", said.join(", "), sensor.unit());
        findings.push(if coarse {
            Finding::warning(
                "steps",
                format!("{text}, coarser than its noise"),
                "choose a smaller measuring range; noise per sample below a step is the converter's, not the sensor's",
            )
        } else {
            Finding::note("steps", text)
        });
    }
    findings
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
        let all = examine(&ImuRecording::new(samples).unwrap()).findings;
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
        let quick = |samples: Vec<ImuSample>| meaningless(&ImuRecording::new(samples).unwrap());
        assert_eq!(quick(level(40)), []);
        assert_eq!(quick(with(|s| s.accel[2] -= 9.81))[0].about, "gravity");
        let spun = with(|s| s.gyro[1] = 90.0 * (s.t.ns() as f64 * 1e-9).sin());
        assert!(said(spun, "units")[0].contains("it counts in degrees"));
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
