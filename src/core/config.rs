//! Checked configurations: bad values are named all at once, a mistyped word with the nearest known one.

pub use crate::gone::gone;
use std::fmt;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Numbers with more digits are written with an exponent.
const LONGEST_NUMBER: usize = 24;

/// One value outside its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfigFault {
    /// Key as written in the file, for example `augment.scale`.
    pub key: String,
    /// What stands there.
    pub value: String,
    /// What may stand there.
    pub bound: String,
}

impl ConfigFault {
    /// `key` holds `value`, but must be `bound`.
    pub fn new(key: impl Into<String>, value: impl fmt::Display, bound: impl Into<String>) -> Self {
        let mut value = value.to_string();
        // 1e300 would be three hundred digits.
        if value.len() > LONGEST_NUMBER
            && let Ok(number) = value.parse::<f64>()
        {
            value = format!("{number:e}");
        }
        Self { key: key.into(), value, bound: bound.into() }
    }
}

impl fmt::Display for ConfigFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is {}, but must be {}", self.key, self.value, self.bound)
    }
}

/// Faults gathered key by key; as an error there is at least one.
#[derive(Debug, Clone, PartialEq, Default, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
pub struct ConfigFaults(pub Vec<ConfigFault>);

impl ConfigFaults {
    /// Notes that `key` holds `value` but must be `bound`, unless `ok`.
    pub fn check(
        &mut self,
        ok: bool,
        key: impl Into<String>,
        value: impl fmt::Display,
        bound: impl Into<String>,
    ) {
        if !ok {
            self.0.push(ConfigFault::new(key, value, bound));
        }
    }

    /// Notes a fault unless `value` is positive and finite.
    pub fn positive(&mut self, key: impl Into<String>, value: f64) {
        self.check(value.is_finite() && value > 0.0, key, value, "positive and finite");
    }

    /// Notes a fault unless `value` is 0 or more, and finite.
    pub fn not_negative(&mut self, key: impl Into<String>, value: f64) {
        self.check(value.is_finite() && value >= 0.0, key, value, "0 or more, and finite");
    }

    /// Notes a fault unless both numbers of `pair` are `bound` by `within`, and the smaller stands first.
    pub fn pair(
        &mut self,
        key: impl Into<String>,
        pair: [f64; 2],
        within: impl Fn(f64) -> bool,
        bound: &str,
    ) {
        let ok = pair[0] <= pair[1] && pair.into_iter().all(within);
        self.check(ok, key, format!("{pair:?}"), format!("two numbers {bound}, the smaller first"));
    }

    /// Notes the faults of a table, each key behind the table's `name`.
    pub fn table(&mut self, name: &str, faults: Vec<ConfigFault>) {
        let named = |fault: ConfigFault| ConfigFault { key: format!("{name}.{}", fault.key), ..fault };
        self.0.extend(faults.into_iter().map(named));
    }

    /// Notes a fault unless `low <= value <= high`; so NaN is one.
    pub fn within<T: PartialOrd + fmt::Display>(
        &mut self,
        key: impl Into<String>,
        value: T,
        low: T,
        high: T,
    ) {
        let bound = format!("{low} to {high}");
        self.check((low..=high).contains(&value), key, value, bound);
    }
}

/// What a key of [`settings!`](crate::settings) may hold.
pub trait Bound<T> {
    /// Notes a fault unless `value` is within the bound.
    fn judge(self, key: &str, value: T, faults: &mut ConfigFaults);
}

impl<T: PartialOrd + fmt::Display + Copy> Bound<T> for RangeInclusive<T> {
    fn judge(self, key: &str, value: T, faults: &mut ConfigFaults) {
        faults.within(key, value, *self.start(), *self.end());
    }
}

/// A bound that is no range.
#[derive(Debug, Clone, Copy)]
pub enum Limit {
    /// Above 0, and finite.
    Positive,
    /// 0 or more, and finite.
    NotNegative,
    /// Above 0 and at most this.
    AtMost(f64),
}

impl Bound<f64> for Limit {
    fn judge(self, key: &str, value: f64, faults: &mut ConfigFaults) {
        match self {
            Self::Positive => faults.positive(key, value),
            Self::NotNegative => faults.not_negative(key, value),
            Self::AtMost(most) => {
                faults.check(value > 0.0 && value <= most, key, value, format!("above 0 and at most {most}"));
            }
        }
    }
}

impl From<ConfigFaults> for Vec<ConfigFault> {
    fn from(faults: ConfigFaults) -> Self {
        faults.0
    }
}

/// A configuration that can be checked after reading.
pub trait Validate {
    /// Every value outside its bound; empty when all is well.
    fn faults(&self) -> Vec<ConfigFault>;

    /// Refuses a configuration with faults.
    ///
    /// # Errors
    /// All of [`faults`](Self::faults).
    fn validate(&self) -> Result<(), ConfigFaults> {
        match self.faults() {
            faults if faults.is_empty() => Ok(()),
            faults => Err(ConfigFaults(faults)),
        }
    }
}

/// The word among `known` that is nearest to `typed`, when it is near enough to be a slip.
pub fn nearest<'a>(typed: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|word| (strsim::damerau_levenshtein(typed, word), word))
        .min()
        .filter(|(distance, word)| *distance <= 1 + word.len() / 3)
        .map(|(_, word)| word)
}

/// The question that a mistyped word is answered with, as a hint.
pub fn did_you_mean(word: impl fmt::Display) -> String {
    format!("did you mean `{word}`?")
}

/// The same behind a message, in brackets; empty where no word is near.
pub fn suggestion(word: Option<impl fmt::Display>) -> String {
    word.map(|word| format!(" ({})", did_you_mean(word))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_none_is_within_no_bounds() {
        let mut faults = ConfigFaults::default();
        faults.within("a", f64::NAN, 0.0, 1.0);
        faults.within("b", 1.0, 0.0, 1.0);
        assert_eq!(faults.to_string(), "`a` is NaN, but must be 0 to 1");
    }

    #[test]
    fn a_number_of_many_digits_is_written_with_its_exponent() {
        let said = |value: f64| ConfigFault::new("a", value, "1").value;
        assert_eq!([1e300, -1e-300, 1e12].map(said), ["1e300", "-1e-300", "1000000000000"]);
        assert_eq!(ConfigFault::new("a", u64::MAX, "1").value, "18446744073709551615");
    }

    #[test]
    fn the_nearest_word_is_near_or_none() {
        let names = ["sg", "diff1", "diff2", "running", "wavelet"];
        assert_eq!(nearest("dif2", names), Some("diff2"));
        assert_eq!(nearest("runing", names), Some("running"));
        assert_eq!(nearest("wavlet", names), Some("wavelet"));
        for far in ["covariance", "q", "zzz"] {
            assert_eq!(nearest(far, names), None, "{far}");
        }
    }
}
