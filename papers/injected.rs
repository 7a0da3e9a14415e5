//! How models follow a change of the noise.

use super::cache::cached;
use super::error::{PaperError, stopped};
use dpn_core::Sensor;
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::signal::stats::median_of;
use dpn_eval::closed_loop::SequenceSet;
use dpn_eval::injected::{Course, Injection, StepResponse, step_response};
use dpn_eval::noise::{Fresh, Recorded};
use dpn_io::ResultPath;
use dpn_pronet::network::Network;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
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
    dir: &ResultPath,
    stop: &AtomicBool,
) -> Result<Vec<Response>, PaperError> {
    let names = source.names();
    let courses: Vec<Course> = Course::ADDING.into_iter().filter(|c| *c != Course::Ramp).collect();
    let jobs: Vec<(usize, Course)> =
        places.iter().flat_map(|place| courses.iter().map(|course| (*place, *course))).collect();
    let measured = jobs.par_iter().map(|(place, course)| {
        stopped(stop)?;
        let path = dir.join(format!("{}-{}.json", names[*place].0, course.name()));
        let piece = cached(&path, || {
            let recording = source.recording(*place, seed)?;
            let (imu, oracle) = injection.with(*course).apply(&recording.imu, seed);
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
