//! `effective(T)`: the white noise that errs as much over a span T as what the axis really has.
//!
//! A factor between two frames sums samples: an angle or velocity over n = T rate samples errs by dt sum x_k. Noise of one-sided density S(f) gives the
//! sum a variance of integral S(f) |D_n(f)|^2 df, |D_n|^2 = sin^2(pi f n dt) / sin^2(pi f dt), and white noise of deviation sigma one of n sigma^2. So
//!
//! sigma_eff^2 = integral_0^{rate/2} S(f) F_n(f) df,   F_n = |D_n|^2 / n   (Fejer's kernel; its integral is rate / 2)
//!
//! Position is the double sum, sum (n - k) x_k: a triangle's transfer function, |sum_{j<=n} j e^{2 pi i f j dt}|^2 over its own integral. It looks at the
//! same band, below 1 / T, where both kernels have nine tenths of their weight; [`Effective::double`] has it.
//!
//! In that band a moving body's signal is motion, thousands of times the noise, and no filter tells them apart. So only what is above
//! `MOTION_HZ` is taken as it is measured; below, the spectrum is continued by the white part of what is above: its mean
//! where it is flat, and where lines stand out of it less. With the flatness `v = valley / mean` (valley: lower
//! quartile of the bins, over its expectation for white noise)
//!
//! S_white = max(mean * min(1, v / .8)^3, quietest)
//!
//! where `quietest` is the lowest valley so far, smoothed over some windows: a sensor's own noise stays when vibration comes, and
//! is what is left of a spectrum of few clean lines. The power 3 was chosen among 3 and 4 on V1_02, V2_01 and V2_03 against ground truth; .8 is
//! what chance leaves of flat. On EuRoC what the IMU reads between 10 and 35 Hz in flight is mostly motion by its ground truth (estimated with that IMU), which
//! `MOTION_HZ` is for. A line is known to the window's 4 Hz: over spans of .1 s and more it counts with the mean of the kernel's
//! swing, as rotors do that wander. Not seen: true noise below `MOTION_HZ` that is not white, as tones that alias to there; and
//! white noise that grows while lines hide it.

use super::{Answer, EstimatorError};
use crate::signal::Welch;
use crate::signal::stats::quantile;
use crate::time::SampleRate;
use std::f64::consts::PI;
use std::sync::Arc;

/// Up to here \[Hz\] what is read may be motion; at slow rates up to half of what the rate shows.
pub const MOTION_HZ: f64 = 35.0;
/// Length of a spectrum's segment \[s\], rounded to a power of two.
const SEGMENT_S: f64 = 0.32;
/// The valley of a spectrum is this quantile of its bins.
const VALLEY: f64 = 0.25;
/// Normal quantile of the same.
const VALLEY_NORMAL: f64 = -0.674_489_75;
/// Flatness that white noise has but for chance, and the power of what is below.
const FLAT: f64 = 0.8;
const POWER: i32 = 3;
/// Share of the latest window in the smoothed valley.
const LATEST: f64 = 0.05;
/// Points of a bin's cell at which the kernel is looked at.
const POINTS: usize = 32;

/// Deviation of white noise with the error of a window's noise over a span.
pub struct Effective {
    rate: SampleRate,
    segment: usize,
    welch: Welch,
    /// Weight of a bin's density, kernel times width \[Hz\].
    weights: Vec<f64>,
    /// First bin that is not motion's.
    first: usize,
    /// Share of the power of each bin from there that passes the sensor's low pass.
    gains: Vec<f64>,
    /// Density of the sensor's own noise at rest, where it is known.
    floor: f64,
}

/// Share of the power below which a low pass leaves nothing to continue a spectrum by.
const PASSES: f64 = 0.1;
/// Bins that a spectrum is continued by at least.
const LEAST_BINS: usize = 8;

impl Effective {
    /// For spans of `span_s` at `rate`: the error of a sum.
    ///
    /// # Errors
    /// A span below one sample or beyond 100 s.
    pub fn sum(span_s: f64, rate: SampleRate) -> Result<Self, EstimatorError> {
        Self::new(span_s, rate, |f, n| {
            let (top, bottom) = ((PI * f * n as f64).sin(), (PI * f).sin());
            top * top / (bottom * bottom) / n as f64
        })
    }

