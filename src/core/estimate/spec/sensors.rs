//! What is said of each sensor alone: multiples of the baseline, constants, simple estimators, the white noise that errs as much over a span.

use super::estimator::Arguments;
use super::{Call, EstimatorSpec, SpecError, names};
use crate::estimate::{
    AxisSigma, Effective, EffectiveStream, EstimatorError, Given, HopWindow, Schedule, Windowed,
};
use crate::imu::Sensor;
use crate::noise::{AccelSampleStd, Constant, GyroSampleStd, ImuNoise, NoiseModel};
use std::fmt;
use std::sync::Arc;

/// Where one sensor's noise comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorSpec {
    /// `x<factor>`: a multiple of the baseline.
    Multiple(f64),
    /// `const(value)`: a deviation per sample in the sensor's unit.
    Fixed(f64),
    /// A simple estimator.
    Estimator(EstimatorSpec),
    /// `effective(span)`: the white noise that errs as much over a span \[s\] as what the samples have.
    Effective(f64),
}

/// A camera's interval \[s\].
const FRAME_S: f64 = 0.1;

/// A source for each sensor, made of the samples so far alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPair {
    /// The accelerometer's.
    pub accel: SensorSpec,
    /// The gyroscope's.
    pub gyro: SensorSpec,
}

impl SensorPair {
    /// One call for both sensors, or one each.
    pub(super) fn from_calls(spec: &str, calls: &[Call]) -> Result<Self, SpecError> {
        match calls {
            [call] if call.name == "const" => constants(call),
            [call] => one_sensor(call).map(|both| Self { accel: both, gyro: both }),
            [accel, gyro] => Ok(Self { accel: one_sensor(accel)?, gyro: one_sensor(gyro)? }),
            _ => Err(SpecError::TooManyParts { spec: spec.to_owned(), calls: calls.len() }),
        }
    }

    /// Makes the model.
    ///
    /// # Errors
    /// Parameters out of range, a schedule too short for the estimator.
    pub fn model(&self, schedule: Schedule) -> Result<Box<dyn NoiseModel>, SpecError> {
        let Self { accel, gyro } = self;
        if let (Some(accel), Some(gyro)) = (accel.given(Sensor::Accel), gyro.given(Sensor::Gyro)) {
            let noise = ImuNoise::isotropic(AccelSampleStd::new(accel)?, GyroSampleStd::new(gyro)?);
            return Ok(Box::new(Constant::new(self.to_string(), noise)));
        }
        let (accel, gyro) = (accel.axes(Sensor::Accel, schedule)?, gyro.axes(Sensor::Gyro, schedule)?);
        Ok(Box::new(Windowed::new(self.to_string(), accel, gyro)))
    }

    /// Whether it says the same of every sample.
    pub fn is_constant(&self) -> bool {
        self.accel.given(Sensor::Accel).is_some() && self.gyro.given(Sensor::Gyro).is_some()
    }
}

impl SensorSpec {
    /// The deviation it gives beforehand, in the sensor's unit; `None` for an estimator.
    pub(super) fn given(&self, sensor: Sensor) -> Option<f64> {
        match self {
            Self::Multiple(factor) => Some(factor * ImuNoise::baseline().of(sensor)[0]),
            Self::Fixed(sigma) => Some(*sigma),
            Self::Estimator(_) | Self::Effective(_) => None,
        }
    }

    fn axes(&self, sensor: Sensor, schedule: Schedule) -> Result<[Box<dyn AxisSigma>; 3], SpecError> {
        let sigma = match self {
            Self::Estimator(estimator) => return Ok(estimator.axes(schedule)?),
            Self::Effective(span_s) => return Ok(effective(*span_s, schedule)?),
            Self::Multiple(factor) => factor * ImuNoise::baseline().of(sensor)[0],
            Self::Fixed(sigma) => *sigma,
        };
        // Checked here as in `model`: a spec may have been built by hand.
        let sigma = AccelSampleStd::new(sigma)?.get();
        Ok([Box::new(Given(sigma)), Box::new(Given(sigma)), Box::new(Given(sigma))])
    }
}

