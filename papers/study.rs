//! Every noise over all its runs, and against the best constant.
//!
//! A sequence's figure is the median over seeds; what a noise is worth is told over sequences, paired. The best constant is the one whose
//! mean over the *training* sequences is lowest: nothing of a test sequence chooses it.

use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::signal::stats::{mean, median_in_place};
use dpn_eval::closed_loop::Row;
use dpn_eval::stats::{
    Alternative, Bootstrap, StatsError, bootstrap, equivalence_signed_rank, holm, log_ratios,
    median_interval, signed_rank,
};
use dpn_train::split::Side;
use serde::Serialize;
use std::collections::BTreeMap;

/// Fewest sequences that are tested: of five pairs the smallest two-sided p is .0625.
pub(super) const FEWEST: usize = 6;

/// Rows of one closed loop, by noise and sequence.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    rows: Vec<&'a Row>,
    /// Noises: multiples of the baseline in their order, then the others in that of the plan.
    pub(super) noises: Vec<String>,
    /// Sequences in order, with their sides.
    pub(super) sequences: Vec<(String, Side)>,
}

/// One noise.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Line {
    pub(super) noise: String,
    /// Fewest and most seeds of a sequence.
    pub(super) seeds: [usize; 2],
    pub(super) runs: usize,
    pub(super) failures: usize,
    pub(super) restarts: usize,
    /// Median over sequences of the error, with its interval \[m\].
    pub(super) ate: Option<f64>,
    pub(super) ate_interval: Option<[f64; 2]>,
    /// Means over sequences \[m\]: all, training, test.
    pub(super) means: [Option<f64>; 3],
    /// Root mean square of the noise told over runs: accelerometer \[m/s^2\], gyroscope \[rad/s\].
    pub(super) told: Option<[f64; 2]>,
    pub(super) rpe_1s: Option<f64>,
    pub(super) nees: [Option<f64>; 2],
    pub(super) whitened: Option<f64>,
    pub(super) cpu_per_data_s: Option<f64>,
    /// Against the best constant; none for itself and where there are too few sequences.
    pub(super) against: Option<Against>,
}

/// One noise against the best constant, sequence by sequence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Against {
    pub(super) sequences: usize,
    pub(super) better: usize,
    /// Geometric mean of the ratio of errors, with its interval over sequences.
    pub(super) ratio: f64,
    pub(super) ratio_interval: [f64; 2],
    /// Two-sided p of the signed-rank test; none with few sequences.
    pub(super) p: Option<f64>,
    /// The same, corrected for the number of noises.
    pub(super) p_holm: Option<f64>,
    /// p of the test that the ratio lies within the margin.
    pub(super) p_equal: Option<f64>,
}

/// The study.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Study {
    pub(super) best_constant: Option<String>,
    /// Whether it is the end of the sweep.
    pub(super) at_edge: bool,
    pub(super) lines: Vec<Line>,
    pub(super) margin: f64,
}

impl<'a> Rows<'a> {
    pub(super) fn new(rows: &'a [Row]) -> Self {
        let mut noises: Vec<String> = Vec::new();
        let mut sequences: BTreeMap<String, Side> = BTreeMap::new();
        for row in rows {
            if !noises.contains(&row.noise) {
                noises.push(row.noise.clone());
            }
            sequences.insert(row.sequence.clone(), row.split);
        }
        let multiple = |noise: &String| noise.parse::<NoiseSpec>().ok()?.multiple();
        noises.sort_by(|a, b| {
            let [a, b] = [a, b].map(|noise| multiple(noise).unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        });
        Self { rows: rows.iter().collect(), noises, sequences: sequences.into_iter().collect() }
    }

    pub(super) fn of<'s>(&'s self, noise: &'s str) -> impl Iterator<Item = &'a Row> + 's {
        self.rows.iter().copied().filter(move |row| row.noise == noise)
    }

    /// Median over seeds of the error \[m\], where any run has one.
    pub(super) fn ate(&self, sequence: &str, noise: &str) -> Option<f64> {
        median(self.of(noise).filter(|r| r.sequence == sequence).filter_map(|r| r.ate_se3).collect())
    }