    /// The same for the error of a double sum, as position has it.
    ///
    /// # Errors
    /// As [`sum`](Self::sum).
    pub fn double(span_s: f64, rate: SampleRate) -> Result<Self, EstimatorError> {
        Self::new(span_s, rate, |f, n| {
            let (mut re, mut im, mut squares) = (0.0, 0.0, 0.0);
            for j in 1..=n {
                let (sin, cos) = (2.0 * PI * f * j as f64).sin_cos();
                let weight = j as f64;
                (re, im, squares) = (re + weight * cos, im + weight * sin, squares + weight * weight);
            }
            (re * re + im * im) / squares
        })
    }

    /// `kernel`: of a frequency in cycles a sample and the samples of a span; its mean over frequency is 1.
    fn new(
        span_s: f64,
        rate: SampleRate,
        kernel: impl Fn(f64, usize) -> f64,
    ) -> Result<Self, EstimatorError> {
        let samples = span_s * rate.hz();
        if !(samples >= 1.0 && span_s <= 100.0) {
            let (parameter, range) = ("span [s]", "at least one sample and at most 100 s");
            return Err(EstimatorError::Parameter {
                estimator: "effective",
                parameter,
                value: span_s,
                range,
            });
        }
        let n = samples.round() as usize;
        let segment = 1_usize << (SEGMENT_S * rate.hz()).log2().round().clamp(4.0, 16.0) as u32;
        let welch = Welch::new(segment).expect("a segment of 16 samples or more");
        let bin = 1.0 / segment as f64;
        let weights = (0..=segment / 2).map(|k| {
            let low = (k as f64 - 0.5).max(0.0) * bin;
            let high = ((k as f64 + 0.5) * bin).min(0.5);
            let at = |i: usize| low + (i as f64 + 0.5) / POINTS as f64 * (high - low);
            let mean = (0..POINTS).map(|i| kernel(at(i), n)).sum::<f64>() / POINTS as f64;
            // The density at Nyquist is half of its neighbours', and so stands for its half cell.
            let width = if k == 0 { 0.5 * bin } else { bin };
            mean * width * rate.hz()
        });
        let motion = MOTION_HZ.min(0.25 * rate.hz());
        let first = (motion / (bin * rate.hz())).ceil() as usize;
        let gains = vec![1.0; segment / 2 + 1 - first];
        Ok(Self { rate, segment, welch, weights: weights.collect(), first, gains, floor: 0.0 })
    }

    /// The same for a sensor behind a low pass that lets `gain` of the power through at a frequency \[Hz\], and whose own noise at rest has `density`
    /// \[unit^2 / Hz\], one-sided, below its corner: what is above `MOTION_HZ` counts as it is measured, what is continued below is cleared of the filter, and
    /// where the filter leaves nothing to continue by it is the noise at rest.
    #[must_use]
    pub fn behind(mut self, gain: impl Fn(f64) -> f64, density: f64) -> Self {
        let bin = self.rate.hz() / self.segment as f64;
        for (k, g) in self.gains.iter_mut().enumerate() {
            *g = gain((self.first + k) as f64 * bin);
        }
        self.floor = density;
        self
    }

    /// Whether enough passes the low pass above motion to tell white noise that grows.
    pub fn tells_growth(&self) -> bool {
        self.gains[..self.gains.len() - 1].iter().filter(|g| **g > PASSES).count() >= LEAST_BINS
    }

    /// Expectation of the valley of white noise of density 1, over `len` samples: Wilson and Hilferty's quantile of chi^2 over its degrees of
    /// freedom, which half-overlapping Hann segments have fewer of.
    fn white_valley(&self, len: usize) -> f64 {
        let segments = ((len - self.segment) / (self.segment / 2) + 1) as f64;
        let freedom = 2.0 * segments / (1.0 + (segments - 1.0) / segments / 18.0);
        (1.0 - 2.0 / (9.0 * freedom) + VALLEY_NORMAL * (2.0 / (9.0 * freedom)).sqrt()).powi(3)
    }

    /// Samples below which a window has no spectrum.
    pub fn min_len(&self) -> usize {
        self.segment
    }