/// Three axes that share a plan.
fn effective(span_s: f64, schedule: Schedule) -> Result<[Box<dyn AxisSigma>; 3], EstimatorError> {
    let Schedule { window, hop, rate } = schedule;
    if window == 0 || hop == 0 {
        return Err(EstimatorError::EmptySchedule { window, hop });
    }
    let effective = Arc::new(Effective::sum(span_s, rate)?);
    // At a fast rate a spectrum has more samples than a window meant for 200 Hz.
    let window = window.max(effective.min_len());
    let axis = || {
        let stream = EffectiveStream::new(Arc::clone(&effective));
        Box::new(HopWindow::new(Box::new(stream), window, hop))
    };
    Ok([axis(), axis(), axis()])
}

/// `const(accel,gyro)` for both sensors.
fn constants(call: &Call) -> Result<SensorPair, SpecError> {
    let arguments = Arguments { call, usage: names::CONST_BOTH };
    match (positive(&arguments, 0, "deviation")?, positive(&arguments.at_most(2)?, 1, "deviation")?) {
        (Some(accel), Some(gyro)) => {
            Ok(SensorPair { accel: SensorSpec::Fixed(accel), gyro: SensorSpec::Fixed(gyro) })
        }
        _ => Err(arguments.wrong("both sensors' deviations are needed".to_owned())),
    }
}

fn positive(arguments: &Arguments<'_>, place: usize, what: &str) -> Result<Option<f64>, SpecError> {
    match arguments.number(place)? {
        Some(value) if value <= 0.0 => {
            Err(arguments.wrong(format!("{value} is no {what}; it must be above 0")))
        }
        other => Ok(other),
    }
}

fn one_sensor(call: &Call) -> Result<SensorSpec, SpecError> {
    if let Some(estimator) = EstimatorSpec::from_call(call)? {
        return Ok(SensorSpec::Estimator(estimator));
    }
    if call.name == "const" {
        let arguments = Arguments { call, usage: names::CONST_ONE }.at_most(1)?;
        let sigma = positive(&arguments, 0, "deviation")?;
        return sigma
            .map(SensorSpec::Fixed)
            .ok_or_else(|| arguments.wrong("the deviation is missing".to_owned()));
    }
    if call.name == "effective" {
        let arguments = Arguments { call, usage: names::EFFECTIVE }.at_most(1)?;
        return Ok(SensorSpec::Effective(positive(&arguments, 0, "span of seconds")?.unwrap_or(FRAME_S)));
    }
    if names::is_both(&call.name) {
        return Err(SpecError::NotOneSensor { call: call.to_string() });
    }
    if let Some(factor) = call.name.strip_prefix('x').and_then(|digits| digits.parse::<f64>().ok()) {
        let arguments = Arguments { call, usage: names::MULTIPLE }.at_most(0)?;
        if factor.is_finite() && factor > 0.0 {
            return Ok(SensorSpec::Multiple(factor));
        }
        return Err(arguments.wrong(format!("{factor} is no factor; it must be above 0 and finite")));
    }
    Err(names::unknown(&call.name))
}

impl fmt::Display for SensorSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Multiple(factor) => write!(f, "x{factor}"),
            Self::Fixed(sigma) => write!(f, "const({sigma})"),
            Self::Estimator(estimator) => write!(f, "{estimator}"),
            Self::Effective(span_s) => write!(f, "effective({span_s})"),
        }
    }
}

impl fmt::Display for SensorPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.accel, &self.gyro) {
            (SensorSpec::Fixed(accel), SensorSpec::Fixed(gyro)) => write!(f, "const({accel},{gyro})"),
            (accel, gyro) if accel == gyro => write!(f, "{accel}"),
            (accel, gyro) => write!(f, "{accel},{gyro}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(spec: &str) -> Result<SensorPair, SpecError> {
        SensorPair::from_calls(spec, &Call::parse_list(spec)?)
    }

