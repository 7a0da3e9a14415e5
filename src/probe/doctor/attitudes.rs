//! Gravity's length at rest, however the sensor lies: where it changes with the attitude, a scale or a bias of the accelerometer is off.

use crate::finding::Finding;
use crate::phases::{Phase, Stretch};
use dpn_core::{GRAVITY, Recorded};
use nalgebra::Vector3;
use std::io;

/// Rests that lie as differently are two attitudes: the cosine of 15 degrees.
const ALIKE: f64 = 0.966;
/// Shortest rest \[s\]; its ends are left out \[s\].
const LEAST_S: f64 = 2.0;
const END_S: f64 = 0.5;
/// Spread of lengths from which one is off, as of a single one \[m/s^2\].
const SPREAD: f64 = 0.3;
/// What one scale or bias may leave over to be named \[m/s^2\], and how much more any other axis' must.
const LEFT: f64 = 0.06;
const WORSE: f64 = 3.0;

/// Means of the specific force, one an attitude.
fn attitudes(recording: &dyn Recorded, stretches: &[Stretch]) -> io::Result<Vec<Vector3<f64>>> {
    let start = recording.span()[0];
    let mut rests = stretches.iter().filter(|s| s.phase == Phase::Rest && s.length_s() >= LEAST_S).peekable();
    let mut found: Vec<(Vector3<f64>, f64)> = Vec::new();
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    let mut done = |sum: &mut Vector3<f64>, count: &mut f64| {
        let (sum, count) = (std::mem::take(sum), std::mem::take(count));
        if count < 8.0 {
            return;
        }
        match found.iter_mut().find(|(other, _)| other.normalize().dot(&sum.normalize()) > ALIKE) {
            Some((other, all)) => (*other, *all) = (*other + sum, *all + count),
            None => found.push((sum, count)),
        }
    };
    recording.each(0..recording.len(), &mut |s| {
        let t = s.t.seconds_since(start);
        while rests.next_if(|rest| t > rest.to_s - END_S).is_some() {
            done(&mut sum, &mut count);
        }
        if rests.peek().is_some_and(|rest| t >= rest.from_s + END_S) {
            sum += Vector3::from(s.accel);
            count += 1.0;
        }
    })?;
    done(&mut sum, &mut count);
    Ok(found.into_iter().map(|(sum, count)| sum / count).collect())
}

/// The factor, or else the offset, of an axis that brings lengths nearest to gravity's, and what it leaves over \[m/s^2\].
fn mended(forces: &[Vector3<f64>], axis: usize, is_scale: bool) -> (f64, f64) {
    let changed = |force: &Vector3<f64>, by: f64| {
        let mut force = *force;
        force[axis] = if is_scale { force[axis] * (1.0 + by) } else { force[axis] + by };
        force
    };
    let mut by = 0.0;
    for _ in 0..20 {
        let (mut normal, mut side) = (1e-12, 0.0);
        for force in forces {
            let now = changed(force, by);
            let slope = now[axis] / now.norm() * if is_scale { force[axis] } else { 1.0 };
            normal += slope * slope;
            side += slope * (GRAVITY - now.norm());
        }
        by += side / normal;
    }
    let squares: f64 = forces.iter().map(|force| (changed(force, by).norm() - GRAVITY).powi(2)).sum();
    (by, (squares / forces.len() as f64).sqrt())
}

/// What is to be said of lengths that change with the attitude.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn finding(recording: &dyn Recorded, stretches: &[Stretch]) -> io::Result<Option<Finding>> {
    let forces = attitudes(recording, stretches)?;
    let lengths = || forces.iter().map(Vector3::norm);
    let (low, high) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    if forces.len() < 2 || high - low < SPREAD || low < 0.5 * GRAVITY || high > 1.5 * GRAVITY {
        return Ok(None);
    }
    let [scales, offsets] =
        [true, false].map(|is_scale| [0, 1, 2].map(|axis| mended(&forces, axis, is_scale)));
    let left = |axis: usize| scales[axis].1.min(offsets[axis].1);
    let best = (0..3).min_by(|a, b| left(*a).total_cmp(&left(*b))).expect("three axes");
    let others = (0..3).filter(|axis| *axis != best).map(left).fold(f64::INFINITY, f64::min);
    let is_one = left(best) < LEFT && others > WORSE * left(best);
    let scale = format!("a scale {:.1} % off", 100.0 * (1.0 / (1.0 + scales[best].0) - 1.0));
    let offset = format!("a bias of {:.2} m/s^2", -offsets[best].0);
    let cause = match (scales[best].1 < LEFT, offsets[best].1 < LEFT) {
        _ if !is_one => ": scales or biases of the accelerometer are off".to_owned(),
        (true, true) => format!(": accel {} has {scale}, or {offset}", ["x", "y", "z"][best]),
        (is_scale, _) => {
            format!(": accel {} has {}", ["x", "y", "z"][best], if is_scale { scale } else { offset })
        }
    };
    let text = format!(
        "at rest the accelerometer reads from {low:.3} to {high:.3} m/s^2, as it lies, in {} attitudes{cause}",
        forces.len()
    );
    Ok(Some(Finding::warning(
        "scale",
        text,
        "calibrate each axis' scale and bias: let it lie on its six sides, and put what it reads there right",
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use crate::phases::phases;
    use dpn_core::ImuRecording;

    /// It lies on this many sides, six seconds each, turned over in a second between them.
    fn turned_over(sides: usize, change: fn(&mut [f64; 3])) -> Option<Finding> {
        let mut samples = level(7 * sides);
        for (i, s) in samples.iter_mut().enumerate() {
            let (side, t) = (i / 1400, (i % 1400) as f64 / 200.0 - 6.0);
            let [noise_x, noise_y, noise_z] = [s.accel[0], s.accel[1], s.accel[2] - 9.81];
            let angle = std::f64::consts::FRAC_PI_2 * t.max(0.0);
            let up = |side: usize| Vector3::ith(side % 3, if side % 6 < 3 { 9.81 } else { -9.81 });
            let force = up(side) * angle.cos() + up(side + 1) * angle.sin();
            s.accel = [force.x + noise_x, force.y + noise_y, force.z + noise_z];
            s.gyro[side % 3] += if t > 0.0 { 1.57 } else { 0.0 };
            change(&mut s.accel);
        }
        let recording = ImuRecording::new(samples).unwrap();
        finding(&recording, &phases(&recording).unwrap()).unwrap()
    }

    #[test]
    fn a_scale_or_a_bias_of_one_axis_is_named_where_the_sensor_lies_on_several_sides() {
        assert_eq!(turned_over(6, |_| {}), None);
        assert_eq!(turned_over(6, |a| a[0] += 0.1), None);
        let text = |sides, change| turned_over(sides, change).expect("a finding").text;
        let scale = text(6, |a| a[0] *= 1.05);
        assert!(scale.ends_with("in 6 attitudes: accel x has a scale 5.0 % off"), "{scale}");
        let bias = text(6, |a| a[1] -= 0.5);
        assert!(bias.contains(": accel y has a bias of -0.5"), "{bias}");
        let either = text(3, |a| a[2] *= 0.95);
        assert!(either.contains(": accel z has a scale -5.0 % off, or a bias of -0.4"), "{either}");
        let both = text(6, |a| (a[0], a[1]) = (a[0] * 1.05, a[1] * 0.96));
        assert!(both.ends_with(": scales or biases of the accelerometer are off"), "{both}");
    }
}
