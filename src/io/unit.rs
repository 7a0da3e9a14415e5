//! Units as data sheets and the columns of logs write them, by their dimension: `rad/s`, `mg`, `ms`, `mg/sqrt(Hz)`, `deg/s/√Hz`, `deg/sqrt(h)`, `(rad/s)^2/Hz`.
//!
//! A unit is a number of SI units and a dimension in angle, length and time. A degree per root hour (angle random walk) and a degree per
//! second per root hertz (density) have the same dimension: they are the same figure, a factor of 60 apart.

use std::fmt;

/// Standard gravity, the `g` in which data sheets and sensors count \[m/s^2\].
pub(crate) const STANDARD_GRAVITY: f64 = 9.806_65;

/// A degree and a whole turn \[rad\], a foot \[m\].
pub(crate) const DEGREE: f64 = std::f64::consts::PI / 180.0;
pub(crate) const TURN: f64 = std::f64::consts::TAU;
pub(crate) const FOOT: f64 = 0.3048;

/// Powers of angle, length and time, in halves: a root hertz is -1 of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Dimension {
    pub angle: i32,
    pub length: i32,
    pub time: i32,
}

impl Dimension {
    /// Of a time.
    pub(crate) const TIME: Self = Self::new(0, 0, 2);
    /// Of an angular rate.
    pub(crate) const RATE: Self = Self::new(2, 0, -2);
    /// Of an acceleration.
    pub(crate) const ACCELERATION: Self = Self::new(0, 2, -4);

    pub(crate) const fn new(angle: i32, length: i32, time: i32) -> Self {
        Self { angle, length, time }
    }
}

/// A unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    /// SI units in one of it.
    pub scale: f64,
    /// What it measures.
    pub dimension: Dimension,
    /// Whether hours stand in it, as in a bias instability.
    pub hours: bool,
}

impl Unit {
    /// Whether it is so many SI units of this dimension.
    pub(crate) fn is(&self, scale: f64, dimension: Dimension) -> bool {
        self.dimension == dimension && (self.scale / scale - 1.0).abs() < 1e-12
    }

    const ONE: Self = Self { scale: 1.0, dimension: Dimension::new(0, 0, 0), hours: false };

    fn times(self, other: Self, sign: i32) -> Self {
        let (a, b) = (self.dimension, other.dimension);
        Self {
            scale: self.scale * other.scale.powi(sign),
            dimension: Dimension::new(
                a.angle + sign * b.angle,
                a.length + sign * b.length,
                a.time + sign * b.time,
            ),
            hours: self.hours || other.hours,
        }
    }

    /// To the power `halves / 2`.
    fn power(self, halves: i32) -> Result<Self, UnitError> {
        let part = |v: i32| match v.checked_mul(halves) {
            Some(v) if v % 2 == 0 => Ok(v / 2),
            _ => Err(UnitError::Power),
        };
        let Dimension { angle, length, time } = self.dimension;
        Ok(Self {
            scale: self.scale.powf(f64::from(halves) / 2.0),
            dimension: Dimension::new(part(angle)?, part(length)?, part(time)?),
            hours: self.hours,
        })
    }
}

/// Why a text is no unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum UnitError {
    Unknown(String),
    Unexpected(String),
    Power,
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(word) => write!(f, "`{word}` is no unit known here"),
            Self::Unexpected(word) => write!(f, "`{word}` was not expected there"),
            Self::Power => f.write_str("a power that is no half or whole number"),
        }
    }
}

/// Reads a unit.
///
/// # Errors
/// Words that are no units; brackets that do not close.
pub(crate) fn parse(text: &str) -> Result<Unit, UnitError> {
    let tokens = tokens(text);
    let mut parser = Parser { tokens: &tokens, depth: 0 };
    let unit = parser.expression()?;
    match parser.tokens.first() {
        None => Ok(unit),
        Some(token) => Err(UnitError::Unexpected(token.clone())),
    }
}

