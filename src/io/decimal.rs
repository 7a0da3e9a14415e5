//! Decimal text to exact integers: stamps never pass through a float.

use dpn_core::named;
use dpn_core::time::Stamp;
use serde::{Deserialize, Serialize};

named!(
    /// Unit of a column of stamps.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    pub enum TimeUnit {
        /// Days, in which spreadsheets count from 1900 on and MATLAB from the year 0; stamps are rounded to a tenth of a microsecond.
        #[serde(rename = "days")]
        Days = "days",
        /// Seconds.
        #[serde(rename = "s")]
        Seconds = "s",
        /// Milliseconds.
        #[serde(rename = "ms")]
        Millis = "ms",
        /// Tenths of a millisecond, in which Xsens counts.
        #[serde(rename = "100us")]
        HundredMicros = "100us",
        /// Microseconds.
        #[serde(rename = "us")]
        Micros = "us",
        /// Tenths of a microsecond, in which Windows counts from 1601 on and .NET from the year 1; stamps are rounded to them.
        #[serde(rename = "100ns")]
        HundredNanos = "100ns",
        /// Nanoseconds.
        #[serde(rename = "ns")]
        Nanos = "ns",
    }
);

impl TimeUnit {
    /// The four units of most logs, longest first.
    pub(crate) const USUAL: [Self; 4] = [Self::Seconds, Self::Millis, Self::Micros, Self::Nanos];

    /// One of these in seconds.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Days => 86_400.0,
            Self::Seconds => 1.0,
            Self::Millis => 1e-3,
            Self::HundredMicros => 1e-4,
            Self::Micros => 1e-6,
            Self::HundredNanos => 1e-7,
            Self::Nanos => 1e-9,
        }
    }

    /// Power of ten that makes nanoseconds of it; of days, counts of 86.4 ns.
    fn power(self) -> i32 {
        match self {
            Self::Days => 12,
            Self::Seconds => 9,
            Self::Millis => 6,
            Self::HundredMicros => 5,
            Self::Micros => 3,
            Self::HundredNanos => 2,
            Self::Nanos => 0,
        }
    }
}

/// Reads a decimal such as `1403636625.363555670`, `12` or `1.5e3` as a stamp; `None` when it is none or out of range.
/// Exact to the nanosecond; what is finer is rounded, halves away from zero.
pub(crate) fn parse_stamp(text: &[u8], unit: TimeUnit) -> Option<Stamp> {
    // Nearly every stamp is a plain integer of nanoseconds that fits 18 digits or a few more.
    if unit == TimeUnit::Nanos && !text.is_empty() && text.len() <= 18 {
        let mut value = 0i64;
        if text.iter().all(|c| {
            value = value.wrapping_mul(10).wrapping_add(i64::from(c.wrapping_sub(b'0')));
            c.is_ascii_digit()
        }) {
            return Some(Stamp::from_ns(value));
        }
    }
    if unit == TimeUnit::HundredNanos {
        // Since the year 1, since 1601, or since a start: ns since either of the former are more than a stamp holds.
        let ticks = scaled(text, 0)?;
        let epoch = TICKS_UNTIL_1970.into_iter().find(|epoch| ticks > *epoch).unwrap_or_default();
        return (ticks - epoch).checked_mul(100).map(Stamp::from_ns);
    }
    let scaled = scaled(text, unit.power())?;
    if unit == TimeUnit::Days {
        let days = |epoch: i64| epoch * 10_i64.pow(12);
        let epoch = DAYS_UNTIL_1970.into_iter().map(days).find(|epoch| scaled > *epoch).unwrap_or_default();
        let ns = (i128::from(scaled - epoch) * 864 + 5).div_euclid(10);
        return i64::try_from(ns).ok().map(Stamp::from_ns);
    }
    Some(Stamp::from_ns(scaled))
}

/// Days from MATLAB's epoch and from a spreadsheet's until 1970.
pub(crate) const DAYS_UNTIL_1970: [i64; 2] = [719_529, 25_569];

/// Counts of 100 ns from .NET's epoch and from Windows' until 1970.
pub(crate) const TICKS_UNTIL_1970: [i64; 2] = [621_355_968_000_000_000, 116_444_736_000_000_000];

