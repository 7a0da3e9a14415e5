//! What the experiment with injected noise says: how models follow, and what following is worth.

use super::cache::cached;
use super::error::{PaperError, stopped};
use super::specs;
use dpn_core::Sensor;
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::signal::stats::median_of;
use dpn_eval::closed_loop::SequenceSet;
use dpn_eval::injected::{Course, Injection, StepResponse, step_response};
use dpn_eval::noise::{Fresh, Recorded};
use dpn_eval::stats::StatsError;
use dpn_eval::study::{Comparison, Criterion, Reference, RowSet, compare, correct_for_count};
use dpn_pronet::network::Network;
use dpn_train::split::Side;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// How one noise follows one course, medians over sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Response {
    pub(super) course: Course,
    pub(super) noise: NoiseSpec,
    pub(super) sensor: Sensor,
    /// Sequences measured.
    pub(super) sequences: usize,
    /// Median estimate before the change and while it is in force, on the axes that change \[unit of the sensor\].
    pub(super) low: f64,
    pub(super) high: f64,
    /// Median lags \[s\], and of how many sequences.
    pub(super) rise: Option<(f64, usize)>,
    pub(super) fall: Option<(f64, usize)>,
}

/// The axes of a course that change.
fn axes(course: Course) -> &'static [usize] {
    if course == Course::OneAxis { &[1] } else { &[0, 1, 2] }
}

/// What is measured at a time, and kept in a file of its own: the responses to one course over one sequence, of every noise to each sensor.
type Piece = Vec<[Option<StepResponse>; 2]>;

/// Responses of all `noises` to all courses with a change, over the sequences at `places`. Pieces that lie in `dir` are read, the others put there.
pub(super) fn responses(
    source: &SequenceSet,
    places: &[usize],
    noises: &[NoiseSpec],
    networks: &[Network],
    (injection, seed): (&Injection, u64),
    dir: &Path,
    stop: &AtomicBool,
) -> Result<Vec<Response>, PaperError> {
    let names = source.names();
    let courses: Vec<Course> = Course::ALL.into_iter().filter(|c| *c != Course::Ramp).collect();
    let jobs: Vec<(usize, Course)> =
        places.iter().flat_map(|place| courses.iter().map(|course| (*place, *course))).collect();
    let measured = jobs.par_iter().map(|(place, course)| {
        stopped(stop)?;
        let path = dir.join(format!("{}-{}.json", names[*place].0, course.name()));
        let piece = cached(&path, || {
            let recording = source.recording(*place, seed)?;
            let (imu, oracle) = injection.with(*course).apply(&recording.name, &recording.imu, seed);
            let recorded = Recorded { name: &recording.name, imu: &imu, oracle: Some(&oracle) };
            let sources = Fresh { recorded, networks };
            let stream = Stream::new(seed).named("noise").named(&recording.name);
            let of = |noise: &NoiseSpec| {
                stopped(stop)?;
                let track = dpn_eval::noise::track(noise, &imu, &sources, &stream)?;
                Ok(Sensor::ALL.map(|sensor| step_response(&track, *course, sensor, axes(*course))))
            };
            noises.iter().map(of).collect::<Result<Piece, PaperError>>()
        });
        Ok(piece?.0)
    });
    let measured = measured.collect::<Result<Vec<Piece>, PaperError>>()?;
    let mut found = Vec::new();
    for course in courses {
        for (n, noise) in noises.iter().enumerate() {
            for (s, sensor) in Sensor::ALL.into_iter().enumerate() {
                let of: Vec<_> = jobs
                    .iter()
                    .zip(&measured)
                    .filter(|((_, c), _)| *c == course)
                    .filter_map(|(_, responses)| responses[n][s])
                    .collect();
                let lag = |pick: fn(&StepResponse) -> Option<f64>| {
                    let lags: Vec<f64> = of.iter().filter_map(pick).collect();
                    let count = lags.len();
                    median_of(lags).map(|lag| (lag, count))
                };
                let (Some(low), Some(high)) =
                    (median_of(of.iter().map(|r| r.low)), median_of(of.iter().map(|r| r.high)))
                else {
                    continue;
                };
                found.push(Response {
                    course,
                    noise: noise.clone(),
                    sensor,
                    sequences: of.len(),
                    low,
                    high,
                    rise: lag(|r| r.rise_s),
                    fall: lag(|r| r.fall_s),
                });
            }
        }
    }
    Ok(found)
}