    /// What a window shows; none below [`min_len`](Self::min_len) samples.
    fn shown(&self, window: &[f64]) -> Option<Shown> {
        let spectrum = self.welch.spectrum(window, self.rate).ok()?;
        let density = spectrum.density();
        let above = self.weights[self.first..].iter().zip(&density[self.first..]);
        let measured = above.map(|(w, d)| w * d).sum();
        // Nyquist's bin is another's half.
        let quick: Vec<f64> = density[self.first..density.len() - 1]
            .iter()
            .zip(&self.gains)
            .filter(|(_, gain)| **gain > PASSES)
            .map(|(d, gain)| d / gain)
            .collect();
        if quick.len() < LEAST_BINS.min(self.gains.len() - 1) {
            return Some(Shown { measured, white: self.floor, valley: self.floor });
        }
        let mean = quick.iter().sum::<f64>() / quick.len() as f64;
        let valley = quantile(&quick, VALLEY) / self.white_valley(window.len());
        let flatness = if mean > 0.0 { valley / mean } else { 0.0 };
        Some(Shown { measured, white: mean * (flatness / FLAT).min(1.0).powi(POWER), valley })
    }
}

/// One window's share above `MOTION_HZ` \[unit^2\]; densities of its white part and its valley \[unit^2 / Hz\].
struct Shown {
    measured: f64,
    white: f64,
    valley: f64,
}

/// [`Effective`] along windows that follow each other.
#[derive(Clone)]
pub struct EffectiveStream {
    effective: Arc<Effective>,
    /// Smoothed valley, and the lowest of it so far.
    valley: Option<(f64, f64)>,
}

impl EffectiveStream {
    /// Has seen nothing.
    pub fn new(effective: Arc<Effective>) -> Self {
        Self { effective, valley: None }
    }

    /// The deviation, in the unit of the samples, by this window and the quietest before; NaN for one below [`Effective::min_len`].
    pub fn sigma(&mut self, window: &[f64]) -> f64 {
        let Some(shown) = self.effective.shown(window) else {
            return f64::NAN;
        };
        let (smooth, quietest) = self.valley.unwrap_or((shown.valley, shown.valley));
        let smooth = smooth + LATEST * (shown.valley - smooth);
        let quietest = quietest.min(smooth);
        self.valley = Some((smooth, quietest));
        let below: f64 = self.effective.weights[..self.effective.first].iter().sum();
        (shown.measured + shown.white.max(quietest).max(self.effective.floor) * below).sqrt()
    }
}

impl Answer for EffectiveStream {
    fn answer(&mut self, window: &[f64]) -> f64 {
        self.sigma(window)
    }

