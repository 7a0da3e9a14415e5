//! What the experiment with injected noise says: how models follow, and what following is worth.

use super::error::PaperError;
use super::study::{Against, Rows, correct, median};
use dpn_core::Sensor;
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_eval::closed_loop::Source;
use dpn_eval::injected::{Course, Injection, step_response};
use dpn_eval::noise::{Fresh, Recorded};
use dpn_eval::stats::StatsError;
use dpn_pronet::network::Network;
use dpn_train::split::Side;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How one noise follows one course, medians over sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Response {
    pub(super) course: Course,
    pub(super) noise: String,
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

/// Responses of all `noises` to all courses with a change, over the sequences at `places`.
pub(super) fn responses(
    source: &Source,
    places: &[usize],
    noises: &[NoiseSpec],
    networks: &[Network],
    injection: &Injection,
    seed: u64,
) -> Result<Vec<Response>, PaperError> {
    let courses: Vec<Course> = Course::ALL.into_iter().filter(|c| *c != Course::Ramp).collect();
    let jobs: Vec<(usize, Course)> =
        places.iter().flat_map(|place| courses.iter().map(|course| (*place, *course))).collect();
    // Of each job: for every noise and sensor a response.
    let measured = jobs
        .par_iter()
        .map(|(place, course)| {
            let recording = source.recording(*place, seed)?;
            let (imu, oracle) = injection.with(*course).apply(&recording.name, &recording.imu, seed);
            let recorded = Recorded { name: &recording.name, imu: &imu, oracle: Some(&oracle) };
            let sources = Fresh { recorded, networks };
            let stream = Stream::new(seed).named("noise").named(&recording.name);
            let of = |noise: &NoiseSpec| {
                let track = dpn_eval::noise::track(noise, &imu, &sources, &stream)?;
                Ok(Sensor::ALL.map(|sensor| step_response(&track, *course, sensor, axes(*course))))
            };
            noises.iter().map(of).collect::<Result<Vec<_>, PaperError>>()
        })
        .collect::<Result<Vec<_>, PaperError>>()?;
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
                let lag = |pick: fn(&dpn_eval::injected::StepResponse) -> Option<f64>| {
                    let lags: Vec<f64> = of.iter().filter_map(pick).collect();
                    let count = lags.len();
                    median(lags).map(|lag| (lag, count))
                };
                let (Some(low), Some(high)) =
                    (median(of.iter().map(|r| r.low).collect()), median(of.iter().map(|r| r.high).collect()))
                else {
                    continue;
                };
                found.push(Response {
                    course,
                    noise: noise.to_string(),
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
pub(super) struct Worth {
    pub(super) noise: String,
    /// Median over sequences of the error \[m\]: all, training, test.
    pub(super) ate: [Option<f64>; 3],
    /// Share of the way from the best constant to the oracle: all, training, test.
    pub(super) closed: [Option<f64>; 3],
    pub(super) failures: usize,
    /// Against the best constant, sequence by sequence.
    pub(super) against: Option<Against>,
}

/// The value of every noise of one course. The best constant is chosen on training sequences, by the median that is reported.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Value {
    pub(super) best_constant: Option<String>,
    /// Sequences: all, training, test.
    pub(super) sequences: [usize; 3],
    /// Whether it is the end of the sweep, so that the gap is no more than said: a constant beyond may be better.
    pub(super) at_edge: bool,
    /// How far the oracle lies below the best constant, as a share of it: all, training, test.
    pub(super) gap: [Option<f64>; 3],
    pub(super) worth: Vec<Worth>,
}

const SIDES: [Option<Side>; 3] = [None, Some(Side::Train), Some(Side::Test)];

pub(super) fn value(rows: &Rows<'_>, margin: f64) -> Result<Value, StatsError> {
    let median_of = |noise: &str, side: Option<Side>| rows.median(noise, side);
    let train = rows.sequences.iter().any(|(_, side)| *side == Side::Train);
    let choosing = train.then_some(Side::Train);
    let best = rows
        .noises
        .iter()
        .filter(|noise| noise.parse::<NoiseSpec>().is_ok_and(|n| n.is_constant()))
        .filter_map(|noise| Some((median_of(noise, choosing)?, noise.clone())))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, noise)| noise);
    let reference = SIDES.map(|side| median_of(best.as_deref()?, side));
    let oracle = SIDES.map(|side| median_of("oracle", side));
    let gap = [0, 1, 2].map(|i| Some(1.0 - oracle[i]? / reference[i]?));
    let mut worth = rows
        .noises
        .iter()
        .map(|noise| {
            let against = match best.as_deref().filter(|best| best != noise) {
                Some(best) => rows.against(noise, best, margin)?,
                None => None,
            };
            let ate = SIDES.map(|side| median_of(noise, side));
            let closed = [0, 1, 2].map(|i| {
                let (best, oracle) = (reference[i]?, oracle[i]?);
                (best > oracle).then_some((best - ate[i]?) / (best - oracle))
            });
            let failures = rows.of(noise).filter(|r| r.failure.is_some()).count();
            Ok(Worth { noise: noise.clone(), ate, closed, failures, against })
        })
        .collect::<Result<Vec<Worth>, StatsError>>()?;
    correct(worth.iter_mut().filter_map(|worth| worth.against.as_mut()))?;
    let at_edge = best.as_deref().is_some_and(|best| rows.at_edge(best));
    let count = |side: &Option<Side>| {
        rows.sequences.iter().filter(|(_, s)| side.is_none_or(|side| side == *s)).count()
    };
    let sequences = [count(&SIDES[0]), count(&SIDES[1]), count(&SIDES[2])];
    Ok(Value { best_constant: best, sequences, at_edge, gap, worth })
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
        let value = value(&Rows::new(&rows), 0.1).unwrap();
        assert!(value.at_edge);
        assert_eq!(value.sequences, [4, 2, 2]);
        assert_eq!(value.best_constant.as_deref(), Some("x4"));
        assert_eq!(value.gap, [Some(0.5); 3]);
        let worth = |noise: &str| value.worth.iter().find(|w| w.noise == noise).unwrap();
        assert!((worth("diff2").closed[0].unwrap() - 0.75).abs() < 1e-12);
        assert!((worth("oracle").closed[2].unwrap() - 1.0).abs() < 1e-12);
        assert!(worth("x4").closed[1].unwrap().abs() < 1e-12);
    }
}
