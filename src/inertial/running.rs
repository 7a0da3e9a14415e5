//! A network beside running samples: the bias in force, as C and Python ask for it.
//!
//! Each layer keeps as many of its inputs as its kernel spans, so that an answer costs one column a layer. Answers are those of [`Model::corrections`], averaged as they are scored.

use crate::gravity::{Gravity, beforehand};
use crate::model::{Model, UNIT};
use crate::network::{self, Layer};
use dpn_core::{ImuSample, Stamp};
use dpn_pronet::{Gate, StreamError};
use nalgebra::{DMatrixView, DVector, Matrix3, Vector3};
use std::collections::VecDeque;

/// After a hole of so many periods the network begins anew; the average stays.
const HOLE: f64 = 20.0;
/// More than this is no gyroscope's bias but what a network says of samples that no sensor measures \[rad/s\].
const MOST: f64 = 1.0;

/// What takes a reading of the gyroscope to a rate, at the newest sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// `matrix * reading + bias` is the rate.
    pub matrix: Matrix3<f64>,
    /// The calibration's bias, the network's, averaged over the last `average_s`, and what gravity tells beside them \[rad/s\]. Slow: no sample is to be corrected by less than this average.
    pub bias: Vector3<f64>,
    /// Deviation of the bias, by axis \[rad/s\]: what gravity leaves of how far training recordings' biases lie apart.
    pub deviation: Vector3<f64>,
    /// Whether the network has seen as much past as it looks at, all of it such as a sensor measures; else the bias is the calibration's.
    pub known: bool,
    /// Whether samples come at a rate more than 5 % off the network's; nothing is resampled.
    pub wrong_rate: bool,
}

/// A network that is fed samples.
#[derive(Debug)]
pub struct Running {
    model: Model,
    gate: Gate,
    /// By layer, the newest inputs, as many as its kernel spans, the oldest first; and how many came.
    past: Vec<(VecDeque<Vec<f32>>, usize)>,
    /// Samples since the network began.
    seen: usize,
    /// The last answer \[rad/s\], for it and the samples until the next.
    answer: Vector3<f64>,
    average: Average,
    mean: Option<Vector3<f64>>,
    gravity: Gravity,
    /// The newest sample's rate, by calibration and average, and its specific force.
    newest: [Vector3<f64>; 2],
}

impl Running {
    /// Before the first sample.
    pub fn new(model: Model) -> Self {
        let average = Average::over((model.card.config.average_s * model.card.rate.hz()) as usize);
        let gate = Gate::new(model.card.rate);
        let gravity = Gravity::new(&model.card.spread, model.card.config.speed.unwrap_or(0.0));
        let mut new = Self {
            model,
            gate,
            past: Vec::new(),
            seen: 0,
            answer: Vector3::zeros(),
            average,
            mean: None,
            gravity,
            newest: [Vector3::zeros(); 2],
        };
        new.begin();
        new
    }

    fn begin(&mut self) {
        self.past = network::layers(&self.model.parameters).map(|_| Default::default()).collect();
        self.seen = 0;
    }

    /// Takes the next sample.
    ///
    /// # Errors
    /// One that is not later than the last, or not finite; it changes nothing.
    pub fn feed(&mut self, sample: &ImuSample) -> Result<(), StreamError> {
        let before = self.gate.take(sample)?;
        let is_hole = |last: Stamp| sample.t.seconds_since(last) > HOLE * self.model.card.rate.period();
        if before.is_some_and(is_hole) {
            self.begin();
        }
        let axis = |i: usize| if i < 3 { sample.gyro[i] } else { sample.accel[i - 3] };
        let reading: Vec<f32> = (0..6).map(|i| self.model.seen(i, axis(i))).collect();
        if self.seen == 0 {
            // As if the first had stood still before.
            for _ in 1..network::PAST {
                self.push(reading.clone());
            }
        }
        self.push(reading);
        self.seen += 1;
        // NaN is below nothing.
        let is_a_bias = self.answer.amax() < MOST;
        if is_a_bias {
            self.average.push(self.answer);
        }
        let slow = self.average.mean();
        let newest = [self.model.card.affine.apply(&sample.gyro.into()) + slow, sample.accel.into()];
        if let Some(before) = before {
            let [rate, force] = [0, 1].map(|i| 0.5 * (self.newest[i] + newest[i]));
            self.gravity.push(&rate, &force, sample.t.seconds_since(before));
        }
        self.newest = newest;
        if !is_a_bias {
            self.mean = None;
        } else if self.seen >= network::PAST {
            self.mean = Some(slow);
        }
        Ok(())
    }

