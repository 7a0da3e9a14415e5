//! Welch's power spectral density of one axis, one-sided, in unit^2 / Hz.
//!
//! Segments overlap by half (the smaller half when odd), are cleared of their mean unless told otherwise, weighted by
//! a periodic Hann window `w`, and their periodograms `|FFT(w x)|^2 / (rate sum w^2)` averaged. All bins but zero and
//! Nyquist are doubled, so that `sum(density) * bin width` is the power of the signal (up to the window). These are
//! scipy.signal.welch's defaults. Source: Welch 1967. Not here: other windows, cross spectra, confidence bands.

use crate::time::SampleRate;
use dpn_fft::{Complex, Fft, forward};
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};
use thiserror::Error;

/// Why there is no spectrum.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SpectrumError {
    /// A segment with no frequency above zero.
    #[error("a spectrum's segment of {segment} samples is too short; use at least 2, better 64")]
    SegmentTooShort {
        /// The segment asked for.
        segment: usize,
    },
    /// A signal that does not fill one segment.
    #[error(
        "{len} samples are fewer than one segment of {segment}; use a shorter segment or a longer signal"
    )]
    SignalTooShort {
        /// Length of the signal.
        len: usize,
        /// Length of a segment.
        segment: usize,
    },
}

/// Welch's method with its window and transform planned once: at the first signal that fills a segment, so that no length that was only asked
/// for takes room.
#[derive(Clone)]
pub struct Welch {
    segment: usize,
    remove_mean: bool,
    plan: OnceLock<(Vec<f64>, Arc<dyn Fft<f64>>)>,
}

impl Welch {
    /// Segments of `segment` samples, each cleared of its mean.
    ///
    /// # Errors
    /// A segment below 2 samples.
    pub fn new(segment: usize) -> Result<Self, SpectrumError> {
        if segment < 2 {
            return Err(SpectrumError::SegmentTooShort { segment });
        }
        Ok(Self { segment, remove_mean: true, plan: OnceLock::new() })
    }

    /// Leaves the mean in the segments: bin zero then shows it, and leaks into its neighbour.
    #[must_use]
    #[cfg(test)]
    fn keeping_mean(mut self) -> Self {
        self.remove_mean = false;
        self
    }

    /// Samples from a segment to the next.
    pub fn step(&self) -> usize {
        self.segment - self.segment / 2
    }

    /// A mean of periodograms that has none yet.
    pub fn averaging(&self) -> Averaging<'_> {
        let segment = self.segment;
        let (_, fft) = self.plan.get_or_init(|| {
            let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / segment as f64).cos();
            ((0..segment).map(hann).collect(), forward(segment))
        });
        Averaging {
            welch: self,
            power: vec![0.0; segment / 2 + 1],
            buffer: vec![Complex::default(); segment],
            scratch: vec![Complex::default(); fft.get_inplace_scratch_len()],
            segments: 0,
        }
    }

    /// The spectrum of `x`, sampled at `rate`; samples behind the last whole segment are not used.
    ///
    /// # Errors
    /// A signal shorter than one segment.
    pub fn spectrum(&self, x: &[f64], rate: SampleRate) -> Result<Spectrum, SpectrumError> {
        let segment = self.segment;
        // No length that was only asked for takes room.
        if x.len() < segment {
            return Err(SpectrumError::SignalTooShort { len: x.len(), segment });
        }
        let mut averaging = self.averaging();
        averaging.take(x);
        averaging.spectrum(rate).ok_or(SpectrumError::SignalTooShort { len: x.len(), segment })
    }
}

/// A mean of periodograms of a signal that comes in parts.
pub struct Averaging<'a> {
    welch: &'a Welch,
    power: Vec<f64>,
    buffer: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    segments: usize,
}

