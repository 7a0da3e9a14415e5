//! Samples of a faster log as means over blocks, near the rate that networks were trained at.
//!
//! A mean of m samples of white noise has its deviation over the root of m, and below the blocks' rate the same density: nothing of slower noise and motion is folded, as it is where
//! every m-th sample is taken. Blocks hold whole samples: shares of samples at their ends would make neighbours alike, which is less than white. Where the rates have no whole ratio, blocks
//! come faster than in training, so that motion is slower beside them and white noise still white.

use crate::{ImuNoise, ImuSample, SampleRate, Sensor};

/// Largest share by which the rate of blocks may differ from that of the training.
const TOLERANCE: f64 = 0.05;
/// How many samples a block has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockLength(usize);

impl BlockLength {
    /// Of samples of `rate` for networks trained at `trained`; none where the rate is too slow.
    pub fn of(rate: SampleRate, trained: SampleRate) -> Option<Self> {
        let ratio = rate.hz() / trained.hz();
        let nearest = ratio.round().max(1.0);
        let whole = if (ratio / nearest - 1.0).abs() <= TOLERANCE { nearest } else { ratio.floor() };
        (whole >= 1.0).then_some(Self(whole as usize))
    }

    /// One sample a block.
    pub const ONE: Self = Self(1);

    /// Samples.
    pub fn samples(self) -> usize {
        self.0
    }

    /// Blocks a second of samples of `rate` \[Hz\].
    pub fn blocks_hz(self, rate: SampleRate) -> f64 {
        rate.hz() / self.0 as f64
    }

    /// Whether blocks of samples of `rate` come about as often as samples did in the training.
    pub fn meets(self, rate: SampleRate, trained: SampleRate) -> bool {
        (self.blocks_hz(rate) / trained.hz() - 1.0).abs() <= TOLERANCE
    }

    /// Deviation of one sample over that of a block's mean, of white noise.
    pub fn gain(self) -> f64 {
        (self.0 as f64).sqrt()
    }
}

/// Takes samples, and gives their means as they fill.
#[derive(Debug, Clone)]
pub struct Blocks {
    length: BlockLength,
    taken: usize,
    sums: [[f64; 3]; 2],
}

impl Blocks {
    /// Blocks of `length` samples that have taken none.
    pub fn new(length: BlockLength) -> Self {
        Self { length, taken: 0, sums: [[0.0; 3]; 2] }
    }

    /// The mean of the block that `sample` fills, with its stamp.
    pub fn feed(&mut self, sample: &ImuSample) -> Option<ImuSample> {
        if self.length == BlockLength::ONE {
            return Some(*sample);
        }
        for (sums, sensor) in self.sums.iter_mut().zip(Sensor::ALL) {
            for (sum, value) in sums.iter_mut().zip(sample.of(sensor)) {
                *sum += value;
            }
        }
        self.taken += 1;
        if self.taken < self.length.0 {
            return None;
        }
        let [accel, gyro] = self.sums.map(|axes| axes.map(|sum| sum / self.length.0 as f64));
        *self = Self::new(self.length);
        Some(ImuSample { t: sample.t, accel, gyro })
    }

    /// What one sample has where the means have `noise`.
    pub fn of_one_sample(&self, noise: &ImuNoise) -> ImuNoise {
        if self.length == BlockLength::ONE {
            return *noise;
        }
        let times = |sensor| noise.of(sensor).map(|sigma| sigma * self.length.gain());
        ImuNoise::from_values(times(Sensor::Accel), times(Sensor::Gyro))
            .expect("a network's answer times the root of a block's length is a noise")
    }
}

/// The means of whole blocks; one that a step of more than `gap_s` seconds would cross begins anew behind it.
pub fn block_means(samples: &[ImuSample], length: BlockLength, gap_s: f64) -> Vec<ImuSample> {
    let (mut blocks, mut last) = (Blocks::new(length), None);
    let mut means = Vec::with_capacity(samples.len() / length.samples() + 1);
    for sample in samples {
        if last.is_some_and(|last| sample.t.seconds_since(last) > gap_s) {
            blocks = Blocks::new(length);
        }
        last = Some(sample.t);
        means.extend(blocks.feed(sample));
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stamp;
    use crate::random::Stream;
    use crate::signal::stats::{Ddof, deviation};
    use rand::Rng;

    fn of(hz: f64) -> Option<BlockLength> {
        BlockLength::of(SampleRate::from_hz(hz).unwrap(), SampleRate::HZ_200)
    }

    #[test]
    fn a_slow_log_has_no_blocks_and_a_near_rate_is_taken_as_it_is() {
        assert_eq!([100.0, 180.0].map(of), [None, None]);
        assert_eq!([195.0, 206.0, 400.0, 1000.0].map(of), [1, 1, 2, 5].map(|m| Some(BlockLength(m))));
        // Between two whole ratios blocks come faster than in the training.
        assert_eq!([250.0, 390.0, 533.0].map(of), [1, 2, 2].map(|m| Some(BlockLength(m))));
        let meets = |hz: f64| of(hz).unwrap().meets(SampleRate::from_hz(hz).unwrap(), SampleRate::HZ_200);
        assert_eq!([206.0, 390.0, 250.0, 533.0].map(meets), [true, true, false, false]);
    }

    #[test]
    fn means_of_white_noise_have_its_deviation_over_their_gain_are_white_and_keep_slow_signals() {
        for hz in [400.0, 500.0, 250.0, 533.0, 8000.0] {
            let length = of(hz).unwrap();
            let mut rng = Stream::new(4).named("blocks").rng();
            let mut blocks = Blocks::new(length);
            let mut means = Vec::new();
            for i in 0..20_000 * length.samples() as i64 {
                // Of deviation 1.
                let noise = 12f64.sqrt() * (rng.random::<f64>() - 0.5);
                let sample =
                    ImuSample { t: Stamp::from_ns(i), accel: [noise, 7.0, 0.0], gyro: [0.0, 0.0, -3.0] };
                means.extend(blocks.feed(&sample));
            }
            assert_eq!(means.len(), 20_000, "{hz}");
            let x: Vec<f64> = means.iter().map(|m| m.accel[0]).collect();
            let found = deviation(&x, Ddof::Zero) * length.gain();
            assert!((found - 1.0).abs() < 0.03, "{hz}: {found}");
            let neighbours = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 20_000.0;
            assert!(neighbours.abs() < 0.03 / length.samples() as f64, "{hz}: {neighbours}");
            assert!(means.iter().all(|m| (m.accel[1] - 7.0).abs() < 1e-9 && (m.gyro[2] + 3.0).abs() < 1e-9));
        }
    }

    #[test]
    fn no_block_crosses_a_gap() {
        let at =
            |ms: i64| ImuSample { t: Stamp::from_ns(1_000_000 * ms), gyro: [ms as f64; 3], accel: [0.0; 3] };
        let samples: Vec<ImuSample> = [0, 5, 10, 500, 505].map(at).to_vec();
        let found = block_means(&samples, of(400.0).unwrap(), 7.5e-3);
        assert_eq!(found.iter().map(|m| m.gyro[0]).collect::<Vec<_>>(), [2.5, 502.5]);
    }
}
