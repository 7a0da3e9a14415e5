//! Trials, scores, and the share that agrees.

use super::config::Geometry;
use super::fundamental::Whitened;
use super::pair::Pair;
use super::two_point::Derotated;
use dpn_core::random::{Stream, StreamRng};
use nalgebra::{Matrix3, UnitQuaternion};
use rand::Rng;

/// Matrices are scored by squares truncated at this share of the threshold. Where something large moves by itself, one that compromises
/// has more pairs within the whole threshold than the true one, but fewer close by.
const SCORED_SHARE: f64 = 0.5;

/// Two tracks with noise give a rough motion, even if both are true: of a few good samples the best is taken.
const FEWEST_TRIALS: usize = 20;

/// Most trials.
const MOST_TRIALS: usize = 200;

/// Probability that a sample without a false track was tried.
const CONFIDENCE: f64 = 0.99;

/// Where fewer tracks than this share agree with the gyroscope's rotation, a free matrix is asked as well and the larger share wins: a rotation
/// may be spoilt by a bias nobody knows yet.
pub(crate) const DOUBT_SHARE: f64 = 0.7;

/// Below this many pairs nothing is taken out: any eight fit a matrix.
const FEWEST: usize = 9;

/// What a set of pairs agrees on.
#[derive(Debug, Clone, PartialEq)]
pub struct Consensus {
    /// For each pair, whether it agrees.
    pub inliers: Vec<bool>,
    /// How many do.
    pub agreeing: usize,
    /// The matrix they agree on, `cur^T E prev = 0`; none where there were too few pairs to ask.
    pub essential: Option<Matrix3<f64>>,
    /// What it was made with.
    pub geometry: Geometry,
    /// Trials, of both kinds where both were asked.
    pub trials: usize,
    /// What agreed with the gyroscope's rotation, where that was asked and a free matrix won.
    pub by_rotation: Option<Box<Consensus>>,
}

impl Consensus {
    /// The share of pairs that agree; 1 where there is none.
    pub(crate) fn share(&self) -> f64 {
        if self.inliers.is_empty() { 1.0 } else { self.agreeing as f64 / self.inliers.len() as f64 }
    }
}

/// Asks `pairs` what they agree on; `cur_from_prev` is the rotation of the camera's frame where the gyroscope says one, and `focal_px`
/// turns `threshold_px`, the largest distance of a pair that agrees, into an angle. Where a smaller share than `doubt_share` agrees with the rotation, a
/// matrix without it is asked too.
///
/// The answer is a function of its inputs and `stream`. With fewer than nine pairs all agree.
pub fn agree(
    pairs: &[Pair],
    cur_from_prev: Option<&UnitQuaternion<f64>>,
    focal_px: f64,
    threshold_px: f64,
    doubt_share: f64,
    stream: &Stream,
) -> Consensus {
    if pairs.len() < FEWEST {
        let (inliers, agreeing) = (vec![true; pairs.len()], pairs.len());
        return Consensus {
            inliers,
            agreeing,
            essential: None,
            geometry: Geometry::Fundamental,
            trials: 0,
            by_rotation: None,
        };
    }
    let threshold = threshold_px / focal_px;
    let known =
        cur_from_prev.map(|rotation| by_two_points(pairs, rotation, threshold, &stream.named("two-point")));
    match known {
        Some(known) if known.share() >= doubt_share => known,
        known => {
            let free = by_seven_points(pairs, threshold, &stream.named("fundamental"));
            match known {
                // A free matrix fits more by nature: it has to win clearly.
                Some(known) if known.agreeing + known.agreeing / 10 >= free.agreeing => {
                    Consensus { trials: known.trials + free.trials, ..known }
                }
                known => {
                    let trials = known.as_ref().map_or(0, |known| known.trials) + free.trials;
                    Consensus { trials, by_rotation: known.map(Box::new), ..free }
                }
            }
        }
    }
}

fn by_two_points(
    pairs: &[Pair],
    rotation: &UnitQuaternion<f64>,
    threshold: f64,
    stream: &Stream,
) -> Consensus {
    let derotated = Derotated::new(pairs, rotation);
    let mut search = Search::new(pairs, threshold);
    let trials = search.run::<2>(stream, |sample| derotated.solve(sample).into_iter().collect());
    search.polish(|inliers, near| derotated.refit(pairs, inliers, near));
    let mut found = search.into_consensus(Geometry::TwoPoint, trials);
    if let Some(essential) = &found.essential {
        derotated.reject_wrong_way(pairs, essential, threshold, &mut found.inliers);
        found.agreeing = found.inliers.iter().filter(|inlier| **inlier).count();
    }
    found
}

fn by_seven_points(pairs: &[Pair], threshold: f64, stream: &Stream) -> Consensus {
    let whitened = Whitened::new(pairs);
    let mut search = Search::new(pairs, threshold);
    let trials = search.run::<7>(stream, |sample| whitened.solve(sample));
    search.polish(|inliers, _| whitened.refit(inliers));
    search.into_consensus(Geometry::Fundamental, trials)
}

