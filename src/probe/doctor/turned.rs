//! Gravity's direction in the accelerometer's axes against what the gyroscope turns by: axes that are mirrored, swapped or turned, and signs that flip midway.
//!
//! Over two seconds the directions of the specific force, turned back by the gyroscope, stay together: they are gravity, and what else pushes averages out.
//! How far they spread (1 - |mean|^2 of unit vectors) is held against their spread in the sensor's own axes, for each of the 48 ways to read the gyroscope's
//! axes. Only seconds in which gravity turns by 10 degrees and more tell: a multirotor feels its thrust, which stays where it is, and a car stays level, so
//! of them nothing is said. Of hand-held recordings the axes as they are have .05 to .77 of that spread, any other reading .40 and more, and 1.6 times theirs.
//!
//! A delay between the sensors shows in it too, but not well enough: of sound recordings the spread is least at -.02 to -.05 s.

use crate::finding::Finding;
use dpn_core::{GRAVITY, Recorded};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::io;

/// Length of a window and of the steps in it \[s\].
pub(super) const WINDOW_S: f64 = 2.0;
const STEP_S: f64 = 0.02;
/// Spread of directions that tells, 10 degrees, and fewest and most windows that have it.
const TELLS: f64 = 0.03;
pub(super) const FEWEST: usize = 8;
const MOST: usize = 200;
/// Another reading leaves less than this of the spread in the sensor's axes, and the log's own more than twice of that.
pub(super) const EXPLAINED: f64 = 0.4;
pub(super) const WORSE: f64 = 2.0;
/// Readings that fit nearly as well are not told apart.
const ALIKE: f64 = 1.3;

/// Length of the steps between which a sign flips \[s\], and the largest turn that is none \[rad\].
const FLIP_STEP_S: f64 = 0.25;
const FLIP_TURN: f64 = 0.5;

/// Means over a step.
#[derive(Clone)]
pub(super) struct Step {
    pub t_s: f64,
    pub gyro: Vector3<f64>,
    pub force: Vector3<f64>,
}

fn steps(recording: &dyn Recorded, step_s: f64, take: &mut dyn FnMut(Step)) -> io::Result<()> {
    let start = recording.span()[0];
    let many = ((step_s * recording.rate().hz()).round() as usize).max(1);
    recording.pieces(0..recording.len(), many, &mut |chunk| {
        let mean = |of: fn(&dpn_core::ImuSample) -> [f64; 3]| {
            chunk.iter().map(|s| Vector3::from(of(s))).sum::<Vector3<f64>>() / chunk.len() as f64
        };
        let [first, last] = [&chunk[0], &chunk[chunk.len() - 1]].map(|s| s.t.seconds_since(start));
        if chunk.len() == many {
            take(Step { t_s: 0.5 * (first + last), gyro: mean(|s| s.gyro), force: mean(|s| s.accel) });
        }
        Ok(())
    })
}

/// The 48 ways in which axes may be permuted and negated, as they are first.
fn readings() -> Vec<Matrix3<f64>> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let sign = |bits: usize, axis: usize| if bits >> axis & 1 == 0 { 1.0 } else { -1.0 };
    let reading = |order: [usize; 3], bits: usize| {
        Matrix3::from_fn(|row, column| if order[row] == column { sign(bits, row) } else { 0.0 })
    };
    orders.into_iter().flat_map(|order| (0..8).map(move |bits| reading(order, bits))).collect()
}

/// Directions of the specific force, turned back to the window's first by what `turn` makes of the gyroscope's.
pub(super) fn directions<'a>(
    window: &'a [Step],
    turn: impl Fn(Vector3<f64>) -> Vector3<f64> + 'a,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let mut first_from_now = UnitQuaternion::identity();
    window.iter().enumerate().map(move |(i, step)| {
        if let Some(before) = i.checked_sub(1).map(|i| &window[i]) {
            let rate = turn(0.5 * (before.gyro + step.gyro));
            first_from_now *= UnitQuaternion::from_scaled_axis(rate * (step.t_s - before.t_s));
        }
        first_from_now * step.force.normalize()
    })
}

