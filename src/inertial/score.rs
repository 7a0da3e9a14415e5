//! The field's figures of a corrected gyroscope, by the names of who defined them.
//!
//! * `aoe_deg`, Brossard's and Debias_IMU's absolute orientation error: rates integrated from the first true rotation to the end (here by mid-points), never corrected; the root of the mean square
//!   of the angle to the truth, over all samples.
//! * `roe_deg`, AirIMU's relative orientation error: the mean angle after a span (theirs is a second), begun anew at the truth each time.
//! * `quick_deg`, ours: the same after the course's own mean bias was taken out, which leaves what is quicker than a sequence.

use crate::affine::{Fitted, Unknown, fit};
use crate::config::InertialConfig;
use crate::course::Course;
use crate::gravity::steadied;
use crate::model::Model;
use crate::running::Average;
use dpn_core::geometry::so3;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde::Serialize;

/// Spans over which rates are begun anew \[s\].
pub const TURNS_S: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0];
/// A span begins this much after the one before it, or where that ends \[s\].
const APART_S: f64 = 1.0;
/// A bias' deviation is judged from the first on, so far apart \[s\].
const TOLD_S: [f64; 2] = [20.0, 10.0];
/// Samples to a step of the running bias.
const SPAN: usize = 32;

/// What rates of a course are worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// Absolute orientation error \[deg\].
    pub aoe_deg: f64,
    /// Over spans.
    pub turns: Vec<Turn>,
}

/// What rates are worth over spans of one length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Turn {
    /// Length of a span \[s\].
    pub span_s: f64,
    /// Relative orientation error \[deg\].
    pub roe_deg: f64,
    /// The same without a bias of the whole course \[deg\].
    pub quick_deg: f64,
}

impl Score {
    /// Over a second.
    pub fn second(&self) -> Option<&Turn> {
        self.turns.iter().find(|turn| turn.span_s == 1.0)
    }
}

/// A way to rates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Source {
    /// What it is called.
    pub name: String,
    /// Its score.
    pub score: Score,
    /// What the deviation of its bias is worth, where it says one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slow: Option<SlowBias>,
}

/// What a bias with its deviation is worth, every ten seconds from 20 s on, against the course's own mean bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlowBias {
    /// Mean square of the error in deviations, over instants and axes.
    pub nees: f64,
    /// Mean negative logarithm of the likelihood of three axes, in rad/s, without its constant;
    pub nll: f64,
    /// the same without gravity: the training recordings' spread as the deviation.
    pub nll_spread: f64,
}

/// Every way to rates of a course: raw, affine, a network's and its average over `average_s` of past, slow ones with what gravity tells, and what knows the truth of this course.
pub fn sources(course: &Course, fitted: &Fitted, models: &[Model], config: &InertialConfig) -> Vec<Source> {
    let raw = &course.gyro;
    let calibrated: Vec<_> = raw.iter().map(|reading| fitted.affine.apply(reading)).collect();
    // None where gravity is not asked.
    let steady = |name: String, rates: &[Vector3<f64>], speed: Option<f64>| {
        let speed = speed.filter(|speed| *speed > 0.0)?;
        let told = steadied(course, rates, &fitted.spread, speed);
        let slow = slow_bias(course, rates, &told, &fitted.spread);
        let rates = told.iter().map(|[rate, ..]| *rate).collect::<Vec<_>>();
        Some(Source { name, score: score(course, &rates), slow })
    };
    let plain =
        |name: String, rates: &[Vector3<f64>]| Source { name, score: score(course, rates), slow: None };
    let mut all = vec![plain("raw".to_owned(), raw), plain("affine".to_owned(), &calibrated)];
    all.extend(steady("affine, gravity".to_owned(), &calibrated, config.speed));
    for model in models {
        let corrections = model.corrections(course);
        let base: Vec<_> = raw.iter().map(|reading| model.card.affine.apply(reading)).collect();
        let sum = |corrections: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
            base.iter().zip(corrections).map(|(b, c)| b + c).collect()
        };
        let seed = model.card.config.seed;
        all.push(plain(format!("network {seed}"), &sum(&corrections)));
        let slow = sum(&averaged(&corrections, (config.average_s * course.rate.hz()) as usize));
        all.push(plain(format!("network {seed} averaged"), &slow));
        all.extend(steady(format!("network {seed} averaged, gravity"), &slow, model.card.config.speed));
    }
    let bias = own_bias(course, raw);
    let own: Vec<_> = raw.iter().map(|rate| rate + bias).collect();
    all.push(plain("raw, its own mean bias".to_owned(), &own));
    all.push(plain("affine, running bias".to_owned(), &running(course, &calibrated)));
    all
}

/// What gravity `told` of the bias of `rates`, by [`steadied`]; none of a course too short.
fn slow_bias(
    course: &Course,
    rates: &[Vector3<f64>],
    told: &[[Vector3<f64>; 3]],
    spread: &[f64; 3],
) -> Option<SlowBias> {
    let bias = own_bias(course, rates);
    let [first, apart] = TOLD_S.map(|s| (s * course.rate.hz()).round() as usize);
    let (mut all, mut count) = ([0.0; 3], 0.0);
    for [_, said, std] in told.iter().skip(first).step_by(apart) {
        let half = |off: f64, std: f64| 0.5 * (off / std).powi(2) + std.ln();
        for axis in 0..3 {
            let off = said[axis] - bias[axis];
            all[0] += (off / std[axis]).powi(2) / 3.0;
            all[1] += half(off, std[axis]);
            all[2] += half(bias[axis], spread[axis]);
        }
        count += 1.0;
    }
    let [nees, nll, nll_spread] = all.map(|sum| sum / count);
    (count > 0.0).then_some(SlowBias { nees, nll, nll_spread })
}

