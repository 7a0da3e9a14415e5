//! Parallax after compensating rotation, and the direction of translation between two frames of known rotation.
//!
//! With `n_k = f_k x R g_k` the translation is orthogonal to all `n_k`: two tracks give `t = n_1 x n_2`. A consensus over random
//! pairs of tracks finds it among outliers, weighted least squares over those that agree sharpen it, and the tracks' depths,
//! `(t x R g) . n > 0` and `(t x f) . n > 0`, give its sign.

use super::robust;
use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use rand::Rng;

/// Random pairs of tracks: with one half of outliers, 64 pairs miss a clean one with probability 1e-8.
const TRIALS: usize = 64;
/// Deviations that an inlier may be off.
const INLIER_DEVIATIONS: f64 = 3.0;
/// Least squares taken, each with the weights of the one before.
const SHARPENINGS: usize = 5;
/// Smallest sine between a track and the translation that is divided by: nearer the focus of expansion noise rules.
const MIN_SINE: f64 = 0.05;

/// The median angle between two frames' directions after turning the second's \[rad\]; 0 without tracks.
pub(super) fn compensated_parallax(
    first_from_second: &UnitQuaternion<f64>,
    shared: &[(Vector3<f64>, Vector3<f64>)],
) -> f64 {
    robust::median(shared.iter().map(|(f, g)| f.cross(&(first_from_second * g)).norm().min(1.0).asin()))
}

/// Two frames' directions with the second's turned into the first: what is left is translation.
pub(super) struct Epipolar<'a> {
    shared: &'a [(Vector3<f64>, Vector3<f64>)],
    rotation: Matrix3<f64>,
    turned: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
}

impl<'a> Epipolar<'a> {
    /// Turns by `rotation`, the first frame from the second.
    pub(super) fn new(rotation: &Matrix3<f64>, shared: &'a [(Vector3<f64>, Vector3<f64>)]) -> Self {
        let turned: Vec<Vector3<f64>> = shared.iter().map(|(_, g)| rotation * g).collect();
        let normals = shared.iter().zip(&turned).map(|((f, _), g)| f.cross(g)).collect();
        Self { shared, rotation: *rotation, turned, normals }
    }

    /// The first frame from the second.
    pub(super) fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// Both directions and their normal, of one track: `f`, `R g`, `f x R g`.
    pub(super) fn track(&self, k: usize) -> (&Vector3<f64>, &Vector3<f64>, &Vector3<f64>) {
        (&self.shared[k].0, &self.turned[k], &self.normals[k])
    }

    /// The sine that scales a track's noise in `t . (f x R g)`.
    pub(super) fn sine(&self, translation: &Vector3<f64>, k: usize) -> f64 {
        let (f, turned, _) = self.track(k);
        let squared = translation.cross(f).norm_squared() + translation.cross(turned).norm_squared();
        squared.max(2.0 * MIN_SINE * MIN_SINE).sqrt()
    }

    /// By how much a track contradicts a translation \[rad\], with a sign.
    pub(super) fn error(&self, translation: &Vector3<f64>, k: usize) -> f64 {
        translation.dot(&self.normals[k]) / self.sine(translation, k)
    }

    /// Truncated squares instead of a count: of two directions with equal counts the closer one wins.
    fn loss(&self, translation: &Vector3<f64>, limit: f64) -> f64 {
        (0..self.shared.len()).map(|k| (self.error(translation, k) / limit).powi(2).min(1.0)).sum()
    }

    /// The best of directions that two random tracks give; its sign is open.
    pub(super) fn consensus(&self, noise: f64, rng: &mut impl Rng) -> Option<Vector3<f64>> {
        let count = self.shared.len();
        if count < 5 {
            return None;
        }
        let mut best: Option<(f64, Vector3<f64>)> = None;
        for _ in 0..TRIALS {
            let a = rng.random_range(0..count);
            let b = (a + rng.random_range(1..count)) % count;
            let Some(direction) = self.normals[a].cross(&self.normals[b]).try_normalize(1e-12) else {
                continue;
            };
            let lost = self.loss(&direction, INLIER_DEVIATIONS * noise);
            if best.as_ref().is_none_or(|(least, _)| lost < *least) {
                best = Some((lost, direction));
            }
        }
        best.map(|(_, direction)| direction)
    }

    /// The direction near `start` of least weighted squares.
    ///
    /// The squared sines in the weights keep noise, which is not the same in all directions of the normals, from drawing the direction to
    /// where it is least.
    pub(super) fn sharpen(&self, start: Vector3<f64>, noise: f64) -> Vector3<f64> {
        let limit = INLIER_DEVIATIONS * noise;
        let (mut direction, mut lost) = (start, self.loss(&start, limit));
        for _ in 0..SHARPENINGS {
            let moments: Matrix3<f64> = (0..self.shared.len())
                .map(|k| {
                    let sine = self.sine(&direction, k);
                    let error = direction.dot(&self.normals[k]) / sine;
                    let weight = robust::weight((error / noise).powi(2)) / (sine * sine);
                    weight * self.normals[k] * self.normals[k].transpose()
                })
                .sum();
            let eigen = SymmetricEigen::new(moments);
            let sharper = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
            let then = self.loss(&sharper, limit);
            if sharper.iter().any(|x| !x.is_finite()) || then >= lost {
                break;
            }
            (direction, lost) = (sharper, then);
        }
        direction
    }
}