    /// Failed runs of one cell.
    pub(super) fn failures(&self, sequence: &str, noise: &str) -> usize {
        self.of(noise).filter(|r| r.sequence == sequence && r.failure.is_some()).count()
    }

    /// Medians by sequence, of one side or of both.
    pub(super) fn ates(&self, noise: &str, side: Option<Side>) -> Vec<(&str, f64)> {
        let wanted = self.sequences.iter().filter(|(_, s)| side.is_none_or(|side| side == *s));
        wanted.filter_map(|(name, _)| Some((name.as_str(), self.ate(name, noise)?))).collect()
    }

    /// Median over sequences, a sequence without an error counting as worse than any: none where that leaves no figure.
    pub(super) fn median(&self, noise: &str, side: Option<Side>) -> Option<f64> {
        let wanted = self.sequences.iter().filter(|(_, s)| side.is_none_or(|side| side == *s));
        let worst = |name: &str| self.ate(name, noise).unwrap_or(f64::INFINITY);
        median(wanted.map(|(name, _)| worst(name)).collect()).filter(|median| median.is_finite())
    }

    /// Mean over sequences; none where a sequence has no error, for means of different sets mislead.
    pub(super) fn mean(&self, noise: &str, side: Option<Side>) -> Option<f64> {
        let count = self.sequences.iter().filter(|(_, s)| side.is_none_or(|side| side == *s)).count();
        let ates: Vec<f64> = self.ates(noise, side).into_iter().map(|(_, ate)| ate).collect();
        (!ates.is_empty() && ates.len() == count).then(|| mean(&ates))
    }

