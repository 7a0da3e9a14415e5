//! What the windows of a raw recording hold by themselves of the noise that sums feel.
//!
//! A recording's reconciled truth (`dpn truth`) says one level for all of it: the white noise that errs as much between two keys of .1 s. Along the recording the level follows
//! the vibration, so a window has of it what its roughness is of the recording's, and no less than the quietest windows, where the sensor's own white noise is all there is.

use dpn_core::SampleRate;
use dpn_core::signal::stats::quantile;
use std::collections::BTreeMap;

/// Share of the windows that are quieter than what counts as the sensor's own noise.
const QUIET: f64 = 0.01;

/// Levels of the sequences of a set of windows.
#[derive(Debug, Clone)]
pub(crate) struct FlightNoise {
    /// A sequence's level over its windows' roughness, root mean square.
    shares: Vec<f64>,
    quiet: f64,
}

impl FlightNoise {
    /// From all windows, samples of `rate`, of the sequences `names`, each with its sequence's number, and the sequences' levels, densities.
    ///
    /// # Panics
    /// When a sequence has no level.
    pub(crate) fn of<'a>(
        names: &[String],
        windows: impl Iterator<Item = (usize, &'a [f64])>,
        levels: &BTreeMap<String, f64>,
        rate: SampleRate,
    ) -> Self {
        let mut squares = vec![(0.0, 0.0); names.len()];
        let mut all = Vec::new();
        for (sequence, window) in windows {
            let roughness = roughness(window);
            let (sum, count) = &mut squares[sequence];
            (*sum, *count) = (*sum + roughness * roughness, *count + 1.0);
            all.push(roughness);
        }
        let share = |(name, (sum, count)): (&String, (f64, f64))| {
            levels[name] * rate.hz().sqrt() / (sum / count).sqrt()
        };
        let shares = names.iter().zip(squares).map(share).collect();
        Self { shares, quiet: quantile(&all, QUIET) }
    }

    /// Of a window of sequence number `sequence`.
    pub(crate) fn sigma(&self, sequence: usize, window: &[f64]) -> f64 {
        let roughness = roughness(window);
        (self.shares[sequence] * roughness).max(self.quiet.min(roughness))
    }
}

/// Root mean square of the second differences over that of white noise of deviation 1.
fn roughness(window: &[f64]) -> f64 {
    let squares = window.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).powi(2)).sum::<f64>();
    (squares / (6 * (window.len() - 2)) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::inject;
    use dpn_core::random::Stream;

    #[test]
    fn the_level_is_spread_over_a_recording_by_its_roughness_and_rest_keeps_the_sensors_own() {
        // A second in ten rests at .02; the others shake by 1.
        let window = |second: u64| {
            let mut part = vec![0.0; 200];
            let sigma = if second.is_multiple_of(10) { 0.02 } else { 1.0 };
            inject(&mut part, sigma, &mut Stream::new(1).index(second).rng());
            part
        };
        let windows: Vec<Vec<f64>> = (0..600).map(window).collect();
        let levels = BTreeMap::from([("a".to_owned(), 0.3 / 200f64.sqrt())]);
        let all = windows.iter().map(|window| (0, window.as_slice()));
        let noise = FlightNoise::of(&["a".to_owned()], all, &levels, SampleRate::HZ_200);
        let square =
            windows.iter().map(|window| noise.sigma(0, window).powi(2)).sum::<f64>() / windows.len() as f64;
        assert!((square.sqrt() / 0.3 - 1.0).abs() < 0.02, "{}", square.sqrt());
        let rest = noise.sigma(0, &windows[0]);
        assert!((0.014..0.022).contains(&rest), "{rest}");
    }
}