impl Averaging<'_> {
    /// Takes the segments of a part, [`Welch::step`] samples apart; the next part begins one step behind this one's last segment.
    pub fn take(&mut self, part: &[f64]) {
        let Some((weights, fft)) = self.welch.plan.get() else { return };
        for part in part.windows(self.welch.segment).step_by(self.welch.step()) {
            let level = if self.welch.remove_mean { super::stats::mean(part) } else { 0.0 };
            for ((z, v), w) in self.buffer.iter_mut().zip(part).zip(weights) {
                *z = Complex::new((v - level) * w, 0.0);
            }
            fft.process_with_scratch(&mut self.buffer, &mut self.scratch);
            for (p, z) in self.power.iter_mut().zip(&self.buffer) {
                *p += z.norm_sqr();
            }
            self.segments += 1;
        }
    }

    /// The spectrum of all segments taken; none of none.
    pub fn spectrum(mut self, rate: SampleRate) -> Option<Spectrum> {
        let (weights, _) = self.welch.plan.get()?;
        if self.segments == 0 {
            return None;
        }
        let segment = self.welch.segment;
        let weight: f64 = weights.iter().map(|w| w * w).sum();
        for (k, p) in self.power.iter_mut().enumerate() {
            // Zero and Nyquist stand once in the two-sided spectrum, every other bin twice.
            let sides = if k == 0 || 2 * k == segment { 1.0 } else { 2.0 };
            *p *= sides / (self.segments as f64 * rate.hz() * weight);
        }
        let (density, bin_hz, nyquist_hz) = (self.power, rate.hz() / segment as f64, 0.5 * rate.hz());
        Some(Spectrum { density, bin_hz, nyquist_hz })
    }
}

/// A one-sided power spectral density on evenly spaced bins from zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    density: Vec<f64>,
    bin_hz: f64,
    nyquist_hz: f64,
}

/// The highest bin of a band, refined between bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Where it stands \[Hz\].
    pub hz: f64,
    /// Density of the highest bin \[unit^2 / Hz\].
    pub density: f64,
}

impl Spectrum {
    /// Density of every bin \[unit^2 / Hz\].
    pub fn density(&self) -> &[f64] {
        &self.density
    }

    /// Distance between bins \[Hz\].
    pub fn bin_hz(&self) -> f64 {
        self.bin_hz
    }