    /// The constant whose mean over the training sequences is lowest; over all where none is a training sequence.
    pub(super) fn best_constant(&self) -> Option<&str> {
        let train = self.sequences.iter().any(|(_, side)| *side == Side::Train);
        let side = train.then_some(Side::Train);
        let constants = self.noises.iter().filter(|n| n.parse::<NoiseSpec>().is_ok_and(|n| n.is_constant()));
        let with_mean = constants.filter_map(|noise| Some((self.mean(noise, side)?, noise.as_str())));
        with_mean.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, noise)| noise)
    }

    /// Whether `best` is the lowest or the highest multiple of the baseline that was run: the lowest error may lie beyond it.
    pub(super) fn at_edge(&self, best: &str) -> bool {
        let multiple = |noise: &str| noise.parse::<NoiseSpec>().ok()?.multiple();
        let all: Vec<f64> = self.noises.iter().filter_map(|noise| multiple(noise)).collect();
        let of = multiple(best);
        of.is_some_and(|of| all.iter().all(|m| *m <= of) || all.iter().all(|m| *m >= of))
    }

    /// Pairs of errors of two noises, by sequence: medians over the seeds that both have an error of.
    fn pairs(&self, noise: &str, reference: &str) -> (Vec<f64>, Vec<f64>) {
        let by_seed = |name: &str, noise: &str| -> BTreeMap<u64, f64> {
            let rows = self.of(noise).filter(|row| row.sequence == name);
            rows.filter_map(|row| Some((row.seed, row.ate_se3?))).collect()
        };
        let pair = |(name, _): &(String, Side)| {
            let (ours, theirs) = (by_seed(name, noise), by_seed(name, reference));
            let both = ours.iter().filter_map(|(seed, ate)| Some((*ate, *theirs.get(seed)?)));
            let (ours, theirs): (Vec<f64>, Vec<f64>) = both.unzip();
            Some((median(ours)?, median(theirs)?))
        };
        self.sequences.iter().filter_map(pair).unzip()
    }

    /// The whole comparison.
    pub(super) fn study(&self, margin: f64) -> Result<Study, StatsError> {
        let best = self.best_constant().map(str::to_owned);
        let mut lines = self.noises.iter().map(|n| self.line(n)).collect::<Result<Vec<_>, _>>()?;
        if let Some(best) = &best {
            for line in lines.iter_mut().filter(|line| line.noise != *best) {
                line.against = self.against(&line.noise, best, margin)?;
            }
            correct(lines.iter_mut().filter_map(|line| line.against.as_mut()))?;
        }
        let at_edge = best.as_deref().is_some_and(|best| self.at_edge(best));
        Ok(Study { best_constant: best, at_edge, lines, margin })
    }

    fn line(&self, noise: &str) -> Result<Line, StatsError> {
        let values =
            |f: &dyn Fn(&Row) -> Option<f64>| median(self.of(noise).filter_map(f).collect::<Vec<f64>>());
        let seeds = |name: &str| self.of(noise).filter(|r| r.sequence == name).count();
        let counts: Vec<usize> = self.sequences.iter().map(|(name, _)| seeds(name)).collect();
        let ates: Vec<f64> = self.ates(noise, None).into_iter().map(|(_, ate)| ate).collect();
        let stream = Stream::new(0).named("paper").named("median");
        let interval =
            if ates.len() < 2 { None } else { Some(median_interval(&ates, &Bootstrap::default(), &stream)?) };
        let squares: Vec<[f64; 2]> = self
            .of(noise)
            .filter_map(|r| r.noise_rms)
            .map(|rms| rms.map(|axes| axes.iter().map(|s| s * s).sum::<f64>() / 3.0))
            .collect();
        let root = |i: usize| (squares.iter().map(|s| s[i]).sum::<f64>() / squares.len() as f64).sqrt();
        Ok(Line {
            noise: noise.to_owned(),
            seeds: [counts.iter().copied().min().unwrap_or(0), counts.iter().copied().max().unwrap_or(0)],
            runs: self.of(noise).count(),
            failures: self.of(noise).filter(|r| r.failure.is_some()).count(),
            restarts: self.of(noise).map(|r| r.restarts).sum(),
            ate: self.median(noise, None),
            ate_interval: interval.map(|i| [i.low, i.high]),
            means: [None, Some(Side::Train), Some(Side::Test)].map(|side| self.mean(noise, side)),
            told: (!squares.is_empty()).then(|| [root(0), root(1)]),
            rpe_1s: values(&|r| r.rpe_1s),
            nees: [values(&|r| r.nees_position), values(&|r| r.nees_orientation)],
            whitened: values(&|r| r.whitened),
            cpu_per_data_s: values(&|r| Some(r.cpu_per_data_s)),
            against: None,
        })
    }

    /// `noise` against `best`, not corrected for others; nothing with fewer than two sequences in common.
    pub(super) fn against(
        &self,
        noise: &str,
        best: &str,
        margin: f64,
    ) -> Result<Option<Against>, StatsError> {
        let (ours, theirs) = self.pairs(noise, best);
        if ours.len() < 2 {
            return Ok(None);
        }
        let logs = log_ratios(&ours, &theirs)?;
        let statistic = |cases: &[usize]| mean(&cases.iter().map(|&i| logs[i]).collect::<Vec<_>>());
        let stream = Stream::new(0).named("paper").named("ratio");
        let interval = bootstrap(logs.len(), statistic, &Bootstrap::default(), &stream)?;
        let tested = logs.len() >= FEWEST;
        let p = if tested { Some(signed_rank(&logs, Alternative::TwoSided)?.p) } else { None };
        let p_equal =
            if tested { Some(equivalence_signed_rank(&logs, (1.0 + margin).ln())?.p) } else { None };
        Ok(Some(Against {
            sequences: logs.len(),
            better: logs.iter().filter(|d| **d < 0.0).count(),
            ratio: interval.observed.exp(),
            ratio_interval: [interval.low.exp(), interval.high.exp()],
            p,
            p_holm: None,
            p_equal,
        }))
    }
}

/// Corrects for the number of tests, by Holm.
pub(super) fn correct<'a>(tests: impl Iterator<Item = &'a mut Against>) -> Result<(), StatsError> {
    let mut tested: Vec<&mut Against> = tests.filter(|test| test.p.is_some()).collect();
    let p: Vec<f64> = tested.iter().filter_map(|test| test.p).collect();
    for (test, p) in tested.iter_mut().zip(holm(&p)?) {
        test.p_holm = Some(p);
    }
    Ok(())
}