/// How far they spread.
pub(super) fn spread(window: &[Step], turn: impl Fn(Vector3<f64>) -> Vector3<f64>) -> f64 {
    let sum: Vector3<f64> = directions(window, turn).sum();
    1.0 - (sum / window.len() as f64).norm_squared()
}

/// How far directions spread in the sensor's own axes.
pub(super) fn still(window: &[Step]) -> f64 {
    spread(window, |_| Vector3::zeros())
}

/// Windows in which gravity turns enough to tell, none where these are few.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn windows(recording: &dyn Recorded) -> io::Result<Vec<Vec<Step>>> {
    let many = (WINDOW_S / STEP_S).round().min(WINDOW_S * recording.rate().hz()) as usize;
    let (mut window, mut found) = (Vec::with_capacity(many), Vec::new());
    if many < 20 {
        return Ok(found);
    }
    steps(recording, STEP_S, &mut |step| {
        window.push(step);
        if window.len() < many {
            return;
        }
        let is_whole = window[many - 1].t_s - window[0].t_s < 1.2 * WINDOW_S;
        if is_whole && found.len() < MOST && still(&window) > TELLS {
            found.push(window.clone());
        }
        window.clear();
    })?;
    if found.len() < FEWEST {
        found.clear();
    }
    Ok(found)
}

/// What is to be said of the gyroscope's axes, from [`windows`].
pub(super) fn axes(windows: &[Vec<Step>]) -> Option<Finding> {
    let own: f64 = windows.iter().map(|window| still(window)).sum();
    if windows.is_empty() || !own.is_finite() {
        return None;
    }
    let readings = readings();
    let left = |reading: &Matrix3<f64>| {
        windows.iter().map(|window| spread(window, |rate| reading * rate)).sum::<f64>()
    };
    let shares: Vec<f64> = readings.iter().map(|reading| left(reading) / own).collect();
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|a, b| shares[*a].total_cmp(&shares[*b]));
    let best = order[0];
    if !(shares[best] < EXPLAINED && shares[0] > WORSE * shares[best]) {
        return None;
    }
    let is_alone = shares[order[1]] > ALIKE * shares[best];
    let map = &readings[best];
    let axis = |row: usize| {
        let column = (0..3).find(|column| map[(row, *column)] != 0.0).expect("a permutation");
        format!("{}{}", if map[(row, column)] < 0.0 { "-" } else { "" }, ["x", "y", "z"][column])
    };
    let as_read = if is_alone {
        format!("; they do with the gyroscope's {} {} {} in place of x y z", axis(0), axis(1), axis(2))
    } else {
        "; with other axes of the gyroscope they do".to_owned()
    };
    let (words, remedy) = if map.determinant() < 0.0 {
        (
            "mirrored",
            "one sign of the gyroscope is wrong, or two of its axes are swapped: look at the driver, and put the columns right (--columns orders them)",
        )
    } else {
        (
            "turned",
            "look at the driver: the gyroscope's axes are other ones than the accelerometer's (--columns orders them), or a sign of the accelerometer is wrong",
        )
    };
    let text = format!(
        "gravity does not turn as the gyroscope says, in {} stretches of {WINDOW_S:.0} s{as_read}: one sensor's axes are {words} against the other's",
        windows.len()
    );
    Some(Finding::bad("axes", text, remedy))
}