/// The best matrix so far.
struct Search<'a> {
    pairs: &'a [Pair],
    threshold_squared: f64,
    scored_squared: f64,
    /// Sum of the squared distances, each at most `scored_squared`.
    cost: f64,
    best: Option<Matrix3<f64>>,
}

impl<'a> Search<'a> {
    fn new(pairs: &'a [Pair], threshold: f64) -> Self {
        let threshold_squared = threshold * threshold;
        let scored_squared = threshold_squared * SCORED_SHARE * SCORED_SHARE;
        Self { pairs, threshold_squared, scored_squared, cost: f64::INFINITY, best: None }
    }

    /// Tries samples of `N` pairs until another is not worth it; returns how many.
    fn run<const N: usize>(
        &mut self,
        stream: &Stream,
        solve: impl Fn([usize; N]) -> Vec<Matrix3<f64>>,
    ) -> usize {
        let mut rng = stream.rng();
        let mut needed = MOST_TRIALS;
        let mut trial = 0;
        while trial < needed {
            trial += 1;
            for matrix in solve(sample(&mut rng, self.pairs.len())) {
                if self.offer(matrix) {
                    // Two tracks make a compromise that would end the search early; seven seldom do, and cost more.
                    let within = if N == 2 { self.scored_squared } else { self.threshold_squared };
                    let agreeing = self.within(within).into_iter().filter(|near| *near).count();
                    let share = agreeing as f64 / self.pairs.len() as f64;
                    needed = trials_for(share, N).clamp(FEWEST_TRIALS, MOST_TRIALS);
                }
            }
        }
        trial
    }

    /// Takes `matrix` where it is better.
    fn offer(&mut self, matrix: Matrix3<f64>) -> bool {
        let mut cost = 0.0;
        for pair in self.pairs {
            // NaN counts as far.
            cost += pair.distance_squared(&matrix).min(self.scored_squared);
            if cost >= self.cost {
                return false;
            }
        }
        (self.cost, self.best) = (cost, Some(matrix));
        true
    }

    /// Refits the best matrix to all that are close by, as long as that makes it better.
    fn polish(&mut self, refit: impl Fn(&[bool], &Matrix3<f64>) -> Option<Matrix3<f64>>) {
        for _ in 0..3 {
            let Some(best) = self.best else { return };
            match refit(&self.within(self.scored_squared), &best) {
                Some(matrix) if self.offer(matrix) => {}
                _ => return,
            }
        }
    }

    /// For each pair, whether it is nearer than a squared distance.
    fn within(&self, squared: f64) -> Vec<bool> {
        let near = |pair: &Pair| self.best.is_none_or(|matrix| pair.distance_squared(&matrix) < squared);
        self.pairs.iter().map(near).collect()
    }

    fn into_consensus(self, geometry: Geometry, trials: usize) -> Consensus {
        let inliers = self.within(self.threshold_squared);
        let agreeing = inliers.iter().filter(|inlier| **inlier).count();
        Consensus { inliers, agreeing, essential: self.best, geometry, trials, by_rotation: None }
    }
}

/// `N` different indices below `n`, which is at least `N`.
fn sample<const N: usize>(rng: &mut StreamRng, n: usize) -> [usize; N] {
    let mut chosen = [usize::MAX; N];
    for k in 0..N {
        chosen[k] = loop {
            let index = rng.random_range(0..n as u32) as usize;
            if !chosen[..k].contains(&index) {
                break index;
            }
        };
    }
    chosen
}

