//! The gyro's bias from the directions of tracks alone, before any structure is known.
//!
//! With the right rotation between two frames, `n_k = f_k x R g_k` is orthogonal to the translation for every track `k`. So all
//! pairs' rotations, which one bias turns, and a translation direction for each pair are fitted to
//!
//! ```text
//! e_k = t . (f_k x R(b) g_k) / sqrt(|t x f_k|^2 + |t x R g_k|^2)        [rad], white noise of the tracks' deviation
//! R(b) = R exp(J (b - b0))
//! ```
//! by Gauss-Newton with Cauchy weights; a translation comes by consensus ([`super::translation`]), and its two unknowns are eliminated
//! pair by pair. A pair that only turned says nothing of `t` and still something of `R`. A prior
//! on the bias keeps what tracks do not show. Source: Kneip and Lynen 2013 (in eigenvalue form); weights and elimination are ours.

use super::robust;
use super::translation::Epipolar;
use dpn_core::geometry::so3::{exp, hat};
use dpn_core::geometry::sphere::tangent_basis;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, UnitQuaternion, Vector2, Vector3};
use rand::Rng;

/// Gauss-Newton steps; from a bias wrong by .1 rad/s over half a second ten arrive.
const STEPS: usize = 20;
/// Deviations, of the scale in force, beyond which a track is left out of a step.
const OUTLIER_DEVIATIONS: f64 = 4.0;
/// Deviations that the weights' scale begins with, and by what it falls from step to step.
const FIRST_SCALE: f64 = 8.0;
/// See [`FIRST_SCALE`].
const SCALE_DECAY: f64 = 0.7;
/// A step below this moves no rotation over a second by a thousandth of a pixel \[rad/s\].
const SMALL_STEP: f64 = 1e-6;

/// Two frames and the gyro's word on the rotation between them.
#[derive(Debug, Clone)]
pub(super) struct RotationPair {
    /// The gyro's rotation from the second camera's frame to the first's.
    pub first_from_second: UnitQuaternion<f64>,
    /// How the gyro's bias turns it, on the right \[rad per rad/s\].
    pub d_rotation_d_bias: Matrix3<f64>,
    /// Unit directions of the tracks that both frames see.
    pub shared: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// A bias and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BiasFit {
    /// Change of the gyro's bias \[rad/s\].
    pub change: Vector3<f64>,
    /// Largest standard deviation of the change in any direction \[rad/s\].
    pub std: f64,
}

/// The change of bias under which all pairs' tracks agree best with one motion a pair.
///
/// `noise` is a track's deviation \[rad\], `prior_std` that of the change before looking \[rad/s\].
pub(super) fn fit(
    pairs: &[RotationPair],
    prior: &Vector3<f64>,
    prior_std: f64,
    noise: f64,
    rng: &mut impl Rng,
) -> BiasFit {
    let mut translations: Vec<Option<Vector3<f64>>> = vec![None; pairs.len()];
    let mut change = *prior;
    let mut information = Matrix3::identity() / prior_std.powi(2);
    // Far from the answer every residual is large; the weights' scale comes down from what a wrong bias makes.
    let mut scale = FIRST_SCALE * noise;
    for _ in 0..STEPS {
        information = Matrix3::identity() / prior_std.powi(2);
        let mut gradient = (change - prior) / prior_std.powi(2);
        let mut reduced = Vec::with_capacity(pairs.len());
        for (pair, translation) in pairs.iter().zip(&mut translations) {
            let epipolar = pair.epipolar(&change);
            if scale > noise || translation.is_none() {
                *translation = epipolar.consensus(scale, rng).map(|t| epipolar.sharpen(t, scale));
            }
            let terms = translation.and_then(|t| Terms::of(pair, &epipolar, &t, scale, noise));
            if let Some(terms) = &terms {
                information += terms.information;
                gradient += terms.gradient;
            }
            reduced.push(terms);
        }
        let Some(factor) = information.cholesky() else { break };
        let step = -factor.solve(&gradient);
        change += step;
        for (translation, terms) in translations.iter_mut().zip(&reduced) {
            if let (Some(direction), Some(terms)) = (translation, terms) {
                *direction = terms.follow(direction, &step);
            }
        }
        let arrived = scale <= noise;
        scale = (SCALE_DECAY * scale).max(noise);
        if arrived && step.norm() < SMALL_STEP {
            break;
        }
    }
    let std =
        information.try_inverse().map_or(prior_std, |c| c.symmetric_eigenvalues().max().max(0.0).sqrt());
    BiasFit { change, std }
}

impl RotationPair {
    fn epipolar(&self, change: &Vector3<f64>) -> Epipolar<'_> {
        let rotation = self.first_from_second * exp(&(self.d_rotation_d_bias * change));
        Epipolar::new(rotation.to_rotation_matrix().matrix(), &self.shared)
    }
}

/// What one pair adds, its translation eliminated, and how the translation follows the bias.
struct Terms {
    information: Matrix3<f64>,
    gradient: Vector3<f64>,
    basis: Matrix3x2<f64>,
    h_bt: Matrix3x2<f64>,
    inverse_tt: Matrix2<f64>,
    g_t: Vector2<f64>,
}

