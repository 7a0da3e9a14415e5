//! Numbers that are not what their columns say: a gyroscope of another unit, an axis that is another once more, readings that jump by themselves.

use crate::finding::Finding;
use dpn_core::signal::stats;
use dpn_core::{ImuSample, LOUD_GYRO, Recorded, Sensor, quiet_gyro_noise};
use std::io;
use std::ops::Range;

/// Axes of both sensors, the gyroscope's first.
const AXES: [&str; 6] = ["gyro x", "gyro y", "gyro z", "accel x", "accel y", "accel z"];
/// Share of the samples on which two axes that are one agree to the last digit.
const SAME: f64 = 0.99;
/// Single readings so many times as far off the line between their neighbours as 99 % are belong to no motion.
const JUMPS: f64 = 50.0;
/// Samples that tell how far that is.
const TELLING: usize = 100_000;

fn all(s: &ImuSample) -> [f64; 6] {
    let ([a, b, c], [d, e, f]) = (s.gyro, s.accel);
    [a, b, c, d, e, f]
}

/// A gyroscope that is louder at rest than any.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn loud(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let noise = quiet_gyro_noise(recording)?.filter(|noise| *noise > LOUD_GYRO);
    Ok(noise.map(|noise| {
        let text = format!(
            "the gyroscope's noise is {noise:.3} rad/s a sample while the accelerometer lies still: none is as loud, its numbers count in a smaller unit"
        );
        Finding::bad("units", text, "read the log with --gyro-unit deg/s, or say what one of the gyroscope's numbers is: --gyro-scale")
    }))
}

/// Axes that are another one, as it is or negated.
pub(super) fn copies(recording: &dyn Recorded) -> io::Result<Vec<Finding>> {
    let (mut same, mut count) = ([[[0_usize; 6]; 6]; 2], 0.0);
    recording.each(0..recording.len(), &mut |s| {
        let axes = all(s);
        for i in 0..6 {
            for k in 0..i {
                same[0][i][k] += usize::from(axes[i] == axes[k] && axes[i] != 0.0);
                same[1][i][k] += usize::from(axes[i] == -axes[k] && axes[i] != 0.0);
            }
        }
        count += 1.0;
    })?;
    let is = |sign: usize, (i, k): (usize, usize)| same[sign][i][k] as f64 > SAME * count;
    let pairs = (0..6).flat_map(|i| (0..i).map(move |k| (i, k)));
    let told = pairs.filter_map(|(i, k)| {
        let words = if is(0, (i, k)) { "once more" } else { "negated" };
        (is(0, (i, k)) || is(1, (i, k))).then(|| format!("{} is {} {words}", AXES[i], AXES[k]))
    });
    let told: Vec<String> = told.collect();
    let finding = || {
        Finding::bad(
            "columns",
            told.join(", "),
            "look at what wrote the columns, and say which are meant: --columns",
        )
    };
    Ok(if told.is_empty() { Vec::new() } else { vec![finding()] })
}

/// Most of an axis' range that its values go in one step and back is a counter that ran over; no motion leaves out what lies between.
const OVER: f64 = 0.8;
const NEAR: f64 = 0.3;
/// Fewest such steps.
const OVERS: usize = 3;

/// Axes that run over: beyond the largest value stands the smallest.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn overflows(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let (mut low, mut high) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
    recording.each(0..recording.len(), &mut |s| {
        for (axis, v) in all(s).into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(v), high[axis].max(v));
        }
    })?;
    let start = recording.span()[0];
    // Steps over little of the range, over some and over most of it, and where the first of these is. An axis of two values has none over little.
    let mut steps: [([usize; 3], f64); 6] = [([0; 3], f64::NAN); 6];
    recording.pairs(&mut |a, b| {
        let (before, now) = (all(a), all(b));
        for (axis, ([small, between, over], first_s)) in steps.iter_mut().enumerate() {
            let share = (now[axis] - before[axis]).abs() / (high[axis] - low[axis]);
            if share > OVER {
                *over += 1;
                *first_s = if first_s.is_nan() { b.t.seconds_since(start) } else { *first_s };
            } else if share > NEAR {
                *between += 1;
            } else if share > 0.0 {
                *small += 1;
            }
        }
    })?;
    let told: Vec<String> = (0..6)
        .filter(|axis| matches!(steps[*axis].0, [small, 0, over] if over >= OVERS && small >= OVERS))
        .map(|axis| {
            let ([_, _, over], first_s) = steps[axis];
            format!(
                "{} {over} time(s), first at {first_s:.2} s, between {:.4} and {:.4}",
                AXES[axis], low[axis], high[axis]
            )
        })
        .collect();
    Ok((!told.is_empty()).then(|| {
        Finding::bad(
            "overflow",
            format!("values jump over their whole range from one sample to the next and never over part of it: {}", told.join("; ")),
            "a counter runs over, or negative numbers were written without their sign: look at the driver's types, and choose a larger measuring range",
        )
    }))
}

