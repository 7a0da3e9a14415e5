//! How a noise track follows a step.

use super::course::Course;
use dpn_core::signal::stats::median_in_place;
use dpn_core::{NoiseTrack, Sensor};
use serde::{Deserialize, Serialize};

/// Time around a change that counts to neither level \[s\].
const SETTLING_S: f64 = 5.0;
/// A change is looked for this long after the true one \[s\].
const LONGEST_S: f64 = 15.0;

/// How one sensor's estimate follows the two changes of a step, all axes together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepResponse {
    /// Median of the estimates while nothing is raised \[unit of the sensor\].
    pub low: f64,
    /// Median while it is.
    pub high: f64,
    /// From the true rise until the median over axes of the estimate has gone half of the way \[s\]; none where it never does.
    pub rise_s: Option<f64>,
    /// The same of the fall.
    pub fall_s: Option<f64>,
}

/// Measures the response of `track` to `course`, whose changes are at fixed shares of the track's time. `axes`: those that change.
///
/// Nothing for a course without a rise, or a track too short to tell levels from changes.
pub fn step_response(
    track: &NoiseTrack,
    course: Course,
    sensor: Sensor,
    axes: &[usize],
) -> Option<StepResponse> {
    let (rise, fall) = match course {
        Course::Step | Course::OneAxis | Course::Tone => (1.0 / 3.0, Some(2.0 / 3.0)),
        Course::BiasJump => (0.5, None),
        Course::None | Course::Ramp => return None,
    };
    let start = *track.stamps().first()?;
    let t: Vec<f64> = track.stamps().iter().map(|s| s.seconds_since(start)).collect();
    let length = *t.last()?;
    let middle: Vec<f64> = track
        .noises()
        .iter()
        .map(|noise| median_in_place(&mut axes.iter().map(|a| noise.of(sensor)[*a]).collect::<Vec<_>>()))
        .collect();
    let (rise, fall_at) = (rise * length, fall.map(|share| share * length));
    let end = fall_at.unwrap_or(length);
    let level = |inside: &dyn Fn(f64) -> bool| {
        let mut values: Vec<f64> =
            t.iter().zip(&middle).filter(|(t, _)| inside(**t)).map(|(_, v)| *v).collect();
        (!values.is_empty()).then(|| median_in_place(&mut values))
    };
    let settled = |t: f64, from: f64| t > from + SETTLING_S;
    let low = level(&|t| t < rise && t > rise - length / 3.0 + SETTLING_S)?;
    let high = level(&|t| settled(t, rise) && t < end)?;
    let half = 0.5 * (low + high);
    let crossed = |from: f64, above: bool| {
        let until = from + LONGEST_S;
        let inside = t.iter().zip(&middle).filter(|(t, _)| **t >= from && **t < until);
        inside.into_iter().find(|(_, v)| (**v >= half) == above).map(|(t, _)| t - from)
    };
    // Levels a tenth apart are no change to follow.
    let changes = high > 1.1 * low;
    Some(StepResponse {
        low,
        high,
        rise_s: if changes { crossed(rise, true) } else { None },
        fall_s: fall_at.filter(|_| changes).and_then(|at| crossed(at, false)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuNoise, Stamp};

    fn track(sigma: impl Fn(f64) -> f64) -> NoiseTrack {
        let stamps = (0..18_001).map(|i| Stamp::from_ns(5_000_000 * i)).collect();
        let noise = |i: i32| {
            let s = sigma(f64::from(i) * 0.005);
            ImuNoise::from_values([s, 2.0 * s, 3.0 * s], [s / 10.0; 3]).unwrap()
        };
        NoiseTrack::new(stamps, (0..18_001).map(noise).collect()).unwrap()
    }

    #[test]
    fn a_lag_is_found_where_it_was_put() {
        let late = track(|t| if (30.7..61.2).contains(&t) { 1.0 } else { 0.2 });
        let found = step_response(&late, Course::Step, Sensor::Accel, &[0, 1, 2]).unwrap();
        assert!((found.low - 0.4).abs() < 1e-12 && (found.high - 2.0).abs() < 1e-12, "{found:?}");
        assert!((found.rise_s.unwrap() - 0.7).abs() < 0.006, "{found:?}");
        assert!((found.fall_s.unwrap() - 1.2).abs() < 0.006, "{found:?}");
        let found = step_response(&late, Course::OneAxis, Sensor::Gyro, &[1]).unwrap();
        assert!((found.high - 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_move_has_no_lag() {
        let still = track(|_| 0.3);
        for course in [Course::Step, Course::Tone, Course::BiasJump] {
            let found = step_response(&still, course, Sensor::Gyro, &[0, 1, 2]).unwrap();
            assert_eq!((found.rise_s, found.fall_s), (None, None));
        }
        assert_eq!(step_response(&still, Course::Ramp, Sensor::Gyro, &[0]), None);
    }
}