    /// One more instant; a new answer where the strides meet.
    fn push(&mut self, reading: Vec<f32>) {
        let mut column = reading;
        for (layer, (past, came)) in network::layers(&self.model.parameters).zip(&mut self.past) {
            past.push_back(column);
            *came += 1;
            let span = layer.span();
            if past.len() > span {
                past.pop_front();
            }
            if past.len() < span || !(*came - span).is_multiple_of(layer.stride) {
                return;
            }
            column = answer(&layer, past);
        }
        self.answer = UNIT * Vector3::from_fn(|i, _| f64::from(column[i]));
    }

    /// What holds at the newest sample.
    pub fn correction(&self) -> Correction {
        let affine = &self.model.card.affine;
        let (bias, deviation) = match self.mean {
            Some(mean) => (mean + self.gravity.bias(), self.gravity.deviation()),
            None => (Vector3::zeros(), beforehand(&self.model.card.spread)),
        };
        Correction {
            matrix: affine.matrix,
            bias: affine.bias + bias,
            deviation,
            known: self.mean.is_some(),
            wrong_rate: self.gate.wrong_rate(),
        }
    }
}

/// A layer's newest output.
fn answer(layer: &Layer<'_>, past: &VecDeque<Vec<f32>>) -> Vec<f32> {
    let mut sum = DVector::from_column_slice(layer.bias);
    for (tap, weights) in layer.taps.chunks_exact(layer.inputs * layer.outputs).enumerate() {
        let weights = DMatrixView::from_slice(weights, layer.outputs, layer.inputs);
        let input = DMatrixView::from_slice(&past[tap * layer.dilation], layer.inputs, 1);
        sum.gemv(1.0, &weights, &input.column(0), 1.0);
    }
    if !layer.is_last {
        sum.apply(|x| *x = network::activation(*x));
    }
    sum.data.into()
}

/// Means over so many values of past, fewer where there are no more.
#[derive(Debug)]
pub(crate) struct Average {
    past: usize,
    values: VecDeque<Vector3<f64>>,
    sum: Vector3<f64>,
}

impl Average {
    pub(crate) fn over(past: usize) -> Self {
        Self { past: past.max(1), values: VecDeque::new(), sum: Vector3::zeros() }
    }

    /// The mean with one value more.
    pub(crate) fn push(&mut self, value: Vector3<f64>) -> Vector3<f64> {
        self.sum += value;
        self.values.push_back(value);
        if self.values.len() > self.past {
            self.sum -= self.values.pop_front().expect("there is one");
        }
        self.mean()
    }

