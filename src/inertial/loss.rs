//! Huber's loss on products of increments over spans of samples.
//!
//! Increments `Exp(rate dt)` are multiplied pair by pair, a tree; over some of its levels `r = Log(turn^-1 product)` is held against the true turn. Down the tree goes the gradient by a
//! small rotation on the right: a product's goes to its right factor as it is and to its left one turned by the right one.

use crate::course::Course;
use dpn_core::geometry::so3;
use nalgebra::{UnitQuaternion, Vector3};

/// Mean loss of `rates` at the samples from `from` on over spans of `spans` samples, powers of two of which the longest divides the number of rates, in squares of `huber` \[rad\], and its
/// gradient by them \[s/rad\]. Spans without truth do not count.
pub(crate) fn loss(
    course: &Course,
    from: usize,
    rates: &[Vector3<f64>],
    spans: &[usize],
    huber: f64,
) -> (f64, Vec<Vector3<f64>>) {
    let whole = spans.iter().copied().max().expect("a checked configuration has spans");
    let levels = whole.ilog2() as usize;
    let mut by_rate = vec![Vector3::zeros(); rates.len()];
    let (mut sum, mut count) = (0.0, 0_usize);
    for (t, (rates, by_rate)) in rates.chunks_exact(whole).zip(by_rate.chunks_exact_mut(whole)).enumerate() {
        let first = from + t * whole;
        let step = |i: usize| course.step_s[first + i];
        let mut tree: Vec<Vec<UnitQuaternion<f64>>> =
            vec![rates.iter().enumerate().map(|(i, rate)| so3::exp(&(rate * step(i)))).collect()];
        for level in 0..levels {
            let pairs = tree[level].chunks_exact(2).map(|pair| pair[0] * pair[1]).collect();
            tree.push(pairs);
        }
        let mut by_node = vec![Vector3::zeros()];
        for level in (0..=levels).rev() {
            let span = 1 << level;
            if spans.contains(&span) {
                for (n, (product, by)) in tree[level].iter().zip(&mut by_node).enumerate() {
                    let Some(turn) = course.turn(first + n * span, first + (n + 1) * span) else { continue };
                    let r = so3::log(&(turn.inverse() * product));
                    let size = (r / huber).map(f64::abs);
                    sum += size.map(|s| if s < 1.0 { 0.5 * s * s } else { s - 0.5 }).sum();
                    count += 3;
                    let pull = (r / huber).map(|s| s.clamp(-1.0, 1.0)) / huber;
                    *by += so3::right_jacobian_inverse(&r).transpose() * pull;
                }
            }
            if level > 0 {
                let factors = tree[level - 1].chunks_exact(2);
                by_node = by_node.iter().zip(factors).flat_map(|(by, pair)| [pair[1] * by, *by]).collect();
            }
        }
        for (i, (by, node)) in by_rate.iter_mut().zip(&by_node).enumerate() {
            *by = step(i) * so3::right_jacobian(&(rates[i] * step(i))).transpose() * node;
        }
    }
    let mean = 1.0 / count.max(1) as f64;
    by_rate.iter_mut().for_each(|by| *by *= mean);
    (sum * mean, by_rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;
    use nalgebra::{DVector, Matrix3, RowDVector};

    #[test]
    fn the_gradient_is_the_losss_derivative_on_both_sides_of_hubers_corner() {
        let course = simulated(2.0, Matrix3::identity(), Vector3::new(0.1, -0.2, 0.05), 0.3);
        for huber in [0.002, 0.2] {
            let (rates, spans) = (&course.gyro[8..72], [16, 32]);
            let (value, by) = loss(&course, 8, rates, &spans, huber);
            assert!(value > 0.0);
            let flat = RowDVector::from_iterator(3 * by.len(), by.iter().flat_map(|b| b.iter().copied()));
            let scale = flat.amax();
            dpn_testing::check_jacobian("loss", &(flat / scale), 1e-5, |d| {
                let moved: Vec<_> =
                    rates.iter().enumerate().map(|(i, r)| r + d.fixed_rows::<3>(3 * i)).collect();
                DVector::from_element(1, loss(&course, 8, &moved, &spans, huber).0 / scale)
            });
        }
    }
}
