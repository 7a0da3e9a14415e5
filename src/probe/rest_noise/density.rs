//! The density of the white noise of one axis at rest, over all low passes that it may lie behind.

use super::fit::{Fit, fit};
use dpn_core::SampleRate;
use dpn_core::noise::Interval;
use dpn_core::signal::LowPass;
use dpn_core::signal::periodogram::Periodogram;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Independent values in which the plateau has to be most of what is seen; fewer, and it is not told from drift.
const SEEN: f64 = 20.0;
/// A low pass is said where it has this share of the belief.
const SAID: f64 = 0.9;
/// What simplifications of the model add to an interval, a factor on its deviation: of 900 simulated axes 94 % then lie inside.
const SLACK: f64 = 1.1;

/// A low pass that shows in a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Filter {
    /// Its kind.
    #[serde(flatten)]
    pub low_pass: LowPass,
    /// Where half the power passes \[Hz\]; of a moving mean by its length.
    pub corner_hz: Interval,
    /// Quality of two poles; Butterworth's is .707.
    pub quality: f64,
}

impl Filter {
    /// Share of the power that passes at `hz`.
    pub fn gain(&self, hz: f64, rate: SampleRate) -> f64 {
        self.low_pass.gain(hz, rate, self.corner_hz.value, self.quality)
    }
}

/// White noise of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisNoise {
    /// Its density \[unit / sqrt(Hz)\]; none where drift or steps hide it.
    pub density: Option<Interval>,
    /// Where none is known: what it stays below.
    pub below: f64,
    /// The low pass that it lies behind, where one shows.
    pub filter: Option<Filter>,
    /// The converter's step, whose rounding is not part of the density.
    pub step: Option<f64>,
    /// Density of its rounding over that of the noise, both as power.
    pub rounding: f64,
    /// Lines that were left out \[Hz\].
    pub lines: Vec<f64>,
}

/// Of a signal without holes, whose converter counts in `step`; none of one that is too short, or that never changes.
pub(super) fn density(signal: &[f64], rate: SampleRate, step: Option<f64>) -> Option<AxisNoise> {
    let periodogram = Periodogram::of(signal, rate)?;
    let mut fits: Vec<(Fit, f64)> = LowPass::candidates()
        .into_iter()
        .filter_map(|(low_pass, bet)| fit(&periodogram, rate, low_pass).map(|fit| (fit, bet)))
        .map(|(fit, bet)| {
            let cost = fit.cost - 2.0 * bet.ln();
            (fit, cost)
        })
        .collect();
    fits.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (best, least) = fits.first().map(|(fit, cost)| (fit.clone(), *cost))?;
    // A model that no candidate is believes too much in the nearest.
    let doubt = best.misfit.max(1.0);
    let rounding = step.map_or(0.0, |step| step * step / 12.0 * 2.0 / rate.hz());
    let beliefs: Vec<(f64, f64, f64)> = fits
        .iter()
        .map(|(fit, cost)| {
            // Where rounding is nearly all there is, what is left of the difference is no figure.
            let net = (fit.plateau - rounding).max(0.2 * fit.plateau);
            let deviation = fit.plateau_deviation * fit.misfit.max(1.0).sqrt() * fit.plateau / net;
            let spread = SLACK * 0.5 * deviation.hypot(ROUNDED * rounding / net);
            (0.5 * (0.5 * net).ln(), spread.max(1e-6), (-0.5 * (cost - least) / doubt).exp())
        })
        .collect();
    let value = mixed(&beliefs)?;
    let all: f64 = beliefs.iter().map(|b| b.2).sum();
    let same = |fit: &Fit| (fit.low_pass.order(), matches!(fit.low_pass, LowPass::MovingMean { .. }));
    let agree: f64 =
        fits.iter().zip(&beliefs).filter(|((fit, _), _)| same(fit) == same(&best)).map(|(_, b)| b.2).sum();
    let is_said = agree > SAID * all && best.low_pass != LowPass::None;
    let filter = is_said.then(|| filter(&best, rate));
    let known = best.seen >= SEEN && value.width() < Interval::WIDEST;
    let density = known.then_some(value);
    let rounding = rounding / (2.0 * value.value * value.value);
    Some(AxisNoise { density, below: value.high, filter, step, rounding, lines: periodogram.lines })
}

/// Deviation of rounding's own power: it is `step^2 / 12` only where the noise passes many steps.
const ROUNDED: f64 = 0.3;
/// Median and 95 % of a mixture of normal logarithms: middle, deviation, belief.
fn mixed(beliefs: &[(f64, f64, f64)]) -> Option<Interval> {
    let normal = Normal::standard();
    let all: f64 = beliefs.iter().map(|b| b.2).sum();
    let below = |y: f64| beliefs.iter().map(|b| b.2 / all * normal.cdf((y - b.0) / b.1)).sum::<f64>();
    let ends = beliefs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), b| {
        (low.min(b.0 - 5.0 * b.1), high.max(b.0 + 5.0 * b.1))
    });
    if !(ends.0.is_finite() && ends.1.is_finite()) {
        return None;
    }
    let quantile = |share: f64| {
        let (mut low, mut high) = ends;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) < share {
                low = middle;
            } else {
                high = middle;
            }
        }
        (0.5 * (low + high)).exp()
    };
    Some(Interval { value: quantile(0.5), low: quantile(0.025), high: quantile(0.975) })
}

fn filter(fit: &Fit, rate: SampleRate) -> Filter {
    let corner_hz = match fit.low_pass {
        LowPass::MovingMean { samples } => {
            // Half the power of a mean of m samples passes at .443 of rate / m.
            let value = 0.443 * rate.hz() / samples as f64;
            Interval { value, low: value, high: value }
        }
        _ => {
            let spread = (1.96 * SLACK * fit.corner_deviation * fit.misfit.max(1.0).sqrt()).exp();
            Interval { value: fit.corner, low: fit.corner / spread, high: fit.corner * spread }
        }
    };
    Filter { low_pass: fit.low_pass, corner_hz, quality: fit.quality }
}
