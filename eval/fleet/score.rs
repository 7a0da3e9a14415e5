//! The score of each noise on each platform, and over all.

use crate::closed_loop::Row;
use crate::stats::StatsError;
use crate::study::{Comparison, MARGIN, RowSet, compare_pairs, correct_for_count, pairs};
use dpn_core::estimate::NoiseSpec;
use dpn_core::signal::stats::mean;
use serde::Serialize;

/// The fleet's table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FleetScore {
    /// A line a platform, in the plan's order.
    pub platforms: Vec<PlatformScore>,
    /// A line a noise, in the plan's order, constants first.
    pub noises: Vec<NoiseScore>,
    /// The same of the single constant that is best on the other platforms; none with one platform alone.
    pub single: Option<NoiseScore>,
}

/// One platform.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlatformScore {
    /// Its name.
    pub name: String,
    /// How many sequences.
    pub sequences: usize,
    /// Runs of each noise.
    pub runs: usize,
    /// The constant with the lowest mean error here; none where each lost a sequence.
    pub best: Option<NoiseSpec>,
    /// Whether that is the lowest or the highest that was run: a better one may lie beyond.
    pub at_edge: bool,
    /// The constant with the best score on the other platforms.
    pub single: Option<NoiseSpec>,
    /// Every noise, in the plan's order.
    pub noises: Vec<NoiseOnPlatform>,
}

/// A noise on a platform.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseOnPlatform {
    /// The noise.
    pub noise: NoiseSpec,
    /// Mean over sequences of the median over seeds of the absolute error \[m\]; none where a sequence has no error.
    pub ate: Option<f64>,
    /// That over the best constant's.
    pub score: Option<f64>,
    /// Failed runs.
    pub failures: usize,
}

/// A noise over the fleet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseScore {
    /// The noise; of the single constant, which differs from platform to platform, none.
    pub noise: Option<NoiseSpec>,
    /// Geometric mean of its scores; none where a platform has none.
    pub score: Option<f64>,
    /// Its worst score and the platform that has it.
    pub worst: Option<(String, f64)>,
    /// Against the single constant, over the sequences of all platforms.
    pub comparison: Option<Comparison>,
}

impl FleetScore {
    /// The score of platforms by name, each with its rows, over `constants` and all `noises` (constants among them).
    ///
    /// # Errors
    /// An error of a run that is zero or not finite.
    pub fn new(
        platforms: &[(String, Vec<Row>)],
        constants: &[NoiseSpec],
        noises: &[NoiseSpec],
    ) -> Result<Self, StatsError> {
        let sets: Vec<RowSet<'_>> = platforms.iter().map(|(_, rows)| RowSet::new(rows)).collect();
        let mut scores: Vec<PlatformScore> = platforms
            .iter()
            .zip(&sets)
            .map(|((name, _), rows)| on_platform(name, rows, constants, noises))
            .collect();
        for place in 0..scores.len() {
            scores[place].single = best_elsewhere(&scores, place, constants);
        }
        let of_single = |platform: &PlatformScore| {
            let single = platform.single.as_ref()?;
            platform.of(single)?.score
        };
        let single = (scores.len() > 1).then(|| overall(None, &scores, of_single));
        let mut lines = Vec::new();
        for noise in noises {
            let mut line = overall(Some(noise.clone()), &scores, |platform| platform.of(noise)?.score);
            if single.is_some() && !constants.contains(noise) {
                line.comparison = against_single(noise, &scores, &sets)?;
            }
            lines.push(line);
        }
        correct_for_count(lines.iter_mut().filter_map(|line| line.comparison.as_mut()))?;
        Ok(Self { platforms: scores, noises: lines, single })
    }
}

impl PlatformScore {
    /// The line of one noise.
    pub fn of(&self, noise: &NoiseSpec) -> Option<&NoiseOnPlatform> {
        self.noises.iter().find(|line| line.noise == *noise)
    }
}

fn on_platform(
    name: &str,
    rows: &RowSet<'_>,
    constants: &[NoiseSpec],
    noises: &[NoiseSpec],
) -> PlatformScore {
    let known = constants.iter().filter_map(|noise| Some((noise, rows.mean(noise, None)?)));
    let best = known.min_by(|a, b| a.1.total_cmp(&b.1));
    let multiples = || constants.iter().filter_map(NoiseSpec::multiple);
    let at_edge = best.and_then(|(noise, _)| noise.multiple()).is_some_and(|best| {
        multiples().count() > 1 && (multiples().all(|m| m <= best) || multiples().all(|m| m >= best))
    });
    let line = |noise: &NoiseSpec| {
        let ate = rows.mean(noise, None);
        NoiseOnPlatform {
            noise: noise.clone(),
            ate,
            score: ate.zip(best).map(|(ate, (_, best))| ate / best),
            failures: rows.of(noise).filter(|row| row.failure.is_some()).count(),
        }
    };
    PlatformScore {
        name: name.to_owned(),
        sequences: rows.count(None),
        runs: noises.first().map_or(0, |noise| rows.of(noise).count()),
        best: best.map(|(noise, _)| noise.clone()),
        at_edge,
        single: None,
        noises: noises.iter().map(line).collect(),
    }
}

