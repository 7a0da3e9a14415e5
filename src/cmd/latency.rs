//! The time from an image's arrival to its pose, over a run of any length: counts of tenths of a millisecond up to a second.

/// Steps a millisecond.
const STEPS: f64 = 10.0;
/// The last holds everything longer.
const COUNTS: usize = 10_001;

/// Times that were taken.
pub(super) struct Latency {
    counts: Vec<u64>,
}

impl Default for Latency {
    fn default() -> Self {
        Self { counts: vec![0; COUNTS] }
    }
}

impl Latency {
    pub(super) fn add(&mut self, seconds: f64) {
        let step = (1e3 * STEPS * seconds) as usize;
        self.counts[step.min(COUNTS - 1)] += 1;
    }

    /// The time \[ms\] that a share of them does not go beyond; none where there are none.
    pub(super) fn quantile_ms(&self, share: f64) -> Option<f64> {
        let all: u64 = self.counts.iter().sum();
        let rank = ((share * all as f64).ceil() as u64).max(1);
        let mut below = 0;
        let step = self.counts.iter().position(|count| {
            below += count;
            below >= rank
        })?;
        Some((step + 1) as f64 / STEPS)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_times_to_a_tenth_of_a_millisecond() {
        let mut latency = Latency::default();
        assert_eq!(latency.quantile_ms(0.5), None);
        (1..=100).for_each(|k| latency.add(1e-3 * f64::from(k) - 2e-5));
        assert_eq!([0.5, 0.99, 1.0].map(|share| latency.quantile_ms(share).unwrap()), [50.0, 99.0, 100.0]);
        latency.add(f64::INFINITY);
        assert_eq!(latency.quantile_ms(1.0), Some(1000.1));
    }
}
