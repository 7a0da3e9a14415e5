//! The gyroscope's bias as the tracks see it, so that its rotations are worth something before anybody else knows it.
//!
//! Between two frames handed over the gyroscope measured a turn `R`; the true one is `Exp(d) R` with `d = b dt`. What the tracks say of `d`
//! (`two_view`) goes into a filter of the bias, which walks. The estimator has a better bias
//! later, from accelerations as well; the front-end has its own so that tracks are the same whoever listens.

use super::ransac::Pair;
use super::two_view::TwoView;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Deviation of the bias before anything is known \[rad/s\].
const PRIOR_STD: f64 = 0.1;
/// Walk of the bias \[rad/s/sqrt(s)\]: a hundred times a real one's, for what else is wrong with a rotation (an axis, a clock).
const WALK: f64 = 2e-3;
/// Deviation of `e` \[px at the image's centre\].
const TRACK_STD_PX: f64 = 0.5;
/// Fewer tracks say nothing.
const FEWEST: usize = 15;
/// Frames farther apart than this say nothing \[s\].
const LONGEST_S: f64 = 1.0;
/// A bias beyond this is a mistake \[rad/s\].
const LARGEST: f64 = 1.0;

/// The bias in the camera's frame \[rad/s\], with its information.
#[derive(Debug, Clone, Copy)]
pub(super) struct GyroBias {
    bias: Vector3<f64>,
    information: Matrix3<f64>,
}

impl Default for GyroBias {
    fn default() -> Self {
        Self { bias: Vector3::zeros(), information: Matrix3::identity() / (PRIOR_STD * PRIOR_STD) }
    }
}

impl GyroBias {
    /// The same bias, of which nothing is known: what to learn anew from when the gyroscope contradicts itself.
    pub(super) fn forgotten(&self) -> Self {
        Self { bias: self.bias, ..Self::default() }
    }

    /// What is believed now \[rad/s\].
    pub(super) fn bias(&self) -> Vector3<f64> {
        self.bias
    }

    /// Whether a turn over `seconds`, corrected, is right within `angle` \[rad\], in the mean over axes.
    pub(super) fn is_known(&self, seconds: f64, angle: f64) -> bool {
        let variance =
            self.information.try_inverse().map_or(f64::INFINITY, |covariance| covariance.trace() / 3.0);
        variance.sqrt() * seconds < angle
    }

    /// A measured turn of the camera over `seconds`, `cur_from_prev`, without the bias.
    pub(super) fn corrected(&self, measured: &UnitQuaternion<f64>, seconds: f64) -> UnitQuaternion<f64> {
        so3::exp(&(self.bias * seconds)) * measured
    }

    /// Learns from pairs that agree on a motion, over `seconds`, for which the gyroscope measured `cur_from_prev`; `essential` is what they
    /// agree on. Returns the share of the pairs that fit the bias and the path found; 0 where nothing could be learnt.
    pub(super) fn learn(
        &mut self,
        pairs: &[Pair],
        measured: &UnitQuaternion<f64>,
        essential: &Matrix3<f64>,
        focal_px: f64,
        seconds: f64,
    ) -> f64 {
        if pairs.len() < FEWEST || !(seconds > 0.0 && seconds <= LONGEST_S) {
            return 0.0;
        }
        if !essential.iter().all(|v| v.is_finite()) {
            return 0.0;
        }
        let Some(predicted) = self.walked(seconds) else { return 0.0 };
        let rays: Vec<[Vector3<f64>; 2]> =
            pairs.iter().map(|pair| [measured * pair.prev, pair.cur]).collect();
        // The path is what the matrix maps everything to a right angle of.
        let square = (essential * essential.transpose()).symmetric_eigen();
        let path: Vector3<f64> = square.eigenvectors.column(square.eigenvalues.imin()).into_owned();
        let std = TRACK_STD_PX / focal_px;
        let prior = predicted.information / (seconds * seconds);
        let start = predicted.bias * seconds;
        let Some(found) = TwoView::of(&rays, (start, prior), path, std) else { return 0.0 };
        let bias = found.turn / seconds;
        let sane = bias.iter().all(|v| v.is_finite()) && bias.norm() < LARGEST;
        if sane && found.information.iter().all(|v| v.is_finite()) {
            *self = Self { bias, information: found.information * (seconds * seconds) };
        }
        found.fits as f64 / pairs.len() as f64
    }