/// Gravity that turns over between two quarters of a second while the gyroscope does not turn.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn flips(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let (mut last, mut count, mut first): (Vec<Step>, usize, Option<f64>) = (Vec::new(), 0, None);
    steps(recording, FLIP_STEP_S, &mut |step| {
        last.push(step);
        if last.len() < 5 {
            return;
        }
        let is_gravity = |s: &Step| (0.7..1.3).contains(&(s.force.norm() / GRAVITY));
        let between = |a: &Step, b: &Step| a.force.normalize().dot(&b.force.normalize());
        let [a, b, c, d, e] = &last[..] else { unreachable!("five") };
        let turned: f64 = [(a, b), (b, c), (c, d), (d, e)]
            .iter()
            .map(|(s, next)| 0.5 * (s.gyro + next.gyro).norm() * (next.t_s - s.t_s))
            .sum();
        let stays = between(a, b) > 0.9 && between(d, e) > 0.9;
        if stays && between(b, d) < -0.9 && [a, b, d, e].into_iter().all(is_gravity) && turned < FLIP_TURN {
            count += 1;
            first.get_or_insert(c.t_s);
            last.clear();
        } else {
            last.remove(0);
        }
    })?;
    Ok(first.map(|at| {
        let text = format!(
            "gravity turns over {count} time(s), first at {at:.1} s, while the gyroscope does not turn: the accelerometer's signs change there"
        );
        Finding::bad("axes", text, "cut the log there (--from, --to); look for two recordings in one file, or for a driver that began anew with other axes")
    }))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, ImuSample};

    /// A hand that turns a sensor about all axes, and pushes it.
    pub(crate) fn waved(change: impl Fn(&mut ImuSample)) -> ImuRecording {
        let mut samples = level(40);
        let mut body_from_world = UnitQuaternion::identity();
        for sample in &mut samples {
            let t = sample.t.ns() as f64 * 1e-9;
            let gyro =
                Vector3::new(1.1 * (1.3 * t).sin(), 0.9 * (0.8 * t).cos(), 0.7 * (0.5 * t + 1.0).sin());
            body_from_world = UnitQuaternion::from_scaled_axis(-0.005 * gyro) * body_from_world;
            let push = Vector3::new((5.0 * t).sin(), (4.0 * t).cos(), (7.0 * t).sin());
            let force = body_from_world * Vector3::new(0.0, 0.0, GRAVITY) + push;
            (0..3).for_each(|axis| {
                sample.gyro[axis] += gyro[axis];
                sample.accel[axis] += force[axis] - if axis == 2 { 9.81 } else { 0.0 };
            });
            change(sample);
        }
        ImuRecording::new(samples).unwrap()
    }

    #[test]
    fn axes_of_a_gyroscope_that_are_others_are_named_and_right_ones_are_not() {
        let axes = |recording: &ImuRecording| axes(&windows(recording).unwrap());
        assert_eq!(axes(&waved(|_| {})), None);
        assert_eq!(axes(&ImuRecording::new(level(40)).unwrap()), None);
        // Turned as a whole, or upside down, both are right.
        assert_eq!(axes(&waved(|s| s.accel = s.accel.map(|v| -v))), None);
        let text = |change: fn(&mut ImuSample)| axes(&waved(change)).expect("a finding").text;
        let mirrored = text(|s| s.gyro[1] = -s.gyro[1]);
        assert!(
            mirrored.contains("with the gyroscope's x -y z in place of x y z")
                && mirrored.contains("mirrored"),
            "{mirrored}"
        );
        let swapped = text(|s| s.gyro.swap(0, 2));
        assert!(swapped.contains("the gyroscope's z y x ") && swapped.contains("mirrored"), "{swapped}");
        let turned = text(|s| s.gyro = [s.gyro[1], -s.gyro[0], s.gyro[2]]);
        assert!(turned.contains("the gyroscope's -y x z ") && turned.contains("turned"), "{turned}");
    }

    #[test]
    fn gravity_that_flips_midway_is_a_finding_and_a_sensor_that_is_turned_over_is_none() {
        assert_eq!(flips(&waved(|_| {})).unwrap(), None);
        let flipped = |from: usize| {
            let mut samples = level(20);
            samples.iter_mut().skip(from).for_each(|s| s.accel = s.accel.map(|v| -v));
            flips(&ImuRecording::new(samples).unwrap()).unwrap()
        };
        assert_eq!(flipped(4000), None);
        let text = flipped(1234).unwrap().text;
        assert!(text.starts_with("gravity turns over 1 time(s), first at 6."), "{text}");
        let over = waved(|s| {
            let t = s.t.ns() as f64 * 1e-9;
            s.gyro =
                if (10.0..10.5).contains(&t) { [2.0 * std::f64::consts::PI, 0.0, 0.0] } else { [0.0; 3] };
            s.accel = [0.0, 0.0, if t < 10.25 { 9.81 } else { -9.81 }];
        });
        assert_eq!(flips(&over).unwrap(), None);
    }
}