/// What a noise is worth where the noise is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct NoiseWorth {
    pub(super) noise: NoiseSpec,
    /// Median over sequences of the error \[m\]: all, training, test.
    pub(super) ate: [Option<f64>; 3],
    /// Share of the way from the reference to the oracle: all, training, test.
    pub(super) closed: [Option<f64>; 3],
    pub(super) failures: usize,
    /// Against the reference, sequence by sequence.
    pub(super) comparison: Option<Comparison>,
}

/// Every noise of one course.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct CourseStudy {
    /// The best constant on training sequences by the median, which is reported.
    pub(super) reference: Option<Reference>,
    /// Sequences: all, training, test.
    pub(super) sequences: [usize; 3],
    /// How far the oracle lies below the reference, as a share of it: all, training, test.
    pub(super) gap: [Option<f64>; 3],
    pub(super) noises: Vec<NoiseWorth>,
}

const SIDES: [Option<Side>; 3] = [None, Some(Side::Train), Some(Side::Test)];

impl CourseStudy {
    /// Of the rows of one course; `margin` as for [`compare`].
    pub(super) fn new(rows: &RowSet<'_>, margin: f64) -> Result<Self, StatsError> {
        let medians = |noise: &NoiseSpec| SIDES.map(|side| rows.median(noise, side));
        let reference = rows.reference(Criterion::Median);
        let best = reference.as_ref().map(|reference| &reference.noise);
        let (best_ate, oracle_ate) = (best.map_or([None; 3], medians), medians(&specs::noise(specs::ORACLE)));
        let mut noises = Vec::new();
        for noise in rows.noises() {
            let comparison = match best.filter(|best| best != noise) {
                Some(best) => compare(rows, noise, best, margin)?,
                None => None,
            };
            let ate = medians(noise);
            let closed = [0, 1, 2].map(|i| {
                let (best, oracle) = (best_ate[i]?, oracle_ate[i]?);
                (best > oracle).then_some((best - ate[i]?) / (best - oracle))
            });
            let failures = rows.of(noise).filter(|r| r.failure.is_some()).count();
            noises.push(NoiseWorth { noise: (*noise).clone(), ate, closed, failures, comparison });
        }
        correct_for_count(noises.iter_mut().filter_map(|worth| worth.comparison.as_mut()))?;
        let gap = [0, 1, 2].map(|i| Some(1.0 - oracle_ate[i]? / best_ate[i]?));
        Ok(Self { reference, sequences: SIDES.map(|side| rows.count(side)), gap, noises })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_eval::closed_loop::testing::row;

    #[test]
    fn the_gap_and_what_is_closed_of_it() {
        let mut rows = Vec::new();
        for (name, side) in [("a", Side::Train), ("b", Side::Train), ("c", Side::Test), ("d", Side::Test)] {
            for (noise, ate) in [
                ("x4", 0.4),
                ("x8", if side == Side::Test { 0.1 } else { 0.5 }),
                ("oracle", 0.2),
                ("diff2", 0.25),
            ] {
                let mut row = row(name, noise, 0, Some(ate));
                row.split = side;
                rows.push(row);
            }
        }
        let value = CourseStudy::new(&RowSet::new(&rows), 0.1).unwrap();
        assert_eq!(value.sequences, [4, 2, 2]);
        let reference = value.reference.unwrap();
        assert!(reference.at_edge && reference.noise == specs::noise("x4"));
        assert_eq!(value.gap, [Some(0.5); 3]);
        let worth = |noise: &str| value.noises.iter().find(|w| w.noise == specs::noise(noise)).unwrap();
        assert!((worth("diff2").closed[0].unwrap() - 0.75).abs() < 1e-12);
        assert!((worth("oracle").closed[2].unwrap() - 1.0).abs() < 1e-12);
        assert!(worth("x4").closed[1].unwrap().abs() < 1e-12);
    }
}