    /// Frequency of every bin \[Hz\].
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        (0..self.density.len()).map(|k| k as f64 * self.bin_hz)
    }

    /// Power between `low_hz` and `high_hz` \[unit^2\]; its square root is the deviation of that band's part.
    ///
    /// A bin's power is spread evenly over its cell, half a bin to both sides and cut at zero and Nyquist; so bands
    /// add up, and the whole range holds `sum(density) * bin_hz`. Zero where the band is empty.
    pub fn band_power(&self, low_hz: f64, high_hz: f64) -> f64 {
        let share = |k: usize| {
            let from = ((k as f64 - 0.5) * self.bin_hz).max(0.0);
            let to = ((k as f64 + 0.5) * self.bin_hz).min(self.nyquist_hz);
            let inside = high_hz.min(to) - low_hz.max(from);
            inside.max(0.0) / (to - from)
        };
        self.density.iter().enumerate().map(|(k, d)| d * self.bin_hz * share(k)).sum()
    }

    /// The highest bin between `low_hz` and `high_hz`, both included; `None` where no bin stands or none has power.
    ///
    /// Its frequency is refined by the parabola through the logarithms of the bin and its two neighbours.
    pub fn peak(&self, low_hz: f64, high_hz: f64) -> Option<Peak> {
        let inside = |k: &usize| (low_hz..=high_hz).contains(&(*k as f64 * self.bin_hz));
        let highest = (0..self.density.len())
            .filter(inside)
            .max_by(|a, b| self.density[*a].total_cmp(&self.density[*b]))?;
        let density = self.density[highest];
        if density.is_nan() || density <= 0.0 {
            return None;
        }
        Some(Peak { hz: (highest as f64 + self.vertex(highest)) * self.bin_hz, density })
    }

    /// Offset of the parabola's vertex from bin `k`, in bins; zero at the borders and where it has no summit.
    fn vertex(&self, k: usize) -> f64 {
        if k == 0 || k + 1 >= self.density.len() || self.density[k - 1] <= 0.0 || self.density[k + 1] <= 0.0 {
            return 0.0;
        }
        let [left, middle, right] = [k - 1, k, k + 1].map(|i| self.density[i].ln());
        let curvature = left - 2.0 * middle + right;
        if curvature < 0.0 { (0.5 * (left - right) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Golden {
        rate: f64,
        x: Vec<f64>,
        cases: Vec<Case>,
    }

    #[derive(Deserialize)]
    struct Case {
        segment: usize,
        remove_mean: bool,
        hz: Vec<f64>,
        density: Vec<f64>,
    }

    #[test]
    fn the_density_agrees_with_scipy() {
        let golden: Golden = dpn_testing::golden("welch");
        let rate = SampleRate::from_hz(golden.rate).unwrap();
        for case in &golden.cases {
            let welch = Welch::new(case.segment).unwrap();
            let welch = if case.remove_mean { welch } else { welch.keeping_mean() };
            let got = welch.spectrum(&golden.x, rate).unwrap();
            let highest = case.density.iter().copied().fold(0.0, f64::max);
            assert_eq!(got.density().len(), case.density.len());
            for ((hz, d), (a, b)) in
                got.frequencies().zip(got.density()).zip(case.hz.iter().zip(&case.density))
            {
                assert!((hz - a).abs() < 1e-10);
                assert!(
                    (d - b).abs() < 1e-12 * b + 1e-15 * highest,
                    "{} at {hz} Hz: {d} is not {b}",
                    case.segment
                );
            }
        }
    }

    #[test]
    fn a_tone_between_bins_is_found_where_it_is_with_its_power() {
        let x: Vec<f64> = (0..4000).map(|i| 0.9 * (TAU * 93.37 / 200.0 * f64::from(i)).sin()).collect();
        let spectrum = Welch::new(256).unwrap().spectrum(&x, SampleRate::HZ_200).unwrap();
        let peak = spectrum.peak(60.0, 100.0).unwrap();
        assert!((peak.hz - 93.37).abs() < 0.1 * spectrum.bin_hz(), "{}", peak.hz);
        let deviation = spectrum.band_power(90.0, 97.0).sqrt();
        assert!((deviation - 0.9 / 2f64.sqrt()).abs() < 2e-3, "{deviation}");
        assert!(spectrum.band_power(5.0, 60.0) < 1e-6);
    }

    #[test]
    fn lengths_that_give_no_spectrum_are_refused() {
        assert_eq!(Welch::new(1).err(), Some(SpectrumError::SegmentTooShort { segment: 1 }));
        // What a rate of 1 GHz asks for, and a hundred samples.
        let giant = Welch::new(2_000_000_000).unwrap().spectrum(&[0.0; 100], SampleRate::HZ_200).unwrap_err();
        assert_eq!(giant, SpectrumError::SignalTooShort { len: 100, segment: 2_000_000_000 });
        let short = Welch::new(64).unwrap().spectrum(&[0.0; 63], SampleRate::HZ_200).unwrap_err();
        assert_eq!(short, SpectrumError::SignalTooShort { len: 63, segment: 64 });
        let silence = Welch::new(64).unwrap().spectrum(&[9.81; 64], SampleRate::HZ_200).unwrap();
        assert_eq!(silence.peak(0.0, 100.0), None);
    }

    proptest! {
        #[test]
        fn bands_add_up_to_the_whole(
            x in prop::collection::vec(-1.0..1.0_f64, 50..120), split in 0.0..100.0_f64, segment in 8_usize..50,
        ) {
            let spectrum = Welch::new(segment).unwrap().spectrum(&x, SampleRate::HZ_200).unwrap();
            let whole: f64 = spectrum.density().iter().sum::<f64>() * spectrum.bin_hz();
            let parts = spectrum.band_power(0.0, split) + spectrum.band_power(split, 100.0);
            prop_assert!((parts - whole).abs() < 1e-12 * whole);
        }
    }
}