    /// The same, known less well after `seconds`.
    fn walked(&self, seconds: f64) -> Option<Self> {
        let covariance = self.information.try_inverse()? + Matrix3::identity() * (WALK * WALK * seconds);
        Some(Self { information: covariance.try_inverse()?, ..*self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;

    const FOCAL: f64 = 460.0;

    /// Frames .1 s apart whose gyroscope has a bias; each moves by `path` times a random direction.
    fn fly(bias: Vector3<f64>, path: f64, frames: usize) -> (GyroBias, Vec<f64>) {
        fly_on(GyroBias::default(), bias, path, frames)
    }

    fn fly_on(mut filter: GyroBias, bias: Vector3<f64>, path: f64, frames: usize) -> (GyroBias, Vec<f64>) {
        let mut rng = Stream::new(7).named("gyro bias").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let mut errors = Vec::new();
        for _ in 0..frames {
            let turn = so3::exp(&(Vector3::new(normal(), normal(), normal()) * 0.05));
            let step = Vector3::new(normal(), normal(), normal()).normalize() * path;
            let measured = so3::exp(&(-0.1 * bias)) * turn;
            let pairs: Vec<Pair> = (0..100)
                .map(|_| {
                    let ray = Vector3::new(0.45 * normal(), 0.3 * normal(), 1.0);
                    let point = ray * (1.0 + 9.0 * (0.5 + 0.5 * normal().tanh()));
                    let mut noisy = |v: Vector3<f64>| {
                        (v / v.z + Vector3::new(normal(), normal(), 0.0) * (0.25 / FOCAL)).normalize()
                    };
                    Pair { prev: noisy(point), cur: noisy(turn * point + step) }
                })
                .collect();
            let essential = step.cross_matrix() * turn.to_rotation_matrix().matrix();
            filter.learn(&pairs, &measured, &essential, FOCAL, 0.1);
            errors.push((filter.bias() - bias).norm());
        }
        (filter, errors)
    }

    #[test]
    fn the_bias_is_found_in_flight_at_rest_and_in_pure_rotation() {
        let bias = Vector3::new(-0.002, 0.021, 0.078);
        for path in [0.1, 0.02, 0.0] {
            let (filter, errors) = fly(bias, path, 20);
            assert!(errors[0] < 0.03 && errors[19] < 0.004, "path {path} m: {errors:?}");
            // The filter does not believe more than is true: the error is within a few of its deviations.
            let error = filter.bias() - bias;
            let squared = (error.transpose() * filter.information * error)[0];
            assert!(squared < 16.0, "path {path} m: {squared}");
        }
    }

    #[test]
    fn a_gyroscope_that_changes_its_mind_fits_when_what_was_known_is_forgotten() {
        let bias = Vector3::new(-0.002, 0.021, 0.078);
        let other = bias + Vector3::new(0.2, 0.0, -0.1);
        let known = |filter: &GyroBias| filter.is_known(0.1, 0.5 / FOCAL);
        let (filter, _) = fly(bias, 0.1, 10);
        assert!(known(&filter) && !known(&filter.forgotten()));
        // What is known too well does not move.
        let (_, stuck) = fly_on(filter, other, 0.1, 1);
        let (again, errors) = fly_on(filter.forgotten(), other, 0.1, 6);
        assert!(stuck[0] > 0.05 && known(&again) && errors[5] < 0.01, "{stuck:?} {errors:?}");
    }

    #[test]
    fn what_is_corrected_is_the_true_turn() {
        let bias = Vector3::new(0.05, -0.02, 0.08);
        let filter = GyroBias { bias, ..GyroBias::default() };
        let rate = Vector3::new(0.4, -0.2, 0.3);
        let measured = so3::exp(&(-(rate + bias) * 0.1));
        assert!(filter.corrected(&measured, 0.1).angle_to(&so3::exp(&(-rate * 0.1))) < 2e-4);
    }

    #[test]
    fn few_tracks_long_pauses_and_nonsense_teach_nothing() {
        let mut filter = GyroBias::default();
        let pair = Pair { prev: Vector3::z(), cur: Vector3::z() };
        let none = Matrix3::zeros();
        let turn = UnitQuaternion::identity();
        filter.learn(&[pair; 5], &turn, &none, FOCAL, 0.1);
        filter.learn(&[pair; 50], &turn, &none, FOCAL, 5.0);
        filter.learn(&[Pair { cur: Vector3::repeat(f64::NAN), ..pair }; 50], &turn, &none, FOCAL, 0.1);
        assert_eq!(filter.bias(), Vector3::zeros());
    }
}
