//! What the windows of a raw recording hold by themselves of the noise that sums feel.
//!
//! A recording's reconciled truth (`dpn truth`) says one level for all of it: the white noise that errs as much between two keys of .1 s. Along the recording the level follows
//! the vibration, so a window has of it what its roughness is of the recording's, and no less than the quietest windows, where the sensor's own white noise is all there is.

use crate::windows::WindowSet;
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
    /// From all windows, samples of `rate`, of the recordings and their levels by name, densities.
    ///
    /// # Panics
    /// When a recording has no level.
    pub(crate) fn of(whole: &WindowSet, levels: &BTreeMap<String, f64>, rate: SampleRate) -> Self {
        let mut squares = vec![(0.0, 0.0); whole.sequences().len()];
        let mut all = Vec::with_capacity(whole.len());
        for index in 0..whole.len() {
            let roughness = roughness(whole.raw(index, 0));
            let (sum, count) = &mut squares[whole.sequence_number(index)];
            (*sum, *count) = (*sum + roughness * roughness, *count + 1.0);
            all.push(roughness);
        }
        let share = |(name, (sum, count)): (&String, (f64, f64))| {
            levels[name] * rate.hz().sqrt() / (sum / count).sqrt()
        };
        let shares = whole.sequences().iter().zip(squares).map(share).collect();
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
    use crate::base::Base;
    use crate::draw::inject;
    use crate::windows::Stretch;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, SampleRate, Sensor, Stamp};

    #[test]
    fn the_level_is_spread_over_a_recording_by_its_roughness_and_rest_keeps_the_sensors_own() {
        // A second in ten rests at .02; the others shake by 1.
        let axis = |axis: u64| {
            let mut x = vec![0.0; 40_000];
            for (second, part) in x.chunks_mut(200).enumerate() {
                let sigma = if second % 10 == 0 { 0.02 } else { 1.0 };
                inject(part, sigma, &mut Stream::new(axis).index(second as u64).rng());
            }
            x
        };
        let [x, y, z] = [1, 2, 3].map(axis);
        let sample = |i: usize| ImuSample {
            t: Stamp::from_ns(5_000_000 * i as i64),
            gyro: [0.0; 3],
            accel: [x[i], y[i], z[i]],
        };
        let recording = ImuRecording::new((0..40_000).map(sample).collect()).unwrap();
        let set =
            WindowSet::cut(&[("a", &recording)], Sensor::Accel, Base::Raw, Stretch::Whole, 200).unwrap();
        let noise = FlightNoise::of(
            &set,
            &BTreeMap::from([("a".to_owned(), 0.3 / 200f64.sqrt())]),
            SampleRate::HZ_200,
        );
        let square =
            (0..set.len()).map(|i| noise.sigma(0, set.raw(i, 0)).powi(2)).sum::<f64>() / set.len() as f64;
        assert!((square.sqrt() / 0.3 - 1.0).abs() < 0.02, "{}", square.sqrt());
        let rest = noise.sigma(0, set.raw(0, 0));
        assert!((0.014..0.022).contains(&rest), "{rest}");
    }
}
