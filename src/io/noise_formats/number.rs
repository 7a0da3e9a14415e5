//! Numbers as every reader of YAML and JSON takes them.

use dpn_core::noise::Axes;

/// `value` with up to eight significant digits.
///
/// A small or large number is written with a point and a signed exponent (`3.0e-6`, not `3e-6`), because PyYAML, which Kalibr reads its
/// files with, takes `3e-6` for a word.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value:?}");
    }
    // Rounded to eight digits, then in the shortest form of that.
    let rounded: f64 = format!("{value:.7e}").parse().expect(OWN_TEXT);
    if (1e-3..1e6).contains(&rounded.abs()) {
        return format!("{rounded:?}");
    }
    let text = format!("{rounded:e}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// Why reading back what was just written cannot fail.
const OWN_TEXT: &str = "a number as Rust writes it is one that Rust reads";

/// The same with four significant digits, for people.
pub(super) fn short(value: f64) -> String {
    number(format!("{value:.3e}").parse().expect(OWN_TEXT))
}

/// Numbers of one figure as they stand in files.
pub(super) trait AxesText {
    /// Three numbers.
    fn each_text(self) -> Vec<String>;
    /// One number, or three in brackets.
    fn text(self) -> String;
}

impl AxesText for Axes<f64> {
    fn each_text(self) -> Vec<String> {
        self.each().map(number).to_vec()
    }

    fn text(self) -> String {
        match self {
            Self::Same(value) => number(value),
            Self::Each(_) => format!("[{}]", self.each_text().join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_a_point_and_a_signed_exponent() {
        let cases = [
            (3e-3, "0.003"),
            (3e-6, "3.0e-6"),
            (1.9393e-5, "1.9393e-5"),
            (0.002 * 200f64.sqrt(), "0.028284271"),
            (200.0, "200.0"),
            (1e9, "1.0e+9"),
            (0.0, "0.0"),
            (0.1 + 0.2, "0.3"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
            assert!((text.parse::<f64>().unwrap() - value).abs() <= 1e-7 * value);
        }
        assert_eq!(short(1.234567e-5), "1.235e-5");
    }
}