/// `text * 10^power` rounded to the nearest integer, halves away from zero.
fn scaled(text: &[u8], power: i32) -> Option<i64> {
    let (negative, mut rest) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    // Digits so far, and the power of ten their last one stands at. 36 significant digits are far more than 64 bits hold;
    // those beyond cannot change the result by more than the last rounding.
    let (mut digits, mut exponent) = (0u128, power);
    let (mut significant, mut seen, mut fraction) = (0u32, false, false);
    while let [c, tail @ ..] = rest {
        match c {
            b'0'..=b'9' => {
                seen = true;
                if significant < 36 {
                    digits = digits * 10 + u128::from(c - b'0');
                    significant += u32::from(digits > 0);
                    exponent = exponent.checked_sub(i32::from(fraction))?;
                } else {
                    exponent = exponent.checked_add(i32::from(!fraction))?;
                }
            }
            b'.' if !fraction => fraction = true,
            b'e' | b'E' if seen => {
                let given: i32 = std::str::from_utf8(tail).ok()?.parse().ok()?;
                exponent = exponent.checked_add(given)?;
                break;
            }
            _ => return None,
        }
        rest = tail;
    }
    if !seen {
        return None;
    }
    let size = if digits == 0 {
        0
    } else if exponent >= 0 {
        digits.checked_mul(10u128.checked_pow(exponent.unsigned_abs())?)?
    } else {
        match 10u128.checked_pow(exponent.unsigned_abs()) {
            Some(divisor) => digits / divisor + u128::from(digits % divisor >= divisor.div_ceil(2)),
            None => 0,
        }
    };
    let size = i128::try_from(size).ok()?;
    i64::try_from(if negative { -size } else { size }).ok()
}

/// Seconds with nine decimals: the text that [`parse_stamp`] turns back into the same nanoseconds.
pub(crate) fn seconds_text(t: Stamp) -> String {
    let ns = t.ns().unsigned_abs();
    let sign = if t.ns() < 0 { "-" } else { "" };
    format!("{sign}{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ns(text: &str, unit: TimeUnit) -> Option<i64> {
        parse_stamp(text.as_bytes(), unit).map(Stamp::ns)
    }

    #[test]
    fn seconds_at_unix_epoch_scale_keep_every_nanosecond() {
        assert_eq!(ns("1403636625.363555670", TimeUnit::Seconds), Some(1_403_636_625_363_555_670));
        assert_eq!(ns("1.403636625363555670e9", TimeUnit::Seconds), Some(1_403_636_625_363_555_670));
        assert_eq!(ns("1403636579758555392", TimeUnit::Nanos), Some(1_403_636_579_758_555_392));
    }

    #[test]
    fn what_is_finer_than_a_nanosecond_is_rounded() {
        assert_eq!(ns("0.0000000015", TimeUnit::Seconds), Some(2));
        assert_eq!(ns("-0.0000000015", TimeUnit::Seconds), Some(-2));
        assert_eq!(ns("0.00000000149999999999", TimeUnit::Seconds), Some(1));
        assert_eq!(ns("12.3456", TimeUnit::Micros), Some(12346));
        assert_eq!(ns(&format!("1.{}", "1".repeat(99)), TimeUnit::Seconds), Some(1_111_111_111));
        assert_eq!(ns("1e-400", TimeUnit::Seconds), Some(0));
    }

    #[test]
    fn days_count_from_a_spreadsheets_epoch_or_matlabs_or_a_start() {
        // Noon of 2023-10-01.
        for days in ["45200.5", "739160.5"] {
            assert_eq!(ns(days, TimeUnit::Days), Some(1_696_161_600_000_000_000));
        }
        assert_eq!(ns("45200.500000000058", TimeUnit::Days), Some(1_696_161_600_000_005_011));
        assert_eq!(ns("0.25", TimeUnit::Days), Some(21_600_000_000_000));
        assert_eq!(ns("-0.25", TimeUnit::Days), Some(-21_600_000_000_000));
    }

    #[test]
    fn what_is_no_number_or_out_of_range_is_no_stamp() {
        for bad in ["", "-", ".", "1.2.3", "e5", "1e", "1e99999999999", "nan", "0x10", "1 2", "１"] {
            assert_eq!(ns(bad, TimeUnit::Seconds), None, "{bad}");
        }
        assert_eq!(ns("9223372036854775807", TimeUnit::Nanos), Some(i64::MAX));
        assert_eq!(ns("-9223372036854775808", TimeUnit::Nanos), Some(i64::MIN));
        assert_eq!(ns("9223372036854775808", TimeUnit::Nanos), None);
        assert_eq!(ns("1e2147483647", TimeUnit::Seconds), None);
    }

    proptest! {
        #[test]
        fn seconds_text_comes_back_to_the_nanosecond(t in any::<i64>()) {
            let stamp = Stamp::from_ns(t);
            prop_assert_eq!(parse_stamp(seconds_text(stamp).as_bytes(), TimeUnit::Seconds), Some(stamp));
        }

        #[test]
        fn integers_agree_with_the_standard_library(t in any::<i64>()) {
            prop_assert_eq!(ns(&t.to_string(), TimeUnit::Nanos), Some(t));
        }
    }
}