/// The median; none of nothing.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| median_in_place(&mut values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_eval::closed_loop::testing::row;

    fn rows() -> Vec<Row> {
        let mut rows = Vec::new();
        for i in 0..8_u32 {
            // Odd ones are test sequences; the best constant of these alone would be x8.
            let name = format!("s{i}");
            let base = 0.1 + 0.01 * f64::from(i);
            let odd = i % 2 == 1;
            for (noise, factor) in [("x4", 1.0), ("x8", if odd { 0.7 } else { 1.4 }), ("dualpronet", 0.8)] {
                for seed in 0..3 {
                    let mut row = row(&name, noise, seed, Some(base * factor * (1.0 + 0.01 * seed as f64)));
                    row.split = if odd { Side::Test } else { Side::Train };
                    rows.push(row);
                }
            }
        }
        rows
    }

    #[test]
    fn the_best_constant_is_chosen_on_training_sequences_alone() {
        let rows = rows();
        let of = Rows::new(&rows);
        assert_eq!(of.best_constant(), Some("x4"));
        assert_eq!(of.noises, ["x4", "x8", "dualpronet"]);
        assert!(of.at_edge("x4") && of.at_edge("x8") && !of.at_edge("dualpronet"));
        assert!((of.ate("s0", "x4").unwrap() - 0.101).abs() < 1e-12);
    }

    #[test]
    fn ratios_and_tests_are_over_sequences() {
        let rows = rows();
        let study = Rows::new(&rows).study(0.1).unwrap();
        let line = |noise: &str| study.lines.iter().find(|l| l.noise == noise).unwrap();
        assert!(line("x4").against.is_none());
        let ours = line("dualpronet").against.clone().unwrap();
        assert_eq!((ours.sequences, ours.better), (8, 8));
        assert!((ours.ratio - 0.8).abs() < 1e-12 && (ours.ratio_interval[1] - 0.8).abs() < 1e-12);
        // All eight signs alike: 2 / 2^8, times two noises; far from within 10 %.
        assert!((ours.p.unwrap() - 0.0078125).abs() < 1e-12);
        assert!((ours.p_holm.unwrap() - 0.015625).abs() < 1e-12);
        assert!(ours.p_equal.unwrap() > 0.9);
        assert_eq!(line("x8").against.clone().unwrap().better, 4);
        assert_eq!(line("dualpronet").seeds, [3, 3]);
    }

    #[test]
    fn noises_are_compared_on_the_seeds_that_both_have() {
        let mut rows = rows();
        // A second and third seed that went badly, for the reference alone.
        rows.retain(|r| r.noise != "dualpronet" || r.seed == 0);
        for row in rows.iter_mut().filter(|r| r.noise == "x4" && r.seed > 0) {
            row.ate_se3 = row.ate_se3.map(|ate| 7.0 * ate);
        }
        let ours = Rows::new(&rows).against("dualpronet", "x4", 0.1).unwrap().unwrap();
        assert!((ours.ratio - 0.8).abs() < 1e-12, "{}", ours.ratio);
    }

    #[test]
    fn a_mean_over_fewer_sequences_than_there_are_is_none() {
        let mut rows = rows();
        for row in rows.iter_mut().filter(|r| r.sequence == "s3" && r.noise == "x8") {
            row.ate_se3 = None;
        }
        let of = Rows::new(&rows);
        // Its errors are .14, .077, .168, none, .196, .105, .224, .119: between .14 and .168 with none last.
        let middle = 0.5 * (of.ate("s0", "x8").unwrap() + of.ate("s2", "x8").unwrap());
        assert!((of.median("x8", None).unwrap() - middle).abs() < 1e-12);
        assert_eq!(of.mean("x8", None), None);
        assert!(of.mean("x8", Some(Side::Train)).is_some());
        assert_eq!(of.study(0.1).unwrap().lines[1].against.as_ref().unwrap().sequences, 7);
    }
}
