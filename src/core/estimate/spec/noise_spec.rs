//! What a noise spec means.

use super::estimator::{Arguments, USAGES};
use super::{Call, EstimatorSpec, SpecError};
use crate::config::nearest;
use crate::estimate::{AxisSigma, Given, Schedule, Windowed};
use crate::imu::Sensor;
use crate::noise::{AccelSampleStd, Constant, GyroSampleStd, ImuNoise, NoiseModel};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Where one sensor's noise comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorSpec {
    /// `x<factor>`: a multiple of the baseline.
    Multiple(f64),
    /// `const(value)`: a deviation per sample in the sensor's unit.
    Fixed(f64),
    /// A simple estimator.
    Estimator(EstimatorSpec),
}

/// A noise spec, parsed. `FromStr` and serde read it, `Display` writes it canonically.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum NoiseSpec {
    /// A source for each sensor, made by this crate.
    Sensors {
        /// The accelerometer's.
        accel: SensorSpec,
        /// The gyroscope's.
        gyro: SensorSpec,
    },
    /// A call whose name another crate has announced, untouched: that crate makes the model.
    Other(Call),
}

impl NoiseSpec {
    /// Reads `spec`, leaving calls whose name stands in `others` to the caller, as [`NoiseSpec::Other`].
    ///
    /// `others` pairs each name with how it is written, for the list in the message: `("mean", "mean(spec)")`.
    ///
    /// # Errors
    /// A broken grammar, an unknown name (the message lists all and names the nearest), arguments that do not fit.
    pub fn parse_with(spec: &str, others: &[(&str, &str)]) -> Result<Self, SpecError> {
        let calls = Call::parse_list(spec)?;
        match calls.as_slice() {
            [call] if others.iter().any(|(name, _)| *name == call.name) => Ok(Self::Other(call.clone())),
            [call] if call.name == "const" => constants(call),
            [call] => {
                let both = one_sensor(call, others)?;
                Ok(Self::Sensors { accel: both, gyro: both })
            }
            [accel, gyro] => {
                Ok(Self::Sensors { accel: one_sensor(accel, others)?, gyro: one_sensor(gyro, others)? })
            }
            _ => Err(SpecError::TooManyParts { spec: spec.to_owned(), calls: calls.len() }),
        }
    }

    /// Makes the model.
    ///
    /// # Errors
    /// Parameters out of range, a schedule too short for the estimator, a call of another crate.
    pub fn model(&self, schedule: Schedule) -> Result<Box<dyn NoiseModel>, SpecError> {
        let (accel, gyro) = match self {
            Self::Sensors { accel, gyro } => (accel, gyro),
            Self::Other(call) => {
                return Err(SpecError::MadeElsewhere { call: call.to_string() });
            }
        };
        let given = (accel.given(Sensor::Accel), gyro.given(Sensor::Gyro));
        if let (Some(accel), Some(gyro)) = given {
            let noise = ImuNoise::isotropic(AccelSampleStd::new(accel)?, GyroSampleStd::new(gyro)?);
            return Ok(Box::new(Constant::new(self.to_string(), noise)));
        }
        let (accel, gyro) = (accel.axes(Sensor::Accel, schedule)?, gyro.axes(Sensor::Gyro, schedule)?);
        Ok(Box::new(Windowed::new(self.to_string(), accel, gyro)))
    }
}

impl SensorSpec {
    /// The deviation it gives beforehand, in the sensor's unit; `None` for an estimator.
    pub fn given(&self, sensor: Sensor) -> Option<f64> {
        match self {
            Self::Multiple(factor) => Some(factor * ImuNoise::baseline().of(sensor)[0]),
            Self::Fixed(sigma) => Some(*sigma),
            Self::Estimator(_) => None,
        }
    }

    fn axes(&self, sensor: Sensor, schedule: Schedule) -> Result<[Box<dyn AxisSigma>; 3], SpecError> {
        match self {
            Self::Estimator(estimator) => Ok(estimator.axes(schedule)?),
            Self::Multiple(_) | Self::Fixed(_) => {
                // Checked here as in `model`: a spec may have been built by hand.
                let sigma = AccelSampleStd::new(self.given(sensor).unwrap_or(f64::NAN))?.get();
                Ok([Box::new(Given(sigma)), Box::new(Given(sigma)), Box::new(Given(sigma))])
            }
        }
    }
}

const CONST_BOTH: &str = "const(accel,gyro)";
const CONST_ONE: &str = "const(value)";
const MULTIPLE: &str = "x<factor>";

/// `const(accel,gyro)` for both sensors.
fn constants(call: &Call) -> Result<NoiseSpec, SpecError> {
    let arguments = Arguments { call, usage: CONST_BOTH };
    match (positive(&arguments, 0)?, positive(&arguments.at_most(2)?, 1)?) {
        (Some(accel), Some(gyro)) => {
            Ok(NoiseSpec::Sensors { accel: SensorSpec::Fixed(accel), gyro: SensorSpec::Fixed(gyro) })
        }
        _ => Err(arguments.wrong("both sensors' deviations are needed".to_owned())),
    }
}

fn positive(arguments: &Arguments<'_>, place: usize) -> Result<Option<f64>, SpecError> {
    match arguments.number(place)? {
        Some(value) if value <= 0.0 => {
            Err(arguments.wrong(format!("{value} is no deviation; it must be above 0")))
        }
        other => Ok(other),
    }
}

