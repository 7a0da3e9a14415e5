//! A noise figure with its unit, as data sheets and the command line give it.

use super::number::{number, short};
use super::step::Step;
use crate::unit::{self, Dimension};
use dpn_core::imu::Sensor;
use dpn_core::noise::Meaning;
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::time::SampleRate;
use thiserror::Error;

/// Why a text is no noise figure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum QuantityError {
    /// No number in front.
    #[error("\"{0}\" does not begin with a number")]
    NoNumber(String),
    /// A unit that cannot be read.
    #[error("\"{text}\": {problem}")]
    BadUnit {
        /// As typed.
        text: String,
        /// What is wrong.
        problem: String,
    },
    /// A number that no noise has.
    #[error("\"{0}\" is not above zero; noise is")]
    NotPositive(String),
    /// A unit that is none of this figure.
    #[error("\"{text}\" has no unit of {figure}: such are {known}")]
    WrongDimension {
        /// As typed.
        text: String,
        /// What it should be.
        figure: Figure,
        /// Units that it may have.
        known: &'static str,
    },
    /// A bias instability where white noise or a walk belongs.
    #[error(
        "\"{text}\" is a bias instability (the flat part of an Allan plot); it is no {figure}, and none follows from it"
    )]
    Instability {
        /// As typed.
        text: String,
        /// What was asked for.
        figure: Figure,
    },
    /// A figure per sample without a rate.
    #[error("\"{text}\" is per sample; it says nothing without the rate of the samples")]
    NeedsRate {
        /// As typed.
        text: String,
    },
}

impl QuantityError {
    /// What to do about it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::NoNumber(_) | Self::BadUnit { .. } | Self::WrongDimension { .. } => {
                "for example 0.2 mg/sqrt(Hz), 0.005 deg/s/sqrt(Hz), 0.3 deg/sqrt(h); a bare number is a density in SI units"
            }
            Self::NotPositive(_) => "leave the figure out where it is not known",
            Self::Instability { .. } => {
                "look for the random walk (deg/sqrt(h), mg/sqrt(Hz)) in the data sheet, or record a log at rest and ask `dpn allan`"
            }
            Self::NeedsRate { .. } => "add --rate HZ",
        }
    }
}

/// A number with a unit that is one of noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    text: String,
    value: f64,
    scale: f64,
    figure: Figure,
    meaning: Meaning,
}

impl Quantity {
    /// Reads `text` as `figure`; a bare number is a density in SI units.
    ///
    /// # Errors
    /// No number, a unit that is none of the figure's, a bias instability.
    pub fn parse(text: &str, figure: Figure) -> Result<Self, QuantityError> {
        let text = text.trim();
        let (digits, unit) = split(text);
        let Some(value) = digits.parse::<f64>().ok().filter(|v| v.is_finite()) else {
            return Err(QuantityError::NoNumber(text.to_owned()));
        };
        if value <= 0.0 {
            return Err(QuantityError::NotPositive(text.to_owned()));
        }
        let (scale, meaning) = if unit.is_empty() {
            let density = if figure.is_walk() { Meaning::WalkDensity } else { Meaning::Density };
            (1.0, density)
        } else {
            let unit = unit::parse(unit).map_err(|problem| QuantityError::BadUnit {
                text: text.to_owned(),
                problem: problem.to_string(),
            })?;
            (unit.scale, meaning_of(unit, figure, text)?)
        };
        if !(value * scale).is_normal() {
            return Err(QuantityError::NotPositive(text.to_owned()));
        }
        let text = if unit.is_empty() { format!("{digits} {}", figure.unit()) } else { text.to_owned() };
        Ok(Self { text, value, scale, figure, meaning })
    }

    /// Whether `text` is a zero, with or without a unit.
    pub(super) fn is_zero(text: &str) -> bool {
        split(text.trim()).0.parse::<f64>() == Ok(0.0)
    }

    /// Which figure it is.
    pub fn figure(&self) -> Figure {
        self.figure
    }

    /// Puts it into `figures` and says how, under `name`.
    ///
    /// # Errors
    /// A figure per sample without a rate.
    pub(super) fn into_figures(
        self,
        name: &str,
        figures: &mut ImuFigures,
        rate: Option<SampleRate>,
    ) -> Result<Vec<Step>, QuantityError> {
        let rate = match rate {
            Some(rate) => rate,
            None if self.meaning.needs_rate() => return Err(QuantityError::NeedsRate { text: self.text }),
            None => SampleRate::HZ_200, // densities do not ask
        };
        let si = self.value * self.scale;
        let unit = self.meaning.unit(self.figure);
        let mut steps = vec![Step {
            name: name.to_owned(),
            from: if self.scale == 1.0 {
                self.text.clone()
            } else {
                format!("{} * {}", self.text, number(self.scale))
            },
            result: format!("{} {unit}", number(si)),
            meaning: self.meaning.words(),
        }];
        let bad = |_| QuantityError::NotPositive(self.text.clone());
        figures.set(self.figure, self.meaning, Axes::Same(si), rate).map_err(bad)?;
        if let Some(density) = figures
            .density(self.figure)
            .filter(|_| !matches!(self.meaning, Meaning::Density | Meaning::WalkDensity))
        {
            steps.push(Step {
                name: name.to_owned(),
                from: self
                    .meaning
                    .to_density_words(&format!("{} {unit}", number(si)), &format!("{} Hz", short(rate.hz()))),
                result: format!("{} {}", number(density.largest()), self.figure.unit()),
                meaning: "density",
            });
        }
        Ok(steps)
    }
}

