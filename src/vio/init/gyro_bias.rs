//! The gyro's bias from the directions of tracks alone, before any structure is known.
//!
//! With the right rotation between two frames, `n_k = f_k x R g_k` is orthogonal to the translation for every track `k`. So all
//! pairs' rotations, which one bias turns, and a translation direction for each pair are fitted to
//!
//! ```text
//! e_k = t . (f_k x R(b) g_k) / sqrt(|t x f_k|^2 + |t x R g_k|^2)        [rad], white noise of the tracks' deviation
//! R(b) = R exp(J (b - b0))
//! ```
//! by Gauss-Newton with Cauchy weights; a translation starts as the eigenvector of `sum w n n^T` with the smallest eigenvalue, and
//! its two unknowns are eliminated pair by pair. A pair that only turned says nothing of `t` and still something of `R`. A prior
//! on the bias keeps what tracks do not show. Source: Kneip and Lynen 2013 (eigenvalue form), with the noise's own weights.

use super::robust;
use dpn_core::geometry::so3::{exp, hat};
use dpn_core::geometry::sphere::tangent_basis;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, SymmetricEigen, UnitQuaternion, Vector2, Vector3};

/// Gauss-Newton steps; from a bias wrong by .1 rad/s over half a second six arrive.
const STEPS: usize = 12;
/// A step below this moves no rotation over a second by a thousandth of a pixel \[rad/s\].
const SMALL_STEP: f64 = 1e-6;
/// Smallest sine between a track and the translation that is divided by: nearer the focus of expansion noise rules.
const MIN_SINE: f64 = 0.05;

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
pub(super) fn fit(pairs: &[RotationPair], prior: &Vector3<f64>, prior_std: f64, noise: f64) -> BiasFit {
    let mut change = Vector3::zeros();
    let mut information = Matrix3::identity() / prior_std.powi(2);
    // Far from the answer every residual is large; the weights' scale comes down from what a wrong bias makes.
    let mut scale = 8.0 * noise;
    for _ in 0..STEPS {
        information = Matrix3::identity() / prior_std.powi(2);
        let mut gradient = (change - prior) / prior_std.powi(2);
        for pair in pairs {
            let terms = pair_terms(pair, &change, scale, noise);
            information += terms.0;
            gradient += terms.1;
        }
        let Some(factor) = information.cholesky() else { break };
        let step = factor.solve(&gradient);
        change -= step;
        let arrived = scale <= noise;
        scale = (0.5 * scale).max(noise);
        if arrived && step.norm() < SMALL_STEP {
            break;
        }
    }
    let std =
        information.try_inverse().map_or(prior_std, |c| c.symmetric_eigenvalues().max().max(0.0).sqrt());
    BiasFit { change, std }
}

/// Information on the bias and gradient that one pair adds, its translation eliminated.
fn pair_terms(
    pair: &RotationPair,
    change: &Vector3<f64>,
    scale: f64,
    noise: f64,
) -> (Matrix3<f64>, Vector3<f64>) {
    let d_rotation = pair.d_rotation_d_bias;
    let rotation = (pair.first_from_second * exp(&(d_rotation * change))).to_rotation_matrix().into_inner();
    let Some(translation) = translation_direction(&rotation, &pair.shared, scale) else {
        return (Matrix3::zeros(), Vector3::zeros());
    };
    let basis = tangent_basis(&translation);
    let (mut h_bb, mut g_b) = (Matrix3::zeros(), Vector3::zeros());
    let (mut h_bt, mut h_tt, mut g_t) = (Matrix3x2::zeros(), Matrix2::zeros(), Vector2::zeros());
    for (f, g) in &pair.shared {
        let turned = rotation * g;
        let (t_f, t_g) = (translation.cross(f), translation.cross(&turned));
        let sine = (t_f.norm_squared() + t_g.norm_squared()).max(2.0 * MIN_SINE * MIN_SINE).sqrt();
        let normal = f.cross(&turned);
        let residual = translation.dot(&normal) / sine;
        let weight = robust::weight((residual / scale).powi(2)) / (noise * noise);
        // The tangent direction only: J d turns `g`, and J of the bias's change is near the identity over small angles.
        let by_bias = -(t_f.transpose() * rotation * hat(g) * d_rotation).transpose() / sine;
        let by_translation = basis.tr_mul(&normal) / sine;
        h_bb += weight * by_bias * by_bias.transpose();
        h_bt += weight * by_bias * by_translation.transpose();
        h_tt += weight * by_translation * by_translation.transpose();
        g_b += weight * residual * by_bias;
        g_t += weight * residual * by_translation;
    }
    // Where the camera only turned there is nothing to eliminate: a weak prior (1 rad) on the direction says so.
    let Some(inverse) = (h_tt + Matrix2::identity()).try_inverse() else {
        return (Matrix3::zeros(), Vector3::zeros());
    };
    (h_bb - h_bt * inverse * h_bt.transpose(), g_b - h_bt * inverse * g_t)
}

/// The direction most orthogonal to all `f x R g`, weighted; its sign is open.
fn translation_direction(
    rotation: &Matrix3<f64>,
    shared: &[(Vector3<f64>, Vector3<f64>)],
    scale: f64,
) -> Option<Vector3<f64>> {
    if shared.len() < 5 {
        return None;
    }
    let normals: Vec<_> = shared.iter().map(|(f, g)| f.cross(&(rotation * g))).collect();
    let mut weights = vec![1.0; normals.len()];
    let mut direction = Vector3::zeros();
    for _ in 0..4 {
        let moments: Matrix3<f64> = normals.iter().zip(&weights).map(|(n, w)| *w * n * n.transpose()).sum();
        let eigen = SymmetricEigen::new(moments);
        direction = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        for (weight, normal) in weights.iter_mut().zip(&normals) {
            *weight = robust::weight((direction.dot(normal) / scale).powi(2));
        }
    }
    direction.iter().all(|x| x.is_finite()).then_some(direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand::Rng;
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
                let shared = points
                    .iter()
                    .enumerate()
                    .map(|(k, p)| {
                        let second = truth.inverse() * (p - moved);
                        let off = if k < outliers { Vector3::new(0.1, -0.1, 0.0) } else { Vector3::zeros() };
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
    fn a_large_bias_is_found_within_its_own_deviation_also_when_the_camera_only_turns() {
        let bias = Vector3::new(0.08, -0.05, 0.06);
        for speed in [0.0, 0.2, 2.0] {
            for seed in 0..5 {
                let found = fit(&pairs(bias, speed, 1.5e-3, 4, seed), &Vector3::zeros(), 0.1, 1.5e-3);
                let error = (found.change - bias).norm();
                assert!(error < 8e-3, "speed {speed}, seed {seed}: off by {error:.5} rad/s");
                assert!(found.std < 4e-3, "{:.5}", found.std);
            }
        }
    }

    #[test]
    fn without_pairs_the_prior_stays() {
        let prior = Vector3::new(0.01, 0.0, -0.02);
        let found = fit(&[], &prior, 0.1, 1e-3);
        assert!((found.change - prior).norm() < 1e-12);
        assert!((found.std - 0.1).abs() < 1e-12);
    }
}