fn one_sensor(call: &Call, others: &[(&str, &str)]) -> Result<SensorSpec, SpecError> {
    if let Some(estimator) = EstimatorSpec::from_call(call)? {
        return Ok(SensorSpec::Estimator(estimator));
    }
    if call.name == "const" {
        let arguments = Arguments { call, usage: CONST_ONE }.at_most(1)?;
        let sigma = positive(&arguments, 0)?;
        return sigma
            .map(SensorSpec::Fixed)
            .ok_or_else(|| arguments.wrong("the deviation is missing".to_owned()));
    }
    if others.iter().any(|(name, _)| *name == call.name) {
        return Err(SpecError::NotOneSensor { call: call.to_string() });
    }
    if let Some(factor) = call.name.strip_prefix('x').and_then(|digits| digits.parse::<f64>().ok()) {
        let arguments = Arguments { call, usage: MULTIPLE }.at_most(0)?;
        if factor.is_finite() && factor > 0.0 {
            return Ok(SensorSpec::Multiple(factor));
        }
        return Err(arguments.wrong(format!("{factor} is no factor; it must be above 0 and finite")));
    }
    let names = USAGES.iter().chain(others).map(|(name, _)| *name).chain(["const", "x1"]);
    let usages = USAGES.iter().chain(others).map(|(_, usage)| (*usage).to_owned());
    Err(SpecError::Unknown {
        name: call.name.clone(),
        nearest: nearest(&call.name, names).map(str::to_owned),
        known: [MULTIPLE, CONST_BOTH].map(str::to_owned).into_iter().chain(usages).collect(),
    })
}

impl FromStr for NoiseSpec {
    type Err = SpecError;

    fn from_str(spec: &str) -> Result<Self, SpecError> {
        Self::parse_with(spec, &[])
    }
}

impl TryFrom<String> for NoiseSpec {
    type Error = SpecError;

    fn try_from(spec: String) -> Result<Self, SpecError> {
        spec.parse()
    }
}

impl From<NoiseSpec> for String {
    fn from(spec: NoiseSpec) -> Self {
        spec.to_string()
    }
}

impl fmt::Display for SensorSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Multiple(factor) => write!(f, "x{factor}"),
            Self::Fixed(sigma) => write!(f, "const({sigma})"),
            Self::Estimator(estimator) => write!(f, "{estimator}"),
        }
    }
}

impl fmt::Display for NoiseSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensors { accel: SensorSpec::Fixed(accel), gyro: SensorSpec::Fixed(gyro) } => {
                write!(f, "const({accel},{gyro})")
            }
            Self::Sensors { accel, gyro } if accel == gyro => write!(f, "{accel}"),
            Self::Sensors { accel, gyro } => write!(f, "{accel},{gyro}"),
            Self::Other(call) => write!(f, "{call}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(spec: &str) -> Result<NoiseSpec, SpecError> {
        spec.parse()
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
        ] {
            let read = parse(spec).unwrap();
            assert_eq!(read.to_string(), canonical, "{spec}");
            assert_eq!(parse(canonical).unwrap(), read, "{spec}");
            let model = read.model(Schedule::default()).unwrap();
            assert_eq!(model.name(), canonical);
        }
        assert_eq!(EstimatorSpec::all().len(), USAGES.len());
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_nearest_and_the_list() {
        let text = parse("dif2").unwrap_err().to_string();
        assert!(text.contains("did you mean `diff2`?") && text.contains("ewma(alpha)"), "{text}");
        let text = NoiseSpec::parse_with("dualpronett", &[("dualpronet", "dualpronet(model)")])
            .unwrap_err()
            .to_string();
        assert!(text.contains("did you mean `dualpronet`?") && text.contains("dualpronet(model)"), "{text}");
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
        ] {
            let text = parse(spec).unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
        for (spec, words) in [("sg(10,2)", "9 and 11"), ("ewma(2)", "below 1"), ("sg(301,2)", "at least 301")]
        {
            let text = parse(spec).unwrap().model(Schedule::default()).map(|_| ()).unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
    }

    #[test]
    fn another_crates_call_comes_back_whole_and_is_not_made_here() {
        let spec =
            NoiseSpec::parse_with("shuffled(sg(11,2),7)", &[("shuffled", "shuffled(spec,seed)")]).unwrap();
        let NoiseSpec::Other(call) = &spec else { panic!("{spec:?}") };
        assert_eq!(call.args.len(), 2);
        assert!(matches!(spec.model(Schedule::default()), Err(SpecError::MadeElsewhere { .. })));
        let pair = NoiseSpec::parse_with("shuffled(x1),x2", &[("shuffled", "")]);
        assert!(matches!(pair, Err(SpecError::NotOneSensor { .. })));
    }

    #[test]
    fn a_spec_built_by_hand_with_an_impossible_figure_is_refused_when_the_model_is_made() {
        let bad = SensorSpec::Fixed(-1.0);
        let estimator = SensorSpec::Estimator(EstimatorSpec::Mad2);
        for gyro in [SensorSpec::Multiple(1.0), estimator] {
            let spec = NoiseSpec::Sensors { accel: bad, gyro };
            assert!(matches!(spec.model(Schedule::default()), Err(SpecError::Noise(_))));
        }
    }

    #[test]
    fn multiples_scale_the_baseline_of_their_sensor() {
        let NoiseSpec::Sensors { accel, gyro } = parse("x4,x0.5").unwrap() else { panic!() };
        assert_eq!(accel.given(Sensor::Accel), Some(0.32));
        assert_eq!(gyro.given(Sensor::Gyro), Some(0.002));
    }
}