    fn forget(&mut self) {
        self.valley = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use crate::signal::stats::{Ddof, deviation};
    use rand::Rng;
    use rand_distr::StandardNormal;
    use std::f64::consts::TAU;

    const RATE: SampleRate = SampleRate::HZ_200;

    fn white(window: u64, samples: usize) -> Vec<f64> {
        let mut rng = Stream::new(3).named("effective").index(window).rng();
        (0..samples).map(|_| rng.sample::<f64, _>(StandardNormal)).collect()
    }

    /// Of sums of `n` over the root of `n`, squared.
    fn of_sums(x: &[f64], n: usize) -> f64 {
        let sums: Vec<f64> = x.windows(n).map(|w| w.iter().sum()).collect();
        deviation(&sums, Ddof::Zero).powi(2) / n as f64
    }

    /// Mean square of what a fresh stream says over windows of a second.
    fn said(span_s: f64, x: &[f64]) -> f64 {
        let mut stream = EffectiveStream::new(Arc::new(Effective::sum(span_s, RATE).unwrap()));
        let squares: Vec<f64> = x.chunks_exact(200).map(|window| stream.sigma(window).powi(2)).collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    }

    #[test]
    fn white_noise_has_its_own_deviation_over_every_span() {
        for span in [0.005, 0.05, 0.1, 0.5, 1.0] {
            for effective in [Effective::sum(span, RATE).unwrap(), Effective::double(span, RATE).unwrap()] {
                let mut stream = EffectiveStream::new(Arc::new(effective));
                let answers: Vec<f64> =
                    (0..2000).map(|window| stream.sigma(&white(window, 200)).powi(2)).collect();
                let mean = answers.iter().sum::<f64>() / 2000.0;
                // 65 of 100 Hz over a second: 130 degrees of freedom, a spread of 12 % of the variance a window, .3 % of the mean; flatness takes
                // away some per cent where chance makes a line.
                assert!((0.95..1.05).contains(&mean), "{span}: {mean}");
                let spread = deviation(&answers, Ddof::Zero);
                assert!(spread < 0.25, "{span}: {spread}");
            }
        }
    }

    #[test]
    fn a_tone_counts_as_much_as_sums_of_it_err() {
        for (hz, span) in [(88.0, 0.1), (60.0, 0.1), (65.0, 0.05), (83.0, 0.25)] {
            let n = (span * 200.0_f64).round() as usize;
            // A window knows it to some 4 Hz, in which sums over a long span go through their zeros: the mean over one swing of them.
            let (mut found, mut expected) = (0.0, 0.0);
            for shift in -8..8 {
                let hz = hz + f64::from(shift) / 16.0 / span;
                let x: Vec<f64> = (0..4000).map(|i| (TAU * hz * f64::from(i) / 200.0).sin()).collect();
                found += said(span, &x);
                expected += of_sums(&x, n);
            }
            let ratio = (found / expected).sqrt();
            assert!((ratio - 1.0).abs() < 0.1, "{hz} {span}: {ratio}");
        }
    }

    #[test]
    fn motion_adds_nothing() {
        let noise = white(1, 40_000);
        let moving: Vec<f64> =
            noise.iter().enumerate().map(|(i, v)| v + 100.0 * (TAU * 3.0 * i as f64 / 200.0).sin()).collect();
        let ratio = (said(0.1, &moving) / said(0.1, &noise)).sqrt();
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn vibration_counts_as_much_as_its_sums_err_on_top_of_white_noise() {
        // Rotors of wandering speed, some and many times as loud as the white noise.
        for loud in [1.0, 3.0, 10.0, 30.0] {
            let mut phase = 0.0;
            let x: Vec<f64> = white(1, 80_000)
                .into_iter()
                .zip(white(2, 80_000))
                .enumerate()
                .map(|(i, (noise, jitter))| {
                    let swing = 4.0 * (TAU * i as f64 / 700.0).sin();
                    phase += TAU * (89.0 + swing + jitter) / 200.0;
                    noise + loud * phase.sin()
                })
                .collect();
            let ratio = (said(0.1, &x) / of_sums(&x, 20)).sqrt();
            assert!((0.85..1.15).contains(&ratio), "{loud}: {ratio}");
        }
    }

    #[test]
    fn noise_behind_a_low_pass_counts_as_much_as_its_sums_err() {
        // One pole, 20 Hz, as exponential smoothing; in motion the noise is three times that at rest.
        let kept = (-TAU * 20.0_f64 / 200.0).exp();
        let gain =
            |hz: f64| (1.0 - kept).powi(2) / (1.0 - 2.0 * kept * (TAU * hz / 200.0).cos() + kept * kept);
        let mut out = 0.0;
        let x: Vec<f64> = white(1, 80_000)
            .into_iter()
            .map(|v| {
                out += (1.0 - kept) * (3.0 * v - out);
                out
            })
            .collect();
        let known = Effective::sum(0.1, RATE).unwrap().behind(gain, 0.01);
        assert!(known.tells_growth());
        let mut stream = EffectiveStream::new(Arc::new(known));
        let squares: Vec<f64> = x.chunks_exact(200).map(|window| stream.sigma(window).powi(2)).collect();
        let ratio = (squares.iter().sum::<f64>() / squares.len() as f64 / of_sums(&x, 20)).sqrt();
        assert!((0.9..1.2).contains(&ratio), "{ratio}");
        // Two poles at 5 Hz leave nothing above motion: the noise at rest stands there.
        let steep = Effective::sum(0.1, RATE).unwrap().behind(|hz| 1.0 / (1.0 + (hz / 5.0).powi(4)), 0.01);
        assert!(!steep.tells_growth());
        let sigma = EffectiveStream::new(Arc::new(steep)).sigma(&vec![0.0; 200]);
        assert!((sigma - 1.0).abs() < 0.05, "{sigma}");
    }

    #[test]
    fn spans_without_a_sample_are_refused() {
        for span in [0.0, 0.004, -1.0, 101.0, f64::NAN] {
            assert!(Effective::sum(span, RATE).is_err(), "{span}");
        }
    }
}