    /// The mean; nothing before the first value.
    pub(crate) fn mean(&self) -> Vector3<f64> {
        self.sum / self.values.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::{Course, simulated};
    use crate::gravity::steadied;
    use crate::{Affine, InertialConfig, Unknown, fit};
    use dpn_core::random;
    use rand::Rng;

    fn sample(course: &Course, i: usize) -> ImuSample {
        ImuSample {
            t: Stamp::from_ns(i as i64 * 5_000_000),
            gyro: course.gyro[i].into(),
            accel: course.accel[i].into(),
        }
    }

    /// A model with some answer, averaged over a second.
    fn case() -> (Course, Model) {
        let course = simulated(8.0, Matrix3::identity() * 1.02, Vector3::new(0.01, 0.0, -0.02), 0.01);
        let stream = random::Stream::new(3);
        let mut parameters = network::initial(&stream);
        let mut rng = stream.named("last").rng();
        let last = parameters.len() - 387;
        parameters[last..].iter_mut().for_each(|p| *p = rng.random_range(-0.3..0.3));
        let config = InertialConfig { average_s: 1.0, speed: Some(0.5), ..InertialConfig::default() };
        let fitted = fit(&[&course], Unknown::All).unwrap();
        let model = Model::new(&config, &fitted, std::slice::from_ref(&course), parameters);
        (course, model)
    }

    #[test]
    fn beside_samples_it_says_what_is_scored_over_a_recording() {
        let (course, model) = case();
        let mut average = Average::over(200);
        let means: Vec<_> = model.corrections(&course).into_iter().map(|c| average.push(c)).collect();
        assert!(means[1500].amax() > 1e-3, "no answer to compare: {}", means[1500]);
        let affine: Affine = model.card.affine;
        let calibrated: Vec<_> = course.gyro.iter().map(|reading| affine.apply(reading)).collect();
        let slow: Vec<_> = calibrated.iter().zip(&means).map(|(rate, mean)| rate + mean).collect();
        let steady = steadied(&course, &slow, &model.card.spread, 0.5);
        assert!((steady[1500][0] - slow[1500]).amax() > 1e-5, "gravity says nothing");
        let mut running = Running::new(model);
        for (i, (steady, calibrated)) in steady.iter().zip(&calibrated).enumerate() {
            let good = sample(&course, i);
            running.feed(&good).unwrap();
            assert!(
                running.feed(&good).is_err()
                    && running.feed(&ImuSample { gyro: [f64::NAN; 3], ..good }).is_err()
            );
            let found = running.correction();
            assert_eq!((found.known, found.matrix), (i + 1 >= network::PAST, affine.matrix));
            let (off, std) = if found.known {
                (steady[0] - calibrated, steady[2])
            } else {
                (Vector3::zeros(), Vector3::repeat(1.5e-3))
            };
            let wanted = affine.bias + off;
            assert!((found.deviation - std).amax() < 1e-12, "{i}: {} {std}", found.deviation);
            assert!((found.bias - wanted).amax() < 1e-7, "{i}: {} {wanted}", found.bias);
        }
        assert!(!running.correction().wrong_rate);
    }

    #[test]
    fn what_no_sensor_measures_is_not_averaged_and_a_hole_begins_anew() {
        let (course, model) = case();
        let bias = model.card.affine.bias;
        let mut running = Running::new(model);
        let feed = |running: &mut Running, range: std::ops::Range<usize>, scale: f64, late_ns: i64| {
            for i in range {
                let good = sample(&course, i);
                let t = Stamp::from_ns(good.t.ns() + late_ns);
                running.feed(&ImuSample { t, accel: good.accel.map(|a| a * scale), ..good }).unwrap();
            }
        };
        feed(&mut running, 0..600, 1.0, 0);
        let before = running.correction();
        assert!(before.known);
        for scale in [1e9, 1e307] {
            let mut other = Running::new(running.model.clone());
            feed(&mut other, 0..600, 1.0, 0);
            feed(&mut other, 600..601, scale, 0);
            let found = other.correction();
            assert!(!found.known || found.bias == before.bias, "{found:?}");
            feed(&mut other, 601..700, 1.0, 0);
            assert!(!other.correction().known && other.correction().bias == bias);
            feed(&mut other, 700..1200, 1.0, 0);
            assert!(other.correction().known && other.correction().bias.amax() < 0.1);
        }
        feed(&mut running, 600..601, 1.0, 3_000_000_000);
        assert!(running.correction().known && running.seen == 1);
    }
}