/// The constant with the lowest geometric mean score on all platforms but one.
fn best_elsewhere(scores: &[PlatformScore], but: usize, constants: &[NoiseSpec]) -> Option<NoiseSpec> {
    let others = || scores.iter().enumerate().filter(move |(place, _)| *place != but).map(|(_, score)| score);
    let known = constants.iter().filter_map(|noise| {
        Some((noise, geometric_mean(others().map(|platform| platform.of(noise)?.score))?))
    });
    known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(noise, _)| noise.clone())
}

fn overall(
    noise: Option<NoiseSpec>,
    scores: &[PlatformScore],
    of: impl Fn(&PlatformScore) -> Option<f64>,
) -> NoiseScore {
    let worst = scores.iter().filter_map(|platform| Some((platform.name.clone(), of(platform)?)));
    NoiseScore {
        noise,
        score: geometric_mean(scores.iter().map(&of)),
        worst: worst.max_by(|a, b| a.1.total_cmp(&b.1)),
        comparison: None,
    }
}

/// None where there is none of anything, or one is not there.
fn geometric_mean(scores: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let logs: Vec<f64> = scores.map(|score| score.map(f64::ln)).collect::<Option<_>>()?;
    (!logs.is_empty()).then(|| mean(&logs).exp())
}

/// `noise` against each platform's single constant, over the sequences of all.
fn against_single(
    noise: &NoiseSpec,
    scores: &[PlatformScore],
    sets: &[RowSet<'_>],
) -> Result<Option<Comparison>, StatsError> {
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for (platform, rows) in scores.iter().zip(sets) {
        if let Some(single) = &platform.single {
            let (a, b) = pairs(rows, noise, single);
            ours.extend(a);
            theirs.extend(b);
        }
    }
    compare_pairs(&ours, &theirs, MARGIN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::testing::row;

    fn noise(spec: &str) -> NoiseSpec {
        spec.parse().unwrap()
    }

    /// Errors of x1, x4 and `self` on a platform of four sequences; a sequence is 10 % worse than the one before.
    fn platform(name: &str, errors: [f64; 3]) -> (String, Vec<Row>) {
        let mut rows = Vec::new();
        for (spec, error) in ["x1", "x4", "self"].into_iter().zip(errors) {
            for place in 0..4_i32 {
                rows.push(row(&format!("s{place}"), spec, 0, Some(error * 1.1_f64.powi(place))));
            }
        }
        (name.to_owned(), rows)
    }

    fn score(platforms: &[(String, Vec<Row>)]) -> FleetScore {
        let constants = [noise("x1"), noise("x4")];
        FleetScore::new(platforms, &constants, &[noise("x1"), noise("x4"), noise("self")]).unwrap()
    }

    #[test]
    fn each_platform_is_scored_by_its_own_best_and_its_rival_is_chosen_elsewhere() {
        // x1 is best on a and b, x4 on c: chosen on a and b alone, c's rival is x1; a's and b's are what is best on the other two.
        let fleet = [
            platform("a", [0.1, 0.2, 0.11]),
            platform("b", [0.1, 0.5, 0.1]),
            platform("c", [0.4, 0.1, 0.08]),
        ];
        let score = score(&fleet);
        let best: Vec<_> = score.platforms.iter().map(|p| p.best.clone().unwrap().to_string()).collect();
        assert_eq!(best, ["x1", "x1", "x4"]);
        let single: Vec<_> = score.platforms.iter().map(|p| p.single.clone().unwrap().to_string()).collect();
        // Without a: x1 has 1 and 4, x4 has 5 and 1. Without b: x1 has 1 and 4, x4 2 and 1.
        assert_eq!(single, ["x1", "x4", "x1"]);
        let of = |spec: &str| score.noises.iter().find(|line| line.noise == Some(noise(spec))).unwrap();
        assert!((of("self").score.unwrap() - (1.1_f64 * 1.0 * 0.8).cbrt()).abs() < 1e-12);
        assert_eq!(of("self").worst.as_ref().map(|(name, _)| name.as_str()), Some("a"));
        assert!((of("x4").score.unwrap() - 10.0_f64.cbrt()).abs() < 1e-12);
        // 1 on a, 5 on b, 4 on c.
        assert!((score.single.as_ref().unwrap().score.unwrap() - 20.0_f64.cbrt()).abs() < 1e-12);
        let comparison = of("self").comparison.clone().unwrap();
        assert_eq!((comparison.sequences, comparison.better), (12, 8));
        let ratio = (1.1_f64 * 0.2 * 0.2).cbrt();
        assert!((comparison.ratio - ratio).abs() < 1e-12, "{}", comparison.ratio);
        assert!(of("x1").comparison.is_none());
    }

    #[test]
    fn a_noise_that_loses_a_sequence_has_no_score() {
        let mut fleet = [platform("a", [0.1, 0.2, 0.1]), platform("b", [0.1, 0.2, 0.1])];
        fleet[1]
            .1
            .iter_mut()
            .filter(|row| row.noise == noise("self"))
            .take(1)
            .for_each(|row| row.ate_se3 = None);
        let score = score(&fleet);
        let of = score.noises.iter().find(|line| line.noise == Some(noise("self"))).unwrap();
        assert_eq!(of.score, None);
        assert_eq!(of.worst, Some(("a".to_owned(), 1.0)));
        assert!(score.platforms[0].at_edge);
    }
}