fn averaged(values: &[Vector3<f64>], past: usize) -> Vec<Vector3<f64>> {
    let mut average = Average::over(past);
    values.iter().map(|value| average.push(*value)).collect()
}

/// What is to be added to rates so that they fit this course's truth best: an oracle.
fn own_bias(course: &Course, rates: &[Vector3<f64>]) -> Vector3<f64> {
    let with = Course { gyro: rates.to_vec(), ..course.clone() };
    fit(&[&with], Unknown::Bias).map_or(Vector3::zeros(), |found| found.affine.bias)
}

/// Rates less the mean of their errors so far: what somebody learns who was told the truth of the past.
fn running(course: &Course, rates: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let turned = integrated(course, rates);
    let mut out = rates.to_vec();
    let (mut sum, mut seconds) = (Vector3::zeros(), 0.0);
    for from in (0..course.len() - 1).step_by(SPAN) {
        let to = (from + SPAN).min(course.len() - 1);
        let bias = if seconds > 0.0 { sum / seconds } else { Vector3::zeros() };
        out[from..to].iter_mut().for_each(|rate| *rate -= bias);
        if let Some(turn) = course.turn(from, to) {
            sum += so3::log(&(turn.inverse() * turned[from].inverse() * turned[to]));
            seconds += course.step_s[from..to].iter().sum::<f64>();
        }
    }
    out
}

/// Absolute orientation error \[deg\] of what rates have `turned` since the first sample, at each.
pub(crate) fn absolute_error(course: &Course, turned: &[UnitQuaternion<f64>]) -> f64 {
    let first = course.truth[0].expect("a course begins with a truth").rotation;
    let off = |(truth, turned): (&Option<Isometry3<f64>>, &UnitQuaternion<f64>)| {
        Some(so3::log(&((*truth)?.rotation.inverse() * first * turned)).norm_squared())
    };
    let squares: Vec<f64> = course.truth.iter().zip(turned).filter_map(off).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt().to_degrees()
}

/// Rates integrated from the first sample to each, over a step the mean of the two at its ends.
pub(crate) fn integrated(course: &Course, rates: &[Vector3<f64>]) -> Vec<UnitQuaternion<f64>> {
    let mut turned = vec![UnitQuaternion::identity()];
    let steps = rates.windows(2).zip(&course.step_s);
    turned.extend(steps.scan(UnitQuaternion::identity(), |turned, (pair, step)| {
        *turned *= so3::exp(&(0.5 * (pair[0] + pair[1]) * *step));
        Some(*turned)
    }));
    turned
}

/// What `rates` of `course`'s samples are worth.
pub(crate) fn score(course: &Course, rates: &[Vector3<f64>]) -> Score {
    let turned = integrated(course, rates);
    let bias = own_bias(course, rates);
    let without = integrated(course, &rates.iter().map(|rate| rate + bias).collect::<Vec<_>>());
    let turn = |span_s: f64| {
        let [samples, apart] = [span_s, span_s.min(APART_S)].map(|s| (s * course.rate.hz()).round() as usize);
        let (mut sums, mut count) = ([0.0; 2], 0_usize);
        for from in (0..course.len().saturating_sub(samples)).step_by(apart.max(1)) {
            let Some(turn) = course.turn(from, from + samples) else { continue };
            for (sum, turned) in sums.iter_mut().zip([&turned, &without]) {
                *sum += turn.angle_to(&(turned[from].inverse() * turned[from + samples])).to_degrees();
            }
            count += 1;
        }
        let [roe_deg, quick_deg] = sums.map(|sum| sum / count as f64);
        (count > 0).then_some(Turn { span_s, roe_deg, quick_deg })
    };
    Score { aoe_deg: absolute_error(course, &turned), turns: TURNS_S.into_iter().filter_map(turn).collect() }
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
        let fitted = Fitted { affine: crate::Affine::none(), ..fit(&[&course], Unknown::Bias).unwrap() };
        let rows = sources(&course, &fitted, &[], &InertialConfig::default());
        let of = |name: &str| rows.iter().find(|row| row.name == name).unwrap().score.clone();
        let end = (0.002 * 30.0_f64).to_degrees();
        assert!((of("raw").aoe_deg - end / 3f64.sqrt()).abs() < 1e-3 * end);
        // After a span its share of it; nothing where the bias is taken out; no span is longer than the course.
        let turns = of("raw").turns;
        assert!(
            turns.iter().all(|t| (t.roe_deg - end * t.span_s / 30.0).abs() < 1e-6
                && t.quick_deg < 1e-4 * t.span_s.max(1.0)),
            "{turns:?}"
        );
        assert_eq!(turns.last().unwrap().span_s, 10.0);
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