/// Single readings that jump away from both neighbours, which go on as if nothing had been.
pub(super) fn jumps(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    if recording.len() < 100 {
        return Ok(None);
    }
    let start = recording.span()[0];
    // How far each axis of the middle one of five is off the line between its neighbours, and how far the others are from one another.
    let each = |rows: Range<usize>, take: &mut dyn FnMut(f64, [[f64; 2]; 6])| {
        let mut last = [(0.0, [0.0; 6]); 5];
        let mut index = 0;
        recording.each(rows, &mut |s| {
            last.rotate_left(1);
            last[4] = (s.t.seconds_since(start), all(s));
            index += 1;
            if index < 5 {
                return;
            }
            let of = std::array::from_fn(|k| {
                let [a, b, c, d, e] = last.map(|(_, axes)| axes[k]);
                [(c - 0.5 * (b + d)).abs(), (b - a).abs().max((d - b).abs()).max((e - d).abs())]
            });
            take(last[2].0, of);
        })
    };
    let mut offs: [Vec<f64>; 6] = Default::default();
    each(0..recording.len().min(TELLING), &mut |_, of| {
        offs.iter_mut().zip(of).for_each(|(offs, [off, _])| offs.push(off));
    })?;
    let usual = offs.map(|offs| stats::quantile(&offs, 0.99));
    let (mut found, mut first) = (0, None);
    each(0..recording.len(), &mut |t, of| {
        let is = |axis: &usize| {
            let ([off, calm], usual) = (of[*axis], usual[*axis]);
            usual > 0.0 && off > JUMPS * usual && calm < 0.2 * off
        };
        if let Some(axis) = (0..6).find(is) {
            found += 1;
            first.get_or_insert((t, axis, of[axis][0]));
        }
    })?;
    Ok(first.map(|(t, axis, off)| {
        let unit = if axis < 3 { Sensor::Gyro } else { Sensor::Accel }.unit();
        let text = format!(
            "{found} single reading(s) jump away from their neighbours, more than {JUMPS:.0} times as far as 99 % do: first {} by {off:.3} {unit} at {t:.3} s",
            AXES[axis]
        );
        Finding::warning("outliers", text, "look at the bus and the driver, and leave such samples out: no motion does so")
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;

    fn changed(change: impl Fn(usize, &mut ImuSample)) -> ImuRecording {
        let mut samples = level(20);
        samples.iter_mut().enumerate().for_each(|(i, s)| change(i, s));
        ImuRecording::new(samples).unwrap()
    }

    #[test]
    fn a_gyroscope_in_degrees_is_louder_than_any() {
        assert_eq!(loud(&changed(|_, _| {})).unwrap(), None);
        let text = loud(&changed(|_, s| s.gyro = s.gyro.map(f64::to_degrees))).unwrap().unwrap().text;
        assert!(text.starts_with("the gyroscope's noise is 0.1"), "{text}");
        // What shakes is none.
        let shaken = changed(|i, s| {
            let shake = (1.9 * i as f64).sin();
            (s.gyro[0], s.accel[0]) = (s.gyro[0] + 0.1 * shake, s.accel[0] + shake);
        });
        assert_eq!(loud(&shaken).unwrap(), None);
    }

    #[test]
    fn an_axis_that_is_another_one_is_named() {
        assert_eq!(copies(&changed(|_, _| {})).unwrap(), []);
        let found = copies(&changed(|_, s| (s.gyro[1], s.accel[2]) = (-s.gyro[0], s.accel[1]))).unwrap();
        assert_eq!(found[0].text, "gyro y is gyro x negated, accel z is accel y once more");
    }

    #[test]
    fn counters_that_run_over_and_signs_that_are_lost_are_named_and_shaking_is_not() {
        assert_eq!(overflows(&changed(|_, _| {})).unwrap(), None);
        let text =
            |change: fn(usize, &mut ImuSample)| overflows(&changed(change)).unwrap().expect("a finding").text;
        let turned = |i: usize| 1.4 * (0.01 * i as f64).sin();
        let over =
            text(|i, s| s.gyro[0] = (s.gyro[0] + 1.4 * (0.01 * i as f64).sin() + 1.0).rem_euclid(2.0) - 1.0);
        assert!(over.contains(": gyro x ") && !over.contains("gyro y"), "{over}");
        let unsigned = text(|_, s| s.accel[1] = s.accel[1].rem_euclid(65.536));
        assert!(unsigned.contains(": accel y "), "{unsigned}");
        assert_eq!(overflows(&changed(|i, s| s.gyro[0] += turned(i))).unwrap(), None);
        let shaken = |i: usize, s: &mut ImuSample| {
            s.accel[0] += if i.is_multiple_of(2) { 3.0 } else { -3.0 } * (0.02 * i as f64).sin();
        };
        assert_eq!(overflows(&changed(shaken)).unwrap(), None);
        let two = |i: usize, s: &mut ImuSample| s.gyro = [if i.is_multiple_of(5) { 0.1 } else { 0.0 }; 3];
        assert_eq!(overflows(&changed(two)).unwrap(), None);
    }

    #[test]
    fn readings_that_jump_by_themselves_are_counted_and_hits_are_none() {
        assert_eq!(jumps(&changed(|_, _| {})).unwrap(), None);
        let text = jumps(&changed(|i, s| s.accel[0] += if i % 997 == 500 { 60.0 } else { 0.0 }))
            .unwrap()
            .unwrap()
            .text;
        assert!(
            text.starts_with("4 single reading(s)")
                && text.contains("first accel x by 6")
                && text.ends_with("m/s^2 at 2.500 s"),
            "{text}"
        );
        // A hit rings on.
        let hit = changed(|i, s| {
            let t = i as f64 - 1000.0;
            s.accel[0] += if t < 0.0 { 0.0 } else { 30.0 * (-0.1 * t).exp() * (0.8 * t).sin() };
        });
        assert_eq!(jumps(&hit).unwrap(), None);
    }
}
