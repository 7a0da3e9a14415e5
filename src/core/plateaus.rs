//! Tells a clipped signal from one that merely repeats its extreme values.

/// An extreme value at which a signal stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plateau {
    /// The value.
    pub value: f64,
    /// Samples of its longest stay.
    pub longest: usize,
    /// Index at which its first stay begins.
    pub first: usize,
}

/// Stays at the axis's highest or lowest value that clipping explains and chance does not: at least `LEAST` samples long, and either
/// entered or left by a jump of more than `JUMP` times the axis's resolution, or with `CROWD` times as many samples at the extreme as at
/// the values next to it on an axis that spans more than `SPAN` of them. A sensor at rest that reads two or three counts repeats its
/// extremes too, but spans little; a slow turn's peak is flat for a while, but the values next to it are about as frequent.
pub(crate) fn plateaus(signal: &[f64]) -> Vec<Plateau> {
    const LEAST: usize = 4;
    const JUMP: f64 = 8.0;
    const CROWD: usize = 4;
    const SPAN: f64 = 64.0;
    let resolution = resolution(signal);
    let (low, high) =
        signal.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let spans = high - low > SPAN * resolution;
    [low, high]
        .into_iter()
        .filter_map(|value| {
            let near = |v: &&f64| **v != value && (**v - value).abs() < 1.5 * resolution;
            let at = signal.iter().filter(|v| **v == value).count();
            let crowded = spans && at >= CROWD * signal.iter().filter(near).count();
            let mut found: Option<Plateau> = None;
            for (first, longest) in runs(signal, value) {
                let before = first.checked_sub(1).map(|i| signal[i]);
                let after = signal.get(first + longest).copied();
                let jumps = [before, after]
                    .into_iter()
                    .flatten()
                    .any(|beside| (beside - value).abs() > JUMP * resolution);
                if longest >= LEAST && (jumps || crowded) {
                    let plateau = found.get_or_insert(Plateau { value, longest, first });
                    plateau.longest = plateau.longest.max(longest);
                }
            }
            found
        })
        .collect()
}

/// First index and length of every run of `value`.
fn runs(signal: &[f64], value: f64) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = 0;
    for run in signal.chunk_by(|a, b| (*a == value) == (*b == value)) {
        if run[0] == value {
            runs.push((start, run.len()));
        }
        start += run.len();
    }
    runs
}

/// The smallest difference between two of the axis's values: a converter's count, or next to nothing where there is none.
fn resolution(signal: &[f64]) -> f64 {
    let mut sorted = signal.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    // Counts times a factor differ in their last bits; what is closer than that is one value.
    let rounding = 1e-9 * sorted[0].abs().max(sorted[sorted.len() - 1].abs());
    sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > rounding).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clipped_wave_stays_at_both_limits() {
        let wave: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.1).sin().clamp(-0.5, 0.75)).collect();
        let found = plateaus(&wave);
        assert_eq!(found.iter().map(|p| p.value).collect::<Vec<_>>(), [-0.5, 0.75]);
        // sin > .75 from .848 to 2.294 rad: steps 9 to 22.
        assert_eq!((found[1].first, found[1].longest), (9, 15));
    }

    #[test]
    fn neither_three_samples_nor_two_counts_nor_a_round_top_are_clipping() {
        assert_eq!(plateaus(&[0.0, 1.0, 100.0, 100.0, 100.0, 50.0, 0.5]), []);
        assert_eq!(plateaus(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]), []);
        let round: Vec<f64> = (0..4000).map(|i| ((f64::from(i) * 0.005).sin() * 500.0).round()).collect();
        assert_eq!(plateaus(&round), []);
    }
}
