//! Axes: range, linear or logarithmic, ticks at round numbers.

/// How values are laid along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    /// Equal differences, equal lengths.
    Linear,
    /// Equal ratios, equal lengths.
    Log,
}

/// One axis of a panel: label with unit, range, ticks with their words.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) scale: Scale,
    low: f64,
    high: f64,
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis that holds `low..=high` exactly, with about `count` ticks.
    pub(super) fn linear(label: String, low: f64, high: f64, count: usize) -> Self {
        let (low, high) = if high > low { (low, high) } else { (low - 0.5, low + 0.5) };
        Self { label, scale: Scale::Linear, low, high, ticks: linear_ticks(low, high, count) }
    }

    /// A logarithmic axis over `low..=high`, both positive.
    pub(super) fn log(label: String, low: f64, high: f64) -> Self {
        let low = if low > 0.0 { low } else { f64::MIN_POSITIVE.sqrt() };
        let high = if high > low { high } else { low * 10.0 };
        Self { label, scale: Scale::Log, low, high, ticks: log_ticks(low, high) }
    }

    /// Where `value` lies: 0 at the low end, 1 at the high end; values outside are held at the ends.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let at = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value <= self.low => 0.0,
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        at.clamp(0.0, 1.0)
    }

    /// The value at a fraction of the axis.
    pub(super) fn at(&self, fraction: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.low + fraction * (self.high - self.low),
            Scale::Log => self.low * (self.high / self.low).powf(fraction),
        }
    }

    /// Lower end.
    pub(super) fn low(&self) -> f64 {
        self.low
    }

    /// Upper end.
    pub(super) fn high(&self) -> f64 {
        self.high
    }
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten: the finest step that gives at most `count`.
fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<(f64, String)> {
    let raw = (high - low) / count.max(1) as f64;
    let power = raw.log10().floor() as i32;
    let (mantissa, power) = [1, 2, 5]
        .into_iter()
        .map(|m| (m, power))
        .chain([(1, power + 1)])
        .find(|&(m, p)| f64::from(m) * 10f64.powi(p) >= raw * (1.0 - 1e-9))
        .unwrap_or((1, power + 1));
    let step = f64::from(mantissa) * 10f64.powi(power);
    // Between numbers whose distance has no root there is no tick.
    if !step.is_normal() {
        return Vec::new();
    }
    let decimals = (-power).max(0) as usize;
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            (value, minus(format!("{value:.decimals$}")))
        })
        .collect()
}

/// Ticks at 1, 2, 5 times powers of ten; all digits, or powers alone, where that gives too few or too many.
fn log_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    const FEW: usize = 3;
    const MANY: usize = 9;
    let at = |digits: &[u8]| -> Vec<(f64, String)> {
        (low.log10().floor() as i32..=high.log10().ceil() as i32)
            .flat_map(|power| digits.iter().map(move |&digit| decimal(digit, power)))
            .filter(|(value, _)| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(value))
            .collect()
    };
    let usual = at(&[1, 2, 5]);
    match usual.len() {
        n if n < FEW => {
            let all = at(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
            if all.len() < FEW { linear_ticks(low, high, 4) } else { all }
        }
        n if n > MANY => at(&[1]),
        _ => usual,
    }
}

/// `digit * 10^power`, and its words: plain decimals where they are short, else as a power.
fn decimal(digit: u8, power: i32) -> (f64, String) {
    let value = f64::from(digit) * 10f64.powi(power);
    let words = match power {
        -4..=-1 => format!("{value:.*}", power.unsigned_abs() as usize),
        0..=4 => format!("{value:.0}"),
        _ => format!("{digit}e{power}"),
    };
    (value, words)
}

/// A tick's words with a minus sign instead of a hyphen, and no negative zero.
fn minus(words: String) -> String {
    match words.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, words)| words.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let axis = Axis::linear(String::new(), 0.0, 0.22, 6);
        assert_eq!(words(&axis), ["0.00", "0.05", "0.10", "0.15", "0.20"]);
        let axis = Axis::linear(String::new(), -12.0, 31.0, 5);
        assert_eq!(words(&axis), ["\u{2212}10", "0", "10", "20", "30"]);
        let axis = Axis::linear(String::new(), 0.0, 0.0155, 6);
        assert_eq!(words(&axis), ["0.000", "0.005", "0.010", "0.015"]);
    }

    #[test]
    fn log_ticks_are_one_two_five() {
        let axis = Axis::log(String::new(), 0.009, 0.23);
        assert_eq!(words(&axis), ["0.01", "0.02", "0.05", "0.10", "0.20"].map(trim));
        let axis = Axis::log(String::new(), 1e-4, 10.0);
        assert_eq!(words(&axis), ["0.0001", "0.001", "0.01", "0.1", "1", "10"]);
    }

    fn trim(words: &'static str) -> &'static str {
        words.trim_end_matches('0')
    }

    #[test]
    fn fractions_are_held_inside() {
        let axis = Axis::log(String::new(), 0.01, 1.0);
        assert!((axis.fraction(0.1) - 0.5).abs() < 1e-12);
        assert_eq!((axis.fraction(0.0), axis.fraction(7.0)), (0.0, 1.0));
        assert_eq!(axis.fraction(-3.0), 0.0);
        assert!((axis.at(axis.fraction(0.37)) - 0.37).abs() < 1e-12);
        let flat = Axis::linear(String::new(), 2.0, 2.0, 4);
        assert!((flat.fraction(2.0) - 0.5).abs() < 1e-12);
    }
}