/// The number in front, and the rest.
fn split(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(|c| c.is_ascii_digit() || *c == b'.') {
            at += 1;
        }
        at
    };
    let sign = |at: usize| at + usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let mut end = digits(sign(0));
    if end > 0 && matches!(bytes.get(end), Some(b'e' | b'E')) {
        let after = sign(end + 1);
        if bytes.get(after).is_some_and(u8::is_ascii_digit) {
            end = digits(after);
        }
    }
    (&text[..end], text[end..].trim())
}

fn meaning_of(unit: unit::Unit, figure: Figure, text: &str) -> Result<Meaning, QuantityError> {
    // The dimension of one sample, in halves; a root hertz adds one of time, a walk takes two.
    let sample = match figure.sensor() {
        Sensor::Gyro => Dimension::new(2, 0, -2),
        Sensor::Accel => Dimension::new(0, 2, -4),
    };
    let is = |times: i32, time: i32| {
        unit.dimension
            == Dimension::new(times * sample.angle, times * sample.length, times * sample.time + time)
    };
    let instability = || QuantityError::Instability { text: text.to_owned(), figure };
    let wrong = |known| QuantityError::WrongDimension { text: text.to_owned(), figure, known };
    if figure.is_walk() {
        return match () {
            () if is(1, -1) => Ok(Meaning::WalkDensity),
            () if is(1, -2) => Ok(Meaning::WalkRateStd),
            () if is(1, 0) => Err(instability()),
            () => Err(wrong(match figure.sensor() {
                Sensor::Gyro => "rad/s^2/sqrt(Hz), deg/s/sqrt(s), deg/h/sqrt(h)",
                Sensor::Accel => "m/s^3/sqrt(Hz), mg/sqrt(s), mg/sqrt(h)",
            })),
        };
    }
    match () {
        () if is(1, 1) => Ok(Meaning::Density),
        () if is(1, 0) && unit.hours => Err(instability()),
        () if is(1, 0) => Ok(Meaning::SampleStd),
        () if is(2, 0) => Ok(Meaning::SampleVariance),
        () if is(2, 2) => Ok(Meaning::Power),
        () => Err(wrong(match figure.sensor() {
            Sensor::Gyro => "deg/s/sqrt(Hz), deg/sqrt(h), rad/s/sqrt(Hz); deg/s for one sample",
            Sensor::Accel => "mg/sqrt(Hz), m/s/sqrt(h), m/s^2/sqrt(Hz); mg or m/s^2 for one sample",
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn density(text: &str, figure: Figure) -> (f64, usize) {
        let mut figures = ImuFigures::default();
        let steps = Quantity::parse(text, figure)
            .unwrap()
            .into_figures("x", &mut figures, Some(SampleRate::HZ_200))
            .unwrap();
        (figures.density(figure).unwrap().largest(), steps.len())
    }

    /// ADIS16448: .0135 deg/s/sqrt(Hz), .66 deg/sqrt(h), .23 mg/sqrt(Hz), .11 m/s/sqrt(h); EuRoC's file rounds.
    #[test]
    fn the_data_sheet_of_eurocs_sensor_gives_eurocs_file() {
        for (text, wanted, off) in [
            ("0.66 deg/√hr", 1.92e-4, 0.01),
            ("0.0097 °/s/√Hz", 1.6968e-4, 0.003),
            ("0.0097deg/s/sqrt(Hz)", 1.6968e-4, 0.003),
        ] {
            let (got, _) = density(text, Figure::GyroWhite);
            assert!((got / wanted - 1.0).abs() < off, "{text}: {got}");
        }
        let (got, steps) = density("0.2039432 mg/sqrt(Hz)", Figure::AccelWhite);
        assert!((got - 2e-3).abs() < 1e-9);
        assert_eq!(steps, 1);
        let (got, steps) = density("2.8843 mg rms", Figure::AccelWhite);
        assert!((got - 2e-3).abs() < 1e-7, "{got}");
        assert_eq!(steps, 2);
    }

    #[test]
    fn what_is_no_figure_says_why() {
        let error = |text, figure| Quantity::parse(text, figure).unwrap_err().to_string();
        assert_eq!(
            error("14.5 deg/h", Figure::GyroWhite),
            "\"14.5 deg/h\" is a bias instability (the flat part of an Allan plot); it is no gyroscope noise, and none \
             follows from it"
        );
        assert!(error("0.25 mg", Figure::AccelWalk).contains("bias instability"));
        assert!(
            error("0.2 mg/sqrt(Hz)", Figure::GyroWhite)
                .contains("has no unit of gyroscope noise: such are deg/s/sqrt(Hz)")
        );
        assert_eq!(error("mg", Figure::AccelWhite), "\"mg\" does not begin with a number");
        assert_eq!(error("0 mg", Figure::AccelWhite), "\"0 mg\" is not above zero; noise is");
        assert!(error("1 parsec", Figure::AccelWhite).contains("`parsec` is no unit"));
        let figures = &mut ImuFigures::default();
        let bare = Quantity::parse("1 mg", Figure::AccelWhite).unwrap().into_figures("x", figures, None);
        assert_eq!(
            bare.unwrap_err().to_string(),
            "\"1 mg\" is per sample; it says nothing without the rate of the samples"
        );
    }

    #[test]
    fn the_number_is_told_from_the_unit() {
        assert_eq!(split("1e-3mg"), ("1e-3", "mg"));
        assert_eq!(split("2 eV"), ("2", "eV"));
        assert_eq!(split("+.5e2 deg/s"), ("+.5e2", "deg/s"));
        assert_eq!(split("√Hz"), ("", "√Hz"));
    }
}