/// Samples of `size` until one is all true with probability [`CONFIDENCE`], if `share` of the pairs are.
fn trials_for(share: f64, size: usize) -> usize {
    // Nothing and everything come out as infinitely many and none.
    let all_true = share.powi(size as i32);
    ((1.0 - CONFIDENCE).ln() / (-all_true).ln_1p()).ceil().max(1.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rand_distr::StandardNormal;

    const FOCAL: f64 = 460.0;

    struct Scene {
        pairs: Vec<Pair>,
        rotation: UnitQuaternion<f64>,
        /// The true ones come first.
        good: usize,
    }

    /// Points 1 to 10 m ahead, seen before and after a motion, with noise \[px\]; then pairs that have nothing to do with each other.
    fn scene(seed: u64, good: usize, bad: usize, path: Vector3<f64>, noise_px: f64) -> Scene {
        let mut rng = Stream::new(seed).named("scene").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(normal(), normal(), normal()) * 0.05);
        let mut pairs = Vec::new();
        for i in 0..good + bad {
            let mut ray = || Vector3::new(0.45 * normal(), 0.3 * normal(), 1.0);
            let (a, b) = (ray(), ray());
            let point = a * (1.0 + 9.0 * (0.5 + 0.5 * normal().tanh()));
            let moved = if i < good { rotation * point + path } else { b };
            let mut noisy = |v: Vector3<f64>| {
                let v = v / v.z;
                (v + Vector3::new(normal(), normal(), 0.0) * (noise_px / FOCAL)).normalize()
            };
            pairs.push(Pair { prev: noisy(a), cur: noisy(moved) });
        }
        Scene { pairs, rotation, good }
    }

    fn kept(found: &Consensus, good: usize) -> (f64, usize) {
        let count = |flags: &[bool]| flags.iter().filter(|f| **f).count();
        (count(&found.inliers[..good]) as f64 / good as f64, count(&found.inliers[good..]))
    }

    #[test]
    fn false_tracks_are_told_from_true_ones() {
        for seed in 0..10 {
            let scene = scene(seed, 100, 40, Vector3::new(0.15, -0.05, 0.1), 0.2);
            for rotation in [Some(&scene.rotation), None] {
                let found = agree(&scene.pairs, rotation, FOCAL, 1.0, DOUBT_SHARE, &Stream::new(seed));
                let (true_share, false_ones) = kept(&found, scene.good);
                // A false pair lies within 1 px of its line by chance, about 2 in 480 times a few.
                assert!(
                    true_share > 0.95 && false_ones <= 4,
                    "seed {seed}: {true_share} {false_ones} {found:?}"
                );
                assert_eq!(found.geometry == Geometry::TwoPoint, rotation.is_some());
                assert!(found.trials < 150, "{}", found.trials);
            }
        }
    }

    #[test]
    fn the_direction_of_motion_is_the_true_one() {
        let path = Vector3::new(0.2, 0.1, -0.05);
        let scene = scene(3, 120, 20, path, 0.1);
        let found = agree(&scene.pairs, Some(&scene.rotation), FOCAL, 1.0, DOUBT_SHARE, &Stream::new(1));
        let hat = found.essential.unwrap() * scene.rotation.to_rotation_matrix().matrix().transpose();
        let direction = Vector3::new(hat[(2, 1)], hat[(0, 2)], hat[(1, 0)]).normalize();
        assert!(direction.cross(&path.normalize()).norm() < 0.02, "{direction}");
    }

    #[test]
    fn a_wrong_rotation_is_noticed() {
        let scene = scene(5, 120, 20, Vector3::new(0.1, 0.0, 0.02), 0.2);
        let wrong = scene.rotation * UnitQuaternion::from_scaled_axis(Vector3::new(0.03, -0.02, 0.05));
        let found = agree(&scene.pairs, Some(&wrong), FOCAL, 1.0, DOUBT_SHARE, &Stream::new(1));
        assert_eq!(found.geometry, Geometry::Fundamental);
        assert!(kept(&found, scene.good).0 > 0.9, "{found:?}");
    }

    #[test]
    fn at_rest_and_in_pure_rotation_nothing_true_is_lost() {
        for seed in 0..5 {
            let scene = scene(seed, 100, 15, Vector3::zeros(), 0.15);
            for rotation in [Some(&scene.rotation), None] {
                let found = agree(&scene.pairs, rotation, FOCAL, 1.0, DOUBT_SHARE, &Stream::new(seed));
                let (true_share, false_ones) = kept(&found, scene.good);
                assert!(true_share > 0.97, "seed {seed}: {true_share}");
                // Without a path any line through a point fits; a free matrix can please two or three of the false.
                assert!(false_ones <= 5, "seed {seed}: {false_ones}");
            }
        }
    }

    #[test]
    fn tracks_that_go_backwards_are_taken_out() {
        let path = Vector3::new(0.3, 0.0, 0.0);
        let mut scene = scene(8, 100, 0, path, 0.05);
        // Ten points mirrored about their place at infinity stay in their plane.
        for pair in &mut scene.pairs[..10] {
            let turned = scene.rotation * pair.prev;
            pair.cur = (2.0 * turned - pair.cur).normalize();
        }
        let found = agree(&scene.pairs, Some(&scene.rotation), FOCAL, 1.0, DOUBT_SHARE, &Stream::new(1));
        assert!(found.inliers[..10].iter().all(|inlier| !inlier), "{:?}", &found.inliers[..10]);
        assert!(found.agreeing >= 86, "{}", found.agreeing);
    }

    #[test]
    fn few_pairs_identical_pairs_and_bad_numbers_are_survived() {
        let scene = scene(1, 40, 0, Vector3::new(0.1, 0.0, 0.0), 0.1);
        for n in 0..12 {
            let found = agree(&scene.pairs[..n], None, FOCAL, 1.0, DOUBT_SHARE, &Stream::new(1));
            assert_eq!(found.inliers.len(), n);
            assert!(n >= FEWEST || found.agreeing == n);
        }
        let same = vec![scene.pairs[0]; 30];
        let nan = vec![Pair { prev: Vector3::repeat(f64::NAN), cur: Vector3::zeros() }; 30];
        for pairs in [same, nan] {
            for rotation in [Some(&scene.rotation), None] {
                let found = agree(&pairs, rotation, FOCAL, 1.0, DOUBT_SHARE, &Stream::new(1));
                assert_eq!(found.inliers.len(), 30);
            }
        }
    }

    #[test]
    fn trials_follow_the_share() {
        assert_eq!(trials_for(1.0, 7), 1);
        // (1 - .5^2)^n <= .01: n = 16.01 -> 17.
        assert_eq!(trials_for(0.5, 2), 17);
        assert_eq!(trials_for(0.8, 7), 20);
        assert!(trials_for(0.0, 7) > 1_000_000);
    }
}
