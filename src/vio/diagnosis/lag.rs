//! How far apart camera and gyroscope make the same turns, where that is more than the camera's clock is looked for (`clock::REACH_S`).
//!
//! How fast a body turns is the same number in any axes: the rates' sizes, pair of frames by pair of frames, are correlated at shifts by whole frames, and a parabola through the
//! best three goes between frames. A mounting, a sign or a scale that is wrong moves no size, or all of them alike; a body that shakes evenly fits at more than one
//! shift, and says nothing.

use super::turn_map::Turn;
use crate::clock::REACH_S;
use dpn_core::signal::stats::{median_of, upper_median};

/// Looked for so far to both sides \[s\].
const FARTHEST_S: f64 = 5.0;
/// Fewest pairs that are shared.
const FEWEST: usize = 60;
/// Sizes of turns that are the same correlate by more, ...
const ALIKE: f64 = 0.75;
/// ... and leave this share of what is left anywhere else.
const BETTER: f64 = 0.7;
/// Sizes beyond so many times the median are as large: a turn that was followed badly.
const LARGEST: f64 = 4.0;
/// Shifts next to the best one are no others, but for none.
const NEXT: usize = 4;

/// How late the camera is \[s\], below zero where it is early; `None` where nothing so far away fits as nothing else does.
pub(super) fn lag(turns: &[Turn]) -> Option<f64> {
    let period = upper_median(turns.iter().map(|turn| turn.seconds))?;
    let body = sizes(turns.iter().map(|turn| turn.body.norm()).collect());
    let cam = sizes(turns.iter().map(|turn| turn.cam.norm()).collect());
    let most = ((FARTHEST_S / period) as usize).min(turns.len().saturating_sub(FEWEST));
    // From early to late: the camera's size so many pairs after the gyroscope's.
    let shifts = 2 * most + 1;
    let at = |k: usize| {
        let shift = k.abs_diff(most);
        let n = turns.len() - shift;
        if k < most { correlation(&body[shift..], &cam[..n]) } else { correlation(&body[..n], &cam[shift..]) }
    };
    let found: Vec<f64> = (0..shifts).map(at).collect();
    let best = (0..shifts).max_by(|a, b| found[*a].total_cmp(&found[*b]))?;
    let left = |k: usize| 1.0 - found[k] * found[k].abs();
    let elsewhere = (0..shifts).filter(|k| k.abs_diff(best) > NEXT || *k == most);
    let elsewhere = elsewhere.map(left).fold(f64::INFINITY, f64::min);
    if best == most || found[best] < ALIKE || left(best) > BETTER * elsewhere {
        return None;
    }
    let [before, after] = [best.checked_sub(1)?, best + 1].map(|k| found.get(k).copied());
    let (before, after) = before.zip(after)?;
    let between = 0.5 * (after - before) / (2.0 * found[best] - before - after).max(f64::MIN_POSITIVE);
    let late = (best as f64 - most as f64 + between.clamp(-0.5, 0.5)) * period;
    (late.abs() > REACH_S - 0.5 * period).then_some(late)
}

/// Held to what turns are usually, several times over.
fn sizes(sizes: Vec<f64>) -> Vec<f64> {
    let most = median_of(sizes.iter().copied()).map_or(0.0, |median| LARGEST * median);
    sizes.into_iter().map(|size| size.min(most)).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let [mean_a, mean_b] = [a, b].map(|v| v.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
    }
    ab / (aa * bb).sqrt().max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, UnitQuaternion, Vector3};

    /// A body that turns unevenly, and a camera mounted anyhow that is `late_s`.
    fn found(late_s: f64, shakes: bool) -> Option<f64> {
        let rate = |s: f64| match shakes {
            true => Vector3::z() * (9.0 * s).sin(),
            false => Vector3::new(
                (1.1 * s + 0.2 * s.sin()).sin(),
                (0.37 * s * s.sqrt()).cos(),
                (2.3 * s).sin() * (0.3 * s).cos(),
            ),
        };
        let mounting = UnitQuaternion::from_euler_angles(1.0, -0.4, 2.0);
        let turns = (0..200).map(|k| {
            let s = 6.0 + 0.1 * f64::from(k);
            let cam =
                mounting * rate(s - late_s) + Vector3::new(0.05, -0.03, 0.04) * f64::from(k % 7 - 3) / 3.0;
            Turn { body: rate(s), cam, information: Matrix3::identity(), seconds: 0.1, follows: true }
        });
        lag(&turns.collect::<Vec<_>>())
    }

    #[test]
    fn a_camera_far_off_the_gyroscopes_clock_is_found_however_it_is_mounted() {
        for late_s in [-2.0, -0.43, 0.4, 1.0, 3.3] {
            let off = found(late_s, false).unwrap() - late_s;
            assert!(off.abs() < 0.02, "{late_s}: {off}");
        }
        assert_eq!(found(0.0, false), None);
        assert_eq!(found(0.05, false), None);
        assert_eq!(found(0.4, true), None);
    }
}
