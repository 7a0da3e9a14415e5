//! Samples of a faster log as means over blocks, at the rate that networks were trained at.
//!
//! A mean of m samples of white noise has its deviation over the root of m, and below the blocks' rate the same density: nothing of slower noise and motion is folded, as it is where
//! every m-th sample is taken. Where the rates have no whole ratio r a sample at a block's end counts for both by its shares; uniformly placed ends give a mean the variance
//! `(r - 1/3) / r^2` of a sample's.

use crate::{ImuNoise, ImuSample, SampleRate, Sensor};

/// Largest share by which the rate of blocks may differ from that of the training.
const TOLERANCE: f64 = 0.05;
/// A share of a sample below which nothing is left of it.
const NOTHING: f64 = 1e-9;

/// How many samples a block has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockLength(f64);

impl BlockLength {
    /// Of samples of `rate` for networks trained at `trained`; none where the rate is too slow.
    pub fn of(rate: SampleRate, trained: SampleRate) -> Option<Self> {
        let ratio = rate.hz() / trained.hz();
        let whole = ratio.round().max(1.0);
        if (ratio / whole - 1.0).abs() <= TOLERANCE {
            return Some(Self(whole));
        }
        (ratio > 1.0).then_some(Self(ratio))
    }

    /// One sample a block.
    pub const ONE: Self = Self(1.0);

    /// Samples, shares of them counted.
    pub fn exact(self) -> f64 {
        self.0
    }

    /// Whole samples, to the nearest.
    pub fn samples(self) -> usize {
        self.0.round() as usize
    }

    /// Whether every block begins with a sample.
    pub fn is_whole(self) -> bool {
        self.0.fract() == 0.0
    }

    /// Deviation of one sample over that of a block's mean, of white noise.
    pub fn gain(self) -> f64 {
        let variance = if self.is_whole() { 1.0 / self.0 } else { (self.0 - 1.0 / 3.0) / (self.0 * self.0) };
        variance.sqrt().recip()
    }
}

/// Takes samples, and gives their means as they fill.
#[derive(Debug, Clone)]
pub struct Blocks {
    length: BlockLength,
    left: f64,
    sums: [[f64; 3]; 2],
}

impl Blocks {
    /// Blocks of `length` samples that have taken none.
    pub fn new(length: BlockLength) -> Self {
        Self { length, left: length.0, sums: [[0.0; 3]; 2] }
    }

    /// The mean of the block that `sample` fills, with its stamp.
    pub fn feed(&mut self, sample: &ImuSample) -> Option<ImuSample> {
        if self.length == BlockLength::ONE {
            return Some(*sample);
        }
        let share = self.left.min(1.0);
        self.add(sample, share);
        self.left -= share;
        if self.left > NOTHING {
            return None;
        }
        let [accel, gyro] = self.sums.map(|axes| axes.map(|sum| sum / self.length.0));
        (self.left, self.sums) = (self.length.0, [[0.0; 3]; 2]);
        let rest = 1.0 - share;
        if rest > NOTHING {
            self.add(sample, rest);
            self.left -= rest;
        }
        Some(ImuSample { t: sample.t, accel, gyro })
    }

    fn add(&mut self, sample: &ImuSample, share: f64) {
        for (sums, sensor) in self.sums.iter_mut().zip(Sensor::ALL) {
            for (sum, value) in sums.iter_mut().zip(sample.of(sensor)) {
                *sum += share * value;
            }
        }
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
        assert_eq!([195.0, 206.0, 400.0, 1000.0].map(of), [1.0, 1.0, 2.0, 5.0].map(|m| Some(BlockLength(m))));
    }

    #[test]
    fn means_of_white_noise_have_its_deviation_over_their_gain_and_keep_slow_signals() {
        for hz in [400.0, 500.0, 250.0, 533.0, 8000.0] {
            let length = of(hz).unwrap();
            let mut rng = Stream::new(4).named("blocks").rng();
            let mut blocks = Blocks::new(length);
            let mut means = Vec::new();
            let count = (20_000.0 * hz / 200.0) as i64;
            for i in 0..count {
                // Of deviation 1.
                let noise = 12f64.sqrt() * (rng.random::<f64>() - 0.5);
                let sample =
                    ImuSample { t: Stamp::from_ns(i), accel: [noise, 7.0, 0.0], gyro: [0.0, 0.0, -3.0] };
                means.extend(blocks.feed(&sample));
            }
            // As many a second as the networks know.
            assert!((means.len() as f64 - 20_000.0).abs() < 2.0, "{hz}: {}", means.len());
            let x: Vec<f64> = means.iter().map(|m| m.accel[0]).collect();
            let found = deviation(&x, Ddof::Zero) * length.gain();
            assert!((found - 1.0).abs() < 0.03, "{hz}: {found}");
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
