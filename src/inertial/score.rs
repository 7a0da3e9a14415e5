//! The field's figures of a corrected gyroscope, by the names of who defined them.
//!
//! * `aoe_deg`, Brossard's and Debias_IMU's absolute orientation error: rates integrated from the first true rotation to the end, never corrected; the root of the mean square
//!   of the angle to the truth, over all samples.
//! * `roe_deg`, AirIMU's relative orientation error: the mean angle after one second, begun anew at the truth each time.
//! * `quick_deg`, ours: the same after the course's own mean bias was taken out, which leaves what is quicker than a sequence.

use crate::affine::{Unknown, fit};
use crate::course::Course;
use crate::model::Model;
use dpn_core::geometry::so3;
use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;

/// Over which rates are begun anew \[s\].
const SECOND: f64 = 1.0;
/// Samples to a step of the running bias.
const SPAN: usize = 32;

/// What rates of a course are worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Score {
    /// Absolute orientation error \[deg\].
    pub aoe_deg: f64,
    /// Relative orientation error over a second \[deg\].
    pub roe_deg: f64,
    /// The same without a bias of the whole course \[deg\].
    pub quick_deg: f64,
}

/// A way to rates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Source {
    /// What it is called.
    pub name: String,
    /// Its score.
    pub score: Score,
}

/// Every way to rates of a course: raw, affine, a network's and its average over `average_s` of past, and what knows the truth of this course.
pub fn sources(course: &Course, affine: &crate::Affine, models: &[Model], average_s: f64) -> Vec<Source> {
    let raw = &course.gyro;
    let calibrated: Vec<_> = raw.iter().map(|reading| affine.apply(reading)).collect();
    let mut all = vec![("raw".to_owned(), raw.clone()), ("affine".to_owned(), calibrated.clone())];
    for model in models {
        let corrections = model.corrections(course);
        let base: Vec<_> = raw.iter().map(|reading| model.card.affine.apply(reading)).collect();
        let sum = |corrections: &[Vector3<f64>]| base.iter().zip(corrections).map(|(b, c)| b + c).collect();
        let seed = model.card.config.seed;
        all.push((format!("network {seed}"), sum(&corrections)));
        let samples = (average_s * course.rate.hz()) as usize;
        all.push((format!("network {seed} averaged"), sum(&averaged(&corrections, samples))));
    }
    all.push(("raw, its own mean bias".to_owned(), without_bias(course, raw)));
    all.push(("affine, running bias".to_owned(), running(course, &calibrated)));
    all.into_iter().map(|(name, rates)| Source { name, score: score(course, &rates) }).collect()
}

/// Means over so many values of past, fewer where there are no more.
fn averaged(values: &[Vector3<f64>], past: usize) -> Vec<Vector3<f64>> {
    let past = past.max(1);
    let mut sum = Vector3::zeros();
    let mean = |(i, value): (usize, &Vector3<f64>)| {
        sum += value;
        if i >= past {
            sum -= values[i - past];
        }
        sum / (i + 1).min(past) as f64
    };
    values.iter().enumerate().map(mean).collect()
}

/// Rates less the bias that fits this course's truth best: an oracle.
fn without_bias(course: &Course, rates: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let with = Course { gyro: rates.to_vec(), ..course.clone() };
    let bias = fit(&[&with], Unknown::Bias).map_or(Vector3::zeros(), |found| found.affine.bias);
    rates.iter().map(|rate| rate + bias).collect()
}

/// Rates less the mean of their errors so far: what somebody learns who was told the truth of the past.
fn running(course: &Course, rates: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut out = rates.to_vec();
    let (mut sum, mut seconds) = (Vector3::zeros(), 0.0);
    for from in (0..course.len() - 1).step_by(SPAN) {
        let to = (from + SPAN).min(course.len() - 1);
        let bias = if seconds > 0.0 { sum / seconds } else { Vector3::zeros() };
        out[from..to].iter_mut().for_each(|rate| *rate -= bias);
        if let Some(turn) = course.turn(from, to) {
            sum += so3::log(&(turn.inverse() * product(course, rates, from, to)));
            seconds += course.step_s[from..to].iter().sum::<f64>();
        }
    }
    out
}

/// Rates integrated from one sample to another.
fn product(course: &Course, rates: &[Vector3<f64>], from: usize, to: usize) -> UnitQuaternion<f64> {
    (from..to).fold(UnitQuaternion::identity(), |r, i| r * so3::exp(&(rates[i] * course.step_s[i])))
}

/// What `rates` of `course`'s samples are worth.
pub(crate) fn score(course: &Course, rates: &[Vector3<f64>]) -> Score {
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut rotation = course.truth[0].expect("a course begins with a truth").rotation;
    for (i, truth) in course.truth.iter().enumerate() {
        if let Some(truth) = truth {
            sum += so3::log(&(truth.rotation.inverse() * rotation)).norm_squared();
            count += 1;
        }
        if i + 1 < course.len() {
            rotation *= so3::exp(&(rates[i] * course.step_s[i]));
        }
    }
    let second = |rates: &[Vector3<f64>]| {
        let samples = (SECOND * course.rate.hz()).round() as usize;
        let starts = (0..course.len().saturating_sub(samples)).step_by(samples);
        let angles: Vec<f64> = starts
            .filter_map(|from| {
                let turn = course.turn(from, from + samples)?;
                Some(turn.angle_to(&product(course, rates, from, from + samples)).to_degrees())
            })
            .collect();
        angles.iter().sum::<f64>() / angles.len() as f64
    };
    Score {
        aoe_deg: (sum / count as f64).sqrt().to_degrees(),
        roe_deg: second(rates),
        quick_deg: second(&without_bias(course, rates)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;
    use nalgebra::Matrix3;

    #[test]
    fn a_constant_bias_makes_the_error_that_it_must_and_an_oracle_takes_it_out() {
        let bias = Vector3::new(0.0, 0.0, 0.002);
        let mut course = simulated(30.0, Matrix3::identity(), bias, 0.0);
        // At rest the error is the bias times time: its root mean square the end's over the root of three.
        course.gyro.iter_mut().for_each(|g| *g = bias);
        let first = course.truth[0];
        course.truth.iter_mut().for_each(|truth| *truth = first);
        let rows = sources(&course, &crate::Affine::none(), &[], 20.0);
        let of = |name: &str| rows.iter().find(|row| row.name == name).unwrap().score;
        let end = (0.002 * 30.0_f64).to_degrees();
        assert!((of("raw").aoe_deg - end / 3f64.sqrt()).abs() < 1e-3 * end);
        assert!((of("raw").roe_deg - end / 30.0).abs() < 1e-6 && of("raw").quick_deg < 1e-4);
        assert!(
            of("raw, its own mean bias").aoe_deg < 1e-3 && of("affine, running bias").aoe_deg < 0.01 * end
        );
    }

    #[test]
    fn an_average_looks_back_and_nowhere_else() {
        let values: Vec<_> = (0..6).map(|i| Vector3::repeat(f64::from(i))).collect();
        let means: Vec<f64> = averaged(&values, 3).iter().map(|v| v.x).collect();
        assert_eq!(means, [0.0, 0.5, 1.0, 2.0, 3.0, 4.0]);
    }
}