/// A translation's direction and the tracks that agree with it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Translation {
    /// Unit vector to the second camera's centre, in the first's frame.
    pub direction: Vector3<f64>,
    /// Indices into the shared tracks, increasing.
    pub inliers: Vec<usize>,
}

/// The second camera's direction from the first; `None` with fewer than 5 tracks or without consensus.
///
/// `noise` is a track's deviation \[rad\].
pub(super) fn estimate(
    first_from_second: &UnitQuaternion<f64>,
    shared: &[(Vector3<f64>, Vector3<f64>)],
    noise: f64,
    rng: &mut impl Rng,
) -> Option<Translation> {
    let epipolar = Epipolar::new(first_from_second.to_rotation_matrix().matrix(), shared);
    let mut direction = epipolar.sharpen(epipolar.consensus(noise, rng)?, noise);
    let limit = INLIER_DEVIATIONS * noise;
    let mut inliers: Vec<usize> =
        (0..shared.len()).filter(|k| epipolar.error(&direction, *k).abs() < limit).collect();
    let before = |t: &Vector3<f64>, k: usize| {
        let (f, turned, normal) = epipolar.track(k);
        t.cross(turned).dot(normal) > 0.0 && t.cross(f).dot(normal) > 0.0
    };
    // Only tracks with some parallax have a side.
    let has_side = |k: usize| epipolar.track(k).2.norm() > limit;
    let ahead = inliers.iter().filter(|k| has_side(**k) && before(&direction, **k)).count();
    let behind = inliers.iter().filter(|k| has_side(**k) && before(&-direction, **k)).count();
    if behind > ahead {
        direction = -direction;
    }
    inliers.retain(|k| !has_side(*k) || before(&direction, *k));
    (inliers.len() >= 5).then_some(Translation { direction, inliers })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::geometry::so3::exp;
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};

    type Shared = Vec<(Vector3<f64>, Vector3<f64>)>;

    fn scene(moved: Vector3<f64>, noise: f64, outliers: usize, seed: u64) -> (UnitQuaternion<f64>, Shared) {
        let mut rng = Stream::new(seed).named("translation-test").rng();
        let rotation = exp(&Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3)));
        let shared = (0..100)
            .map(|k| {
                let p = Vector3::new(rng.random_range(-0.7..0.7), rng.random_range(-0.5..0.5), 1.0)
                    * rng.random_range(3.0..12.0);
                let mut perturb = |v: Vector3<f64>| {
                    let d = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
                    (v.normalize() + noise * d).normalize()
                };
                let second = rotation.inverse() * (p - moved);
                let off = if k < outliers { Vector3::new(0.1, 0.08, 0.0) } else { Vector3::zeros() };
                (perturb(p), perturb(second.normalize() + off))
            })
            .collect();
        (rotation, shared)
    }

    #[test]
    fn the_direction_is_found_with_its_sign_among_a_third_of_outliers() {
        for seed in 0..20 {
            let mut rng = Stream::new(seed).named("direction").rng();
            let direction: Vector3<f64> =
                Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)).normalize();
            let (rotation, shared) = scene(0.6 * direction, 1e-3, 33, seed);
            let found = estimate(&rotation, &shared, 1e-3, &mut rng).unwrap();
            let angle = found.direction.angle(&direction).to_degrees();
            assert!(angle < 3.0, "seed {seed}: off by {angle:.2} deg");
            assert!(
                found.inliers.iter().filter(|k| **k < 33).count() < 8,
                "outliers kept: {:?}",
                found.inliers
            );
            assert!(found.inliers.len() > 50);
        }
    }

    #[test]
    fn compensated_parallax_sees_translation_and_not_rotation() {
        let (rotation, turned_only) = scene(Vector3::zeros(), 1e-4, 0, 1);
        let (other, moved) = scene(Vector3::new(0.5, 0.0, 0.0), 1e-4, 0, 1);
        assert!(compensated_parallax(&rotation, &turned_only) < 5e-4);
        assert!(compensated_parallax(&other, &moved) > 0.03);
        assert_eq!(compensated_parallax(&rotation, &[]), 0.0);
    }

    #[test]
    fn the_same_stream_gives_the_same_bits() {
        let (rotation, shared) = scene(Vector3::new(0.4, 0.1, 0.2), 1e-3, 20, 3);
        let run = || estimate(&rotation, &shared, 1e-3, &mut Stream::new(1).rng());
        assert_eq!(run(), run());
    }
}
