//! Whether gravity is asked, and of how slow a body: chosen by leaving out training recordings.

use crate::affine::{Unknown, fit};
use crate::course::Course;
use crate::gravity::steadied;
use crate::score::{absolute_error, integrated};
use rayon::prelude::*;

/// Deviations of the velocity that are tried \[m/s\]; 0: gravity is not asked.
const SPEEDS: [f64; 4] = [0.0, 0.5, 1.0, 2.0];

/// The deviation of the body's velocity \[m/s\] with which gravity helps most: the least mean absolute orientation error of recordings that are left out one by one, each calibrated by the
/// others. 0, gravity is not asked, where it helps nowhere and of a single recording.
pub fn chosen_speed(courses: &[&Course]) -> f64 {
    let errors = |left: usize| {
        let (course, others) = (courses[left], [&courses[..left], &courses[left + 1..]].concat());
        let fitted = fit(&others, Unknown::All)?;
        let rates: Vec<_> = course.gyro.iter().map(|reading| fitted.affine.apply(reading)).collect();
        let error = |speed: f64| {
            let told = steadied(course, &rates, &fitted.spread, speed);
            let rates = told.iter().map(|[rate, ..]| *rate).collect::<Vec<_>>();
            absolute_error(course, &integrated(course, &rates))
        };
        Some(SPEEDS.map(error))
    };
    // Of a single recording nothing is left to fit to.
    let all: Vec<[f64; SPEEDS.len()]> = (0..courses.len()).into_par_iter().filter_map(errors).collect();
    let sum = |i: usize| all.iter().map(|errors| errors[i]).sum::<f64>();
    let least = (1..SPEEDS.len()).fold(0, |least, i| if sum(i) < sum(least) { i } else { least });
    SPEEDS[least]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn gravity_is_asked_where_a_body_stays_slow_and_left_alone_where_it_does_not() {
        let with = |x: f64| simulated(40.0, Matrix3::identity(), Vector3::new(x, -x, 0.002), 0.002);
        let slow = [with(0.004), with(-0.004), with(0.001)];
        assert!(chosen_speed(&slow.each_ref()) > 0.0);
        assert_eq!(chosen_speed(&[&slow[0]]), 0.0);
        // Accelerations that last and biases that are alike: what gravity seems to say is wrong.
        let quick = [1.0, 2.0, 3.0].map(|phase: f64| {
            let mut course = with(0.0);
            for (i, force) in course.accel.iter_mut().enumerate() {
                force.x += 3.0 * (0.3 * i as f64 / 200.0 + phase).sin();
            }
            course
        });
        assert_eq!(chosen_speed(&quick.each_ref()), 0.0);
    }
}
