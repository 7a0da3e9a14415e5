//! How far single frames' stamps are off the instants at which they were taken, from turns.
//!
//! A frame stamped late by `e` turns a pair that ends with it by `w e` too little, `w` being the rate, and the pair that begins with it by as much too much. So what
//! is left of neighbouring pairs, `x` along the rate, goes to and fro, as nothing else makes it do. What the same points err by is alike in neighbours and in the pair after
//! them, and goes out of the difference:
//!
//! ```text
//! E[x_k (x_(k+1) - x_(k+2))] = -|w_k| |w_(k+1)| var(e)
//! ```

use super::turn_map::{Turn, TurnMap};
use nalgebra::UnitQuaternion;

/// Fewest neighbours that turn.
const FEWEST: usize = 30;
/// Slower turns say nothing of stamps \[rad/s\].
const SLOWEST: f64 = 0.1;
/// No stamp is believed to be off by more \[s\].
const WIDEST_S: f64 = 0.05;
/// An answer is so many deviations from none.
const SURE: f64 = 3.0;

/// The deviation of stamps \[s\]; `None` where none shows.
pub(super) fn jitter(turns: &[Turn], cam_from_body: &UnitQuaternion<f64>) -> Option<f64> {
    let map = TurnMap::of(turns, cam_from_body)?;
    let left: Vec<(f64, f64)> = turns.iter().map(|turn| along(turn, &map, cam_from_body)).collect();
    let rows = turns.windows(3).zip(left.windows(3)).filter(|(turns, left)| {
        turns[1..].iter().all(|turn| turn.follows) && left.iter().all(|(rate, _)| *rate > SLOWEST)
    });
    let products: Vec<(f64, f64)> =
        rows.map(|(_, left)| (left[0].0 * left[1].0, left[0].1 * (left[1].1 - left[2].1))).collect();
    if products.len() < FEWEST {
        return None;
    }
    let weight: f64 = products.iter().map(|(rates, _)| rates * rates).sum();
    let variance = -products.iter().map(|(rates, product)| rates * product).sum::<f64>() / weight;
    let off = |(rates, product): &(f64, f64)| (rates * (product + rates * variance)).powi(2);
    let std = products.iter().map(off).sum::<f64>().sqrt() / weight;
    (variance > SURE * std).then(|| variance.sqrt())
}

/// The rate of a turn \[rad/s\], and what is left of it along its axis \[rad\].
fn along(turn: &Turn, map: &TurnMap, cam_from_body: &UnitQuaternion<f64>) -> (f64, f64) {
    let expected = map.turned(turn, cam_from_body);
    let rate = expected.norm();
    let widest = WIDEST_S * rate;
    let left = expected.dot(&(turn.cam - map.bias - expected)) / rate.max(f64::MIN_POSITIVE) * turn.seconds;
    (rate, left.clamp(-widest, widest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::{Matrix3, Vector3};
    use rand::Rng;
    use rand_distr::StandardNormal;

    /// Pairs a tenth of a second long of a camera whose frames are stamped with a deviation of `jitter_s`, and whose gyroscope reads `scale` times the rate.
    fn found(jitter_s: f64, scale: f64) -> Option<f64> {
        let mut rng = Stream::new(4).named("jitter").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let off: Vec<f64> = (0..301).map(|_| jitter_s * normal()).collect();
        let turns = (0..300).map(|k| {
            let s = 0.1 * k as f64;
            let rate = Vector3::new((1.1 * s).sin(), 0.7 * (1.7 * s).cos(), 0.5 * (0.9 * s).sin());
            // What is seen is of the frames' own instants.
            let cam = rate * (0.1 + off[k + 1] - off[k]) / 0.1 + Vector3::from_fn(|_, _| 0.01 * normal());
            let body = scale * rate + Vector3::new(0.01, -0.02, 0.03);
            Turn { body, cam, information: Matrix3::identity() * 1e4, seconds: 0.1, follows: k > 0 }
        });
        jitter(&turns.collect::<Vec<_>>(), &UnitQuaternion::identity())
    }

    #[test]
    fn stamps_that_jitter_are_told_by_how_much_and_a_wrong_scale_is_none() {
        for jitter_s in [0.002, 0.005, 0.015] {
            let seen = found(jitter_s, 1.0).unwrap();
            assert!((seen / jitter_s - 1.0).abs() < 0.3, "{seen} s for {jitter_s}");
        }
        for scale in [1.0, 1.1] {
            let seen = found(0.0, scale).unwrap_or(0.0);
            assert!(seen < 0.001, "{seen} s at {scale}");
        }
    }
}