/// Words, numbers and signs; spellings brought to one.
fn tokens(text: &str) -> Vec<String> {
    let text = text
        .replace('√', " sqrt ")
        .replace('°', " deg ")
        .replace(['µ', 'μ'], "u")
        .replace('²', "^2")
        .replace('³', "^3")
        .replace(['·', '*'], " ")
        .replace("**", "^");
    let mut tokens: Vec<String> = Vec::new();
    let kind = |c: char| {
        if c.is_alphabetic() {
            1
        } else if c.is_ascii_digit() || c == '.' {
            2
        } else {
            0
        }
    };
    let mut last = 0;
    for c in text.chars() {
        let this = kind(c);
        if c.is_whitespace() {
            last = 0;
            continue;
        }
        match tokens.last_mut() {
            Some(token) if this != 0 && this == last => token.push(c),
            _ => tokens.push(c.to_string()),
        }
        last = this;
    }
    tokens
}

struct Parser<'a> {
    tokens: &'a [String],
    depth: usize,
}

impl Parser<'_> {
    fn take(&mut self) -> Option<String> {
        let (first, rest) = self.tokens.split_first()?;
        self.tokens = rest;
        Some(first.clone())
    }

    fn next_is(&self, word: &str) -> bool {
        self.tokens.first().is_some_and(|t| t == word)
    }

    fn expression(&mut self) -> Result<Unit, UnitError> {
        self.depth += 1;
        if self.depth > 20 {
            return Err(UnitError::Unexpected("(".into()));
        }
        let mut unit = self.factor()?;
        while let Some(token) = self.tokens.first() {
            let sign = match token.as_str() {
                "/" | "per" => {
                    self.take();
                    -1
                }
                ")" => break,
                _ => 1,
            };
            unit = unit.times(self.factor()?, sign);
        }
        self.depth -= 1;
        Ok(unit)
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        let Some(word) = self.take() else {
            return Err(UnitError::Unexpected("the end".into()));
        };
        let unit = match word.as_str() {
            "(" => {
                let inner = self.expression()?;
                if self.take().as_deref() != Some(")") {
                    return Err(UnitError::Unexpected("(".into()));
                }
                inner
            }
            "sqrt" | "rt" | "root" => return self.factor()?.power(1),
            "rtHz" => return named("Hz").expect("the table has it").power(1),
            "1" | "rms" | "RMS" => Unit::ONE,
            word => named(word).ok_or_else(|| UnitError::Unknown(word.to_owned()))?,
        };
        if !self.next_is("^") {
            return Ok(unit);
        }
        self.take();
        let bracket = self.next_is("(");
        if bracket {
            self.take();
        }
        let halves = self.exponent()?;
        if bracket && self.take().as_deref() != Some(")") {
            return Err(UnitError::Unexpected("(".into()));
        }
        unit.power(halves)
    }

    /// `2`, `-1`, `0.5`, `1/2`: in halves.
    fn exponent(&mut self) -> Result<i32, UnitError> {
        let negative = self.next_is("-");
        if negative {
            self.take();
        }
        let number = self.take().and_then(|t| t.parse::<f64>().ok()).ok_or(UnitError::Power)?;
        let over_two = self.next_is("/") && self.tokens.get(1).is_some_and(|t| t == "2");
        if over_two {
            self.take();
            self.take();
        }
        let halves = number * if over_two { 1.0 } else { 2.0 };
        if halves.fract() != 0.0 || halves > 12.0 {
            return Err(UnitError::Power);
        }
        Ok(if negative { -(halves as i32) } else { halves as i32 })
    }
}