impl Terms {
    fn of(
        pair: &RotationPair,
        epipolar: &Epipolar<'_>,
        direction: &Vector3<f64>,
        scale: f64,
        noise: f64,
    ) -> Option<Self> {
        let basis = tangent_basis(direction);
        let (mut h_bb, mut g_b) = (Matrix3::zeros(), Vector3::zeros());
        let (mut h_bt, mut h_tt, mut g_t) = (Matrix3x2::zeros(), Matrix2::zeros(), Vector2::zeros());
        for k in 0..pair.shared.len() {
            let (f, turned, normal) = epipolar.track(k);
            let sine = epipolar.sine(direction, k);
            let residual = direction.dot(normal) / sine;
            let deviations = residual / scale;
            if deviations.abs() > OUTLIER_DEVIATIONS {
                continue;
            }
            let weight = robust::weight(deviations * deviations) / (noise * noise);
            // R Exp(J d) g = R g - hat(R g) R J d, the change being small enough for J to hold at it.
            let d_turned_turn = -(direction.cross(f).transpose() * hat(turned));
            let by_bias = (d_turned_turn * epipolar.rotation() * pair.d_rotation_d_bias).transpose() / sine;
            let by_translation = basis.tr_mul(normal) / sine;
            h_bb += weight * by_bias * by_bias.transpose();
            h_bt += weight * by_bias * by_translation.transpose();
            h_tt += weight * by_translation * by_translation.transpose();
            g_b += weight * residual * by_bias;
            g_t += weight * residual * by_translation;
        }
        // Where the camera only turned there is nothing to eliminate: a weak prior (1 rad) on the direction says so.
        let inverse_tt = (h_tt + Matrix2::identity()).try_inverse()?;
        Some(Self {
            information: h_bb - h_bt * inverse_tt * h_bt.transpose(),
            gradient: g_b - h_bt * inverse_tt * g_t,
            basis,
            h_bt,
            inverse_tt,
            g_t,
        })
    }

    /// The direction after the bias's `step`.
    fn follow(&self, direction: &Vector3<f64>, step: &Vector3<f64>) -> Vector3<f64> {
        let turn = -self.inverse_tt * (self.g_t + self.h_bt.tr_mul(step));
        // A step over more than the plane's unit is no small one.
        let turn = turn / turn.norm().max(1.0);
        (direction + self.basis * turn).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};

    fn noisy(direction: Vector3<f64>, noise: f64, rng: &mut impl Rng) -> Vector3<f64> {
        let n = direction.normalize();
        let d: [f64; 2] = [StandardNormal.sample(rng), StandardNormal.sample(rng)];
        (n + tangent_basis(&n) * Vector2::from(d) * noise).normalize()
    }

    /// Pairs over `seconds`, each turning and moving, as seen by a gyro that is off by `bias`.
    fn pairs(bias: Vector3<f64>, speed: f64, noise: f64, outliers: usize, seed: u64) -> Vec<RotationPair> {
        let mut rng = Stream::new(seed).named("gyro-bias-test").rng();
        let seconds = 0.4;
        (0..8)
            .map(|_| {
                let mut vector = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0) * size);
                let truth = exp(&vector(0.3));
                let moved = vector(speed * seconds);
                let points: Vec<_> = (0..80)
                    .map(|_| {
                        let d = vector(0.6);
                        Vector3::new(d.x, d.y, 1.0) * (6.0 + 6.0 * d.z)
                    })
                    .collect();
                let strays: Vec<_> = (0..outliers).map(|_| vector(0.1)).collect();
                let shared = points
                    .iter()
                    .enumerate()
                    .map(|(k, p)| {
                        let second = truth.inverse() * (p - moved);
                        let off = if k < outliers { strays[k] } else { Vector3::zeros() };
                        (noisy(*p, noise, &mut rng), noisy(second.normalize() + off, noise, &mut rng))
                    })
                    .collect();
                // The gyro reads truth + bias, so that what it integrates to is turned by bias * seconds.
                RotationPair {
                    first_from_second: truth * exp(&(bias * seconds)),
                    d_rotation_d_bias: -seconds * Matrix3::identity(),
                    shared,
                }
            })
            .collect()
    }

    #[test]
    fn a_large_bias_is_found_among_outliers_also_when_the_camera_only_turns() {
        let bias = Vector3::new(0.08, -0.05, 0.06);
        for speed in [0.0, 0.2, 2.0] {
            for seed in 0..5 {
                let found = fit(
                    &pairs(bias, speed, 1.5e-3, 4, seed),
                    &Vector3::zeros(),
                    0.1,
                    1.5e-3,
                    &mut Stream::new(seed).rng(),
                );
                let error = (found.change - bias).norm();
                // Half a degree over a second of the eight it was off: a small translation passes for a turn.
                assert!(error < 0.012, "speed {speed}, seed {seed}: off by {error:.5} rad/s");
                assert!(found.std < 4e-3, "{:.5}", found.std);
            }
        }
    }

    #[test]
    fn without_pairs_the_prior_stays() {
        let prior = Vector3::new(0.01, 0.0, -0.02);
        let found = fit(&[], &prior, 0.1, 1e-3, &mut Stream::new(1).rng());
        assert!((found.change - prior).norm() < 1e-12);
        assert!((found.std - 0.1).abs() < 1e-12);
    }
}
