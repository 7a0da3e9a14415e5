//! The controls' arithmetic.

use dpn_core::random::Stream;
use dpn_core::time::median_step_ns;
use dpn_core::{ImuNoise, NoiseTrack, Sensor, Stamp};
use rand::seq::SliceRandom;

/// Length of the blocks that are permuted \[s\].
pub const BLOCK_S: f64 = 1.0;

/// The track's values permuted in time in blocks of [`BLOCK_S`] by the count of samples, the stamps kept: every value is still there,
/// once. The last block, if shorter, takes part.
pub fn shuffled(track: &NoiseTrack, stream: &Stream) -> NoiseTrack {
    let length = block_length(track.stamps());
    let mut blocks: Vec<&[ImuNoise]> = track.noises().chunks(length).collect();
    blocks.shuffle(&mut stream.rng());
    track.with_noises(blocks.concat())
}

/// Samples in a block, by the median step.
fn block_length(stamps: &[Stamp]) -> usize {
    let Some(median) = median_step_ns(stamps.iter().copied()) else { return 1 };
    ((BLOCK_S * 1e9 / median as f64).round() as usize).max(1)
}

/// Mean of squares per axis, summed in the order of the values.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeanSquare {
    sums: [[f64; 3]; 2],
    count: usize,
}

impl MeanSquare {
    /// Adds every value of a track.
    pub fn add(&mut self, track: &NoiseTrack) {
        for noise in track.noises() {
            for (sums, sensor) in self.sums.iter_mut().zip(Sensor::ALL) {
                for (sum, sigma) in sums.iter_mut().zip(noise.of(sensor)) {
                    *sum += sigma * sigma;
                }
            }
        }
        self.count += track.noises().len();
    }

    /// Adds another's values.
    pub fn merge(&mut self, other: &Self) {
        for (sums, more) in self.sums.iter_mut().flatten().zip(other.sums.iter().flatten()) {
            *sums += more;
        }
        self.count += other.count;
    }

    /// The root of the mean; `None` without values, or where the sum of their squares is beyond all numbers.
    pub fn root(&self) -> Option<ImuNoise> {
        let root = |sums: [f64; 3]| sums.map(|sum| (sum / self.count as f64).sqrt());
        ImuNoise::from_values(root(self.sums[0]), root(self.sums[1])).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn track(values: &[f64]) -> NoiseTrack {
        let stamps = (0..values.len()).map(|i| Stamp::from_ns(5_000_000 * i as i64)).collect();
        let noises =
            values.iter().map(|v| ImuNoise::from_values([*v, 2.0 * v, 3.0 * v], [v / 10.0; 3]).unwrap());
        NoiseTrack::new(stamps, noises.collect()).unwrap()
    }

    fn keys(track: &NoiseTrack) -> Vec<u64> {
        track.noises().iter().map(|n| n.of(Sensor::Accel)[1].to_bits()).collect()
    }

    proptest! {
        #[test]
        fn shuffling_keeps_every_value_and_every_stamp(values in prop::collection::vec(0.001f64..1.0, 1..900), seed: u64) {
            let before = track(&values);
            let after = shuffled(&before, &Stream::new(seed));
            prop_assert_eq!(after.stamps(), before.stamps());
            let (mut a, mut b) = (keys(&before), keys(&after));
            a.sort_unstable();
            b.sort_unstable();
            prop_assert_eq!(a, b);
        }

        #[test]
        fn the_mean_lies_between_the_extremes(values in prop::collection::vec(0.001f64..1.0, 1..50)) {
            let mut mean = MeanSquare::default();
            mean.add(&track(&values));
            let found = mean.root().unwrap().of(Sensor::Accel)[0];
            let (low, high) = (values.iter().copied().fold(1.0, f64::min), values.iter().copied().fold(0.0, f64::max));
            prop_assert!(low * (1.0 - 1e-12) <= found && found <= high * (1.0 + 1e-12));
        }
    }

    #[test]
    fn blocks_of_a_second_stay_whole() {
        let values: Vec<f64> = (0..2000).map(|i| f64::from(i + 1)).collect();
        let after = shuffled(&track(&values), &Stream::new(3));
        let found: Vec<f64> = after.noises().iter().map(|n| n.of(Sensor::Accel)[0]).collect();
        assert_ne!(found, values);
        for block in found.chunks(200) {
            assert!(block.windows(2).all(|w| w[1] - w[0] == 1.0));
        }
    }

    #[test]
    fn the_mean_of_a_constant_is_the_constant_and_of_two_levels_their_root_mean_square() {
        let mut mean = MeanSquare::default();
        assert_eq!(mean.root(), None);
        mean.add(&track(&[0.25; 400]));
        for sensor in Sensor::ALL {
            let (found, told) = (mean.root().unwrap().of(sensor), track(&[0.25]).noises()[0].of(sensor));
            assert!((0..3).all(|axis| (found[axis] - told[axis]).abs() < 1e-12), "{found:?} {told:?}");
        }
        mean.add(&track(&[0.5; 400]));
        let found = mean.root().unwrap().of(Sensor::Accel)[0];
        assert!((found - ((0.0625f64 + 0.25) / 2.0).sqrt()).abs() < 1e-15);
    }
}