/// A unit by its name.
fn named(word: &str) -> Option<Unit> {
    let angle = Dimension::new(2, 0, 0);
    let length = Dimension::new(0, 2, 0);
    let (time, rate, accel) = (Dimension::TIME, Dimension::RATE, Dimension::ACCELERATION);
    let per_time = Dimension::new(0, 0, -2);
    let (scale, dimension) = match word {
        "rad" => (1.0, angle),
        "mrad" => (1e-3, angle),
        "urad" => (1e-6, angle),
        "deg" | "degree" | "degrees" | "d" => (DEGREE, angle),
        "mdeg" => (1e-3 * DEGREE, angle),
        "arcmin" => (DEGREE / 60.0, angle),
        "arcsec" => (DEGREE / 3600.0, angle),
        "dps" => (DEGREE, rate),
        "mdps" => (1e-3 * DEGREE, rate),
        "dph" => (DEGREE / 3600.0, rate),
        "rpm" | "RPM" => (TURN / 60.0, rate),
        "rev" => (TURN, angle),
        "m" => (1.0, length),
        "cm" => (1e-2, length),
        "mm" => (1e-3, length),
        "um" => (1e-6, length),
        "ft" | "feet" => (FOOT, length),
        "g" | "G" => (STANDARD_GRAVITY, accel),
        "mg" | "mG" => (1e-3 * STANDARD_GRAVITY, accel),
        "ug" | "uG" => (1e-6 * STANDARD_GRAVITY, accel),
        "s" | "sec" | "secs" | "second" | "seconds" => (1.0, time),
        "ms" | "msec" | "millis" | "milliseconds" => (1e-3, time),
        "us" | "usec" | "micros" | "microseconds" => (1e-6, time),
        "ns" | "nsec" | "nanos" | "nanoseconds" => (1e-9, time),
        "min" => (60.0, time),
        "h" | "hr" | "hour" | "hours" => (3600.0, time),
        "Hz" | "hz" => (1.0, per_time),
        "kHz" => (1e3, per_time),
        _ => return None,
    };
    Some(Unit { scale, dimension, hours: matches!(word, "h" | "hr" | "hour" | "hours" | "dph") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn same(a: &str, b: &str, ratio: f64) {
        let (x, y) = (parse(a).unwrap(), parse(b).unwrap());
        assert_eq!(x.dimension, y.dimension, "{a} {b}");
        assert!((x.scale / y.scale / ratio - 1.0).abs() < 1e-12, "{a} is {} of {b}", x.scale / y.scale);
    }

    #[test]
    fn spellings_of_one_unit_are_one_unit() {
        for spelling in [
            "rad/s/√Hz",
            "rad s^-1 Hz^-0.5",
            "rad/(s*sqrt(Hz))",
            "rad/s^0.5",
            "rad/s/Hz^(1/2)",
            "rad s^-1/2",
            "rad per sqrt(s)",
        ] {
            same(spelling, "rad/s/sqrt(Hz)", 1.0);
        }
        same("mdps/√Hz", "deg/s/sqrt(Hz)", 1e-3);
        same("m/s²/√Hz", "m s^-2/rtHz", 1.0);
        same("µg/√Hz", "mg/sqrt Hz", 1e-3);
        same("mg rms", "m/s^2", 9.806_65e-3);
    }

    #[test]
    fn a_random_walk_per_root_hour_is_a_sixtieth_of_a_density() {
        same("deg/sqrt(h)", "deg/s/sqrt(Hz)", 1.0 / 60.0);
        same("°/√hr", "rad/s/√Hz", std::f64::consts::PI / 180.0 / 60.0);
        same("m/s/sqrt(h)", "m/s^2/sqrt(Hz)", 1.0 / 60.0);
        same("deg/h/sqrt(h)", "deg/s^2/sqrt(Hz)", 1.0 / 216_000.0);
        same("deg^2/h", "(deg/s)^2/Hz", 1.0 / 3600.0);
    }

    #[test]
    fn what_is_no_unit_says_what_it_trips_over() {
        let error = |text| parse(text).unwrap_err().to_string();
        assert_eq!(error("furlong/s"), "`furlong` is no unit known here");
        assert_eq!(error("(rad/s"), "`(` was not expected there");
        assert_eq!(error("rad/s)"), "`)` was not expected there");
        assert_eq!(error("rad/"), "`the end` was not expected there");
        assert_eq!(error("rad^x"), "a power that is no half or whole number");
        assert_eq!(error("sqrt(sqrt(s))"), "a power that is no half or whole number");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[a-zA-Zµ√°²0-9()/^ *.-]{0,24}") {
            let _ = parse(&text);
        }
    }
}