    #[test]
    fn schedules_that_cannot_work_are_refused() {
        for (window, hop) in [(5, 0), (0, 1), (1, 1)] {
            let schedule = Schedule { window, hop, ..Schedule::default() };
            assert!(parse("mad2").unwrap().model(schedule).is_err(), "{window}, {hop}");
        }
    }

    #[test]
    fn what_is_written_reads_as_itself() {
        for (spec, canonical) in [
            ("x1", "x1"),
            ("x.5", "x0.5"),
            ("x4, x1", "x4,x1"),
            ("x2,x2", "x2"),
            ("const(.08,.004)", "const(0.08,0.004)"),
            ("const(.1),const(.01)", "const(0.1,0.01)"),
            ("const(.1),x2", "const(0.1),x2"),
            ("sg", "sg(11,2)"),
            ("sg(51,3),diff4", "sg(51,3),diff4"),
            ("wavelet(haar)", "wavelet(haar)"),
            ("running(2000)", "running(2000)"),
            ("ewma(0.02)", "ewma(0.02)"),
            ("kalman", "kalman(0.1)"),
            ("effective", "effective(0.1)"),
            ("effective(.05),x2", "effective(0.05),x2"),
        ] {
            let read = parse(spec).unwrap();
            assert_eq!(read.to_string(), canonical, "{spec}");
            assert_eq!(parse(canonical).unwrap(), read, "{spec}");
            let model = read.model(Schedule::default()).unwrap();
            assert_eq!(model.name(), canonical);
        }
        assert_eq!(EstimatorSpec::all().len(), names::ESTIMATORS.len());
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_nearest_and_the_list() {
        let text = parse("dif2").unwrap_err().to_string();
        assert!(text.contains("did you mean `diff2`?") && text.contains("ewma(alpha)"), "{text}");
        let text = parse("dualpronett").unwrap_err().to_string();
        assert!(text.contains("did you mean `dualpronet`?") && text.contains("dualpronet(tag)"), "{text}");
    }

    #[test]
    fn arguments_that_do_not_fit_are_refused_with_the_way_to_write_them() {
        for (spec, words) in [
            ("sg(11.5,2)", "sg(window,order)"),
            ("sg(1,2,3)", "at most 2"),
            ("diff2(3)", "at most 0"),
            ("wavelet(db77)", "`db77` is no known family"),
            ("const(.08)", "const(accel,gyro)"),
            ("const(0,.004)", "above 0"),
            ("x0", "above 0"),
            ("xinf", "finite"),
            ("x1,x2,x3", "3 parts"),
            ("ewma(high)", "no number"),
            ("effective(0)", "above 0"),
        ] {
            let text = parse(spec).unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
        for (spec, words) in [
            ("sg(10,2)", "9 and 11"),
            ("ewma(2)", "below 1"),
            ("sg(301,2)", "at least 301"),
            ("effective(0.001)", "one sample"),
        ] {
            let text = parse(spec).unwrap().model(Schedule::default()).map(|_| ()).unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
    }

    #[test]
    fn a_spec_built_by_hand_with_an_impossible_figure_is_refused_when_the_model_is_made() {
        let bad = SensorSpec::Fixed(-1.0);
        let estimator = SensorSpec::Estimator(EstimatorSpec::Mad2);
        for gyro in [SensorSpec::Multiple(1.0), estimator] {
            let spec = SensorPair { accel: bad, gyro };
            assert!(matches!(spec.model(Schedule::default()), Err(SpecError::Noise(_))));
        }
    }

    #[test]
    fn multiples_scale_the_baseline_of_their_sensor() {
        let SensorPair { accel, gyro } = parse("x4,x0.5").unwrap();
        assert_eq!(accel.given(Sensor::Accel), Some(0.32));
        assert_eq!(gyro.given(Sensor::Gyro), Some(0.002));
    }
}
