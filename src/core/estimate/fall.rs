//! Whether the spectrum of a log in motion falls as behind a low pass, and what the noise below may then be.
//!
//! Above [`MOTION_HZ`] the median density of each of some bands is held against `A |H(f)|^2`, for every low pass of [`LowPass`] and every corner, one filter for all three axes: what
//! shakes one of them is worth little in that sum. All filters that do about as well as the best say together what the density `A` below the corner lies between; where no filter
//! at all is among them, the log is taken to be without. Below, no noise is louder than what is seen there, motion and all: a filter that says so is none of them.

use super::MOTION_HZ;
use crate::noise::Interval;
use crate::signal::stats::{mean, median, quantile};
use crate::signal::{LowPass, Made};
use crate::time::SampleRate;

/// Between these \[Hz\] the density is with motion in it, so that no noise is louder.
const SLOW: [f64; 2] = [4.0, 10.0];
/// What stands out of that band as motion does is none of its level, which is as well known as this, a logarithm.
const LEVEL: f64 = 0.25;
const LEVEL_OFF: f64 = 0.15;
/// Bands that a spectrum is looked at in, at most and at least, and the bins of each.
const BANDS: [usize; 2] = [8, 3];
const BINS: usize = 3;
/// Lowest corner \[Hz\], and from one to the next.
const LOWEST_HZ: f64 = 2.0;
const NEXT: f64 = 1.03;
/// Qualities of two poles, and how far others are from Butterworth's (a logarithm, one deviation).
const QUALITIES: [f64; 4] = [0.5, 0.6, std::f64::consts::FRAC_1_SQRT_2, 0.84];
const APART: f64 = 0.35;
/// What a band's level is off by, as a logarithm, however long the log: no noise is quite white.
const COLOUR: f64 = 0.08;
/// A band that is off by more than three deviations is of something else than noise, and counts no more than that.
const MOST: f64 = 3.0;
/// Filters that cost so much more than the best are none of the log's, and where no filter costs so much more, there is one; both times the best one's misfit.
const SAME: f64 = 6.0;
const FALLS: f64 = 10.0;
/// A best filter that misfits by more is not the log's: vibration falls as well, but not as evenly (EuRoC's flights and simulated ones have 4 to 9, real low passes 1 to 3). Then only a
/// density that is so much higher in the lowest band than in the highest, on every axis, is one that a low pass hides.
const MISFIT: f64 = 3.0;
const PLAIN: f64 = 5.0;
/// Mean over median of all bands from which there are lines in them.
const LINES: f64 = 1.3;
/// What a density is off by where one filter alone fits, a factor.
const OWN: f64 = 1.03;
/// Share of a level below which what rounding leaves of it is no figure.
const LEFT: f64 = 0.2;

/// What falls as behind a low pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    /// The filter that fits best.
    pub low_pass: LowPass,
    /// Its corner \[Hz\]; none of a moving mean.
    pub corner_hz: f64,
    /// What the density of the loudest axis lies between \[unit / sqrt(Hz)\].
    pub between: [f64; 2],
    /// The density of each axis, where filters that fit agree on it.
    pub density: Option<[Interval; 3]>,
}

impl Fall {
    /// The filter, for people; its corner where the filters that fit agree.
    pub fn words(&self) -> String {
        match self.density {
            Some(_) if self.low_pass.order() > 0 => {
                format!("a low pass ({}, about {:.0} Hz)", self.low_pass, self.corner_hz)
            }
            Some(_) => format!("a low pass ({})", self.low_pass),
            None => "a low pass".to_owned(),
        }
    }
}

/// What a spectrum above motion says of a low pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seen {
    /// It falls as behind one.
    Falls(Fall),
    /// It does not, but filters with a corner far up fit as well.
    Flat {
        /// The density of each axis \[unit / sqrt(Hz)\], where it is even enough, and without lines, to be noise.
        density: Option<[f64; 3]>,
        /// By which factors a density may be smaller and larger than what is seen.
        apart: [f64; 2],
    },
    /// It is too narrow to tell, or shaken as no filter does.
    Untold,
}

impl Seen {
    /// Whether a log of `rate` has enough above motion to see a low pass by.
    pub fn tells(rate: SampleRate) -> bool {
        bands(rate, 1.0).is_some()
    }
}

/// The bands above motion of a log of `rate` \[Hz\]; none where there are too few.
fn bands(rate: SampleRate, bin_hz: f64) -> Option<Vec<[f64; 2]>> {
    let (low, high, least) = (MOTION_HZ.min(0.25 * rate.hz()), 0.475 * rate.hz(), BINS as f64 * bin_hz);
    let count = BANDS[0].min(((high - low) / least) as usize);
    if count < BANDS[1] {
        return None;
    }
    // Even in logarithms, where the lowest band then has its bins.
    let ratio = (high / low).powf(1.0 / count as f64);
    let even = low * (ratio - 1.0) < least;
    let edge = |k: usize| {
        if even { low + (high - low) * k as f64 / count as f64 } else { low * ratio.powf(k as f64) }
    };
    Some((0..count).map(|k| [edge(k), edge(k + 1)]).collect())
}

/// One filter, and the logarithm of what it lets through in each band.
#[derive(Debug)]
struct Candidate {
    low_pass: LowPass,
    corner_hz: f64,
    gains: Vec<f64>,
    /// The same at the upper end of [`SLOW`].
    slow_gain: f64,
    bet: f64,
}

/// Every low pass that a log of `rate` could be behind, in `bands` \[Hz\]; none at all first.
fn candidates(bands: &[[f64; 2]], rate: SampleRate) -> Vec<Candidate> {
    let mut all = Vec::new();
    for (low_pass, _) in LowPass::candidates() {
        let highest = low_pass.highest_corner(rate).min(1.5 * rate.hz());
        let corners =
            std::iter::successors(Some(LOWEST_HZ), |hz| Some(hz * NEXT)).take_while(|hz| *hz < highest);
        let corners: Vec<f64> = if low_pass.order() == 0 { vec![f64::NAN] } else { corners.collect() };
        let qualities = if low_pass.order() == 2 { &QUALITIES[..] } else { &QUALITIES[2..3] };
        for (corner_hz, quality) in corners.iter().flat_map(|c| qualities.iter().map(move |q| (*c, *q))) {
            let gain = |hz: f64| folded(low_pass, hz, rate, corner_hz, quality);
            let plateau = gain(1e-3 * rate.hz());
            let share = |hz: f64| (gain(hz) / plateau).max(1e-12).ln();
            // Over a band a gain changes evenly enough for its middle to be the median.
            let gains = bands.iter().map(|[low, high]| share(0.5 * (low + high))).collect();
            let off = (quality / QUALITIES[2]).ln() / APART;
            all.push(Candidate { low_pass, corner_hz, gains, slow_gain: share(SLOW[1]), bet: off * off });
        }
    }
    all
}

/// Share of the power at `hz`; of a filter before the sampling with what folds back from above half the rate.
fn folded(low_pass: LowPass, hz: f64, rate: SampleRate, corner: f64, quality: f64) -> f64 {
    let gain = |hz: f64| low_pass.gain(hz, rate, corner, quality);
    let analog = matches!(
        low_pass,
        LowPass::FirstOrder { made: Made::Analog } | LowPass::SecondOrder { made: Made::Analog }
    );
    let images = if analog { 4 } else { 0 };
    gain(hz)
        + (1..=images).map(|m| f64::from(m) * rate.hz()).map(|at| gain(at - hz) + gain(at + hz)).sum::<f64>()
}

/// The same of one axis.
struct Levels {
    /// Logarithms of densities, a band each, and how far off each may be.
    levels: Vec<(f64, f64)>,
    /// Logarithm of what is seen where motion is slow.
    slow: f64,
    /// Whether lines stand out of all bands, as rotors' do: they shake, and are no part of the level.
    lines: bool,
}

impl Levels {
    /// Logarithm of the density below a candidate's corner, and what the bands cost that are off.
    fn fit(&self, candidate: &Candidate) -> (f64, f64) {
        let apart =
            || self.levels.iter().zip(&candidate.gains).map(|((level, sigma), gain)| (level - gain, *sigma));
        let mut density = median(&apart().map(|(d, _)| d).collect::<Vec<_>>());
        for _ in 0..3 {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (level, sigma) in apart() {
                let weight = (MOST * sigma / (level - density).abs().max(1e-12)).min(1.0) / (sigma * sigma);
                (sum, weights) = (sum + weight * level, weights + weight);
            }
            density = sum / weights;
        }
        let cost: f64 =
            apart().map(|(level, sigma)| ((level - density) / sigma).powi(2).min(MOST * MOST)).sum();
        let louder = (density + candidate.slow_gain - self.slow).max(0.0) / LEVEL_OFF;
        (density, cost + louder * louder)
    }
}

/// Looks for low passes in spectra of one rate.
#[derive(Debug)]
pub struct LowPassSight {
    second: usize,
    bin_hz: f64,
    bands: Vec<[f64; 2]>,
    candidates: Vec<Candidate>,
}

impl LowPassSight {
    /// Of spectra over `second` samples that come at `rate`; none where too little of them is above motion.
    pub fn new(rate: SampleRate, second: usize) -> Option<Self> {
        let bin_hz = rate.hz() / second as f64;
        let bands = bands(rate, bin_hz)?;
        let candidates = candidates(&bands, rate);
        Some(Self { second, bin_hz, bands, candidates })
    }

    /// Samples a spectrum.
    pub fn second(&self) -> usize {
        self.second
    }

    /// What the densities of three axes, one-sided means over so many `seconds`, say, in which rounding has the densities `rounding`.
    pub fn seen(&self, spectra: [&[f64]; 3], rounding: [f64; 3], seconds: usize) -> Seen {
        self.told(spectra, rounding, seconds).unwrap_or(Seen::Untold)
    }

    fn told(&self, spectra: [&[f64]; 3], rounding: [f64; 3], seconds: usize) -> Option<Seen> {
        let Self { bin_hz: bin, bands, candidates, .. } = self;
        let axes: Vec<Levels> = spectra
            .iter()
            .zip(rounding)
            .map(|(spectrum, rounding)| {
                let inside = |[low, high]: [f64; 2]| -> Vec<f64> {
                    let at = spectrum.iter().enumerate().skip(1);
                    at.filter(|(k, _)| (low..high).contains(&(*k as f64 * bin)))
                        .map(|(_, density)| *density)
                        .collect()
                };
                let level = |band: &[f64; 2]| {
                    let density = inside(*band);
                    let seen = median(&density).max(f64::MIN_POSITIVE);
                    // Neighbouring bins of a Hann window are not independent, and a median knows less than a mean.
                    let chance = 1.25 / (seconds as f64 * density.len() as f64 / 1.5).sqrt();
                    let left = (seen - rounding).max(LEFT * seen);
                    (left.ln(), chance.hypot(COLOUR) + rounding.min(seen) / left * 0.3)
                };
                let all = inside([bands[0][0], bands[bands.len() - 1][1]]);
                Levels {
                    levels: bands.iter().map(level).collect(),
                    slow: quantile(&inside(SLOW), LEVEL).ln(),
                    lines: mean(&all) > LINES * median(&all),
                }
            })
            .collect();
        let fits: Vec<(Vec<f64>, f64)> = candidates
            .iter()
            .map(|candidate| {
                let (density, cost): (Vec<f64>, Vec<f64>) =
                    axes.iter().map(|axis| axis.fit(candidate)).unzip();
                (density, cost.iter().sum::<f64>() + candidate.bet)
            })
            .collect();
        let (best, (_, least)) = fits.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        let misfit = (least / (3 * bands.len() - 5) as f64).max(1.0);
        let none = candidates.iter().position(|candidate| candidate.low_pass == LowPass::None)?;
        let plain = || {
            let mut ends =
                axes.iter().filter_map(|axis| Some((axis.levels.first()?.0, axis.levels.last()?.0)));
            ends.all(|(low, high)| low - high > PLAIN.ln())
        };
        if misfit > MISFIT && !plain() {
            return None;
        }
        let alike =
            || fits.iter().filter(|(_, cost)| cost - least < SAME * misfit).map(|(density, _)| density);
        if fits[none].1 - least < FALLS * misfit {
            let flat = &fits[none].0;
            let apart =
                alike().flat_map(|fit| fit.iter().zip(flat).map(|(density, flat)| 0.5 * (density - flat)));
            let (low, high) =
                apart.fold((0.0, 0.0), |(low, high): (f64, f64), by| (low.min(by), high.max(by)));
            let is_noise = misfit < MISFIT && !axes.iter().any(|axis| axis.lines);
            let density = is_noise.then(|| std::array::from_fn(|axis| (0.5 * flat[axis].exp()).sqrt()));
            return Some(Seen::Flat { density, apart: [low.exp() / OWN, high.exp() * OWN] });
        }
        let one_sided = |density: f64| (0.5 * density).sqrt();
        let of_axis = |axis: usize| {
            let [low, high] = [f64::min, f64::max].map(|pick| alike().map(|fit| fit[axis]).reduce(pick));
            let (low, high) = (low?.exp(), high?.exp());
            let value = fits[best].0[axis].exp();
            Some(Interval { value: one_sided(value), low: one_sided(low) / OWN, high: one_sided(high) * OWN })
        };
        let density = [of_axis(0)?, of_axis(1)?, of_axis(2)?];
        // A bound has no more digits than these.
        let short = |density: f64| format!("{density:.2e}").parse().expect("Rust reads its own numbers");
        let loudest = |end: fn(&Interval) -> f64| short(density.iter().map(end).fold(0.0, f64::max));
        let known = misfit < MISFIT && density.iter().all(|axis| axis.width() < Interval::WIDEST);
        let Candidate { low_pass, corner_hz, .. } = candidates[best];
        let between = [loudest(|axis| axis.low), loudest(|axis| axis.high)];
        Some(Seen::Falls(Fall { low_pass, corner_hz, between, density: known.then_some(density) }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Fall, LowPassSight, Seen};
    use crate::random::Stream;
    use crate::signal::{Spectrum, Welch};
    use crate::time::SampleRate;
    use rand::Rng;
    use rand_distr::StandardNormal;
    use std::f64::consts::{PI, SQRT_2, TAU};

    /// White noise of 1 a sample behind `poles` at `corner` of 200 Hz, with slow motion and a rotor; an axis.
    fn spectrum(axis: u64, poles: usize, corner: f64, rotor: f64) -> Spectrum {
        let mut rng = Stream::new(6).named("fall").index(axis).rng();
        let k = (PI * corner / 200.0).tan();
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        let signal: Vec<f64> = (0..12_000)
            .map(|i| {
                let now: f64 = rng.sample(StandardNormal);
                let out = match poles {
                    0 => now,
                    1 => (k * (now + x[0]) + (1.0 - k) * y[0]) / (1.0 + k),
                    _ => {
                        let over = 2.0 * (k * k - 1.0) * y[0] + (1.0 - k * SQRT_2 + k * k) * y[1];
                        (k * k * (now + 2.0 * x[0] + x[1]) - over) / (1.0 + k * SQRT_2 + k * k)
                    }
                };
                (x, y) = ([now, x[0]], [out, y[0]]);
                let t = f64::from(i) / 200.0;
                out + 20.0 * (TAU * 0.7 * t).sin() + rotor * (TAU * (41.0 * t + 2.0 * (0.5 * t).sin())).sin()
            })
            .collect();
        Welch::new(200).unwrap().spectrum(&signal, SampleRate::HZ_200).unwrap()
    }

    fn fall(poles: usize, corner: f64, rotor: f64) -> Option<Fall> {
        let axes =
            [0, 1, 2].map(|axis| spectrum(axis, poles, corner, if axis == 2 { 0.1 } else { 1.0 } * rotor));
        let sight = LowPassSight::new(SampleRate::HZ_200, 200).unwrap();
        match sight.seen(axes.each_ref().map(Spectrum::density), [0.0; 3], 60) {
            Seen::Falls(fall) => Some(fall),
            Seen::Flat { density, apart: [low, high] } => {
                assert!(low > 0.7 && low < 1.0 && high > 1.0 && high < 1.4, "{low} {high}");
                let truth = 0.005f64.sqrt();
                assert!(
                    rotor > 0.0 || density.unwrap().iter().all(|d| (d / truth - 1.0).abs() < 0.1),
                    "{density:?}"
                );
                None
            }
            Seen::Untold => None,
        }
    }

    #[test]
    fn a_low_pass_falls_and_neither_motion_nor_a_rotor_does() {
        assert_eq!(fall(0, 50.0, 0.0), None);
        assert_eq!(fall(0, 50.0, 2.0), None);
        // One-sided: 1 a sample is a density of .0707.
        let truth = 0.005f64.sqrt();
        for (poles, corner) in [(1, 10.0), (1, 42.0), (2, 15.0), (2, 42.0)] {
            let found = fall(poles, corner, 0.0).unwrap();
            let [low, high] = found.between;
            assert!(low < truth && high > truth, "{found:?}");
            // What lies far above the corner does not tell the density well.
            assert!(found.density.is_some() || corner < 40.0, "{found:?}");
            for axis in found.density.iter().flatten() {
                assert!((axis.low..axis.high).contains(&truth), "{found:?}");
                assert!(found.low_pass.order() == poles, "{found:?}");
                assert!((found.corner_hz / corner - 1.0).abs() < 0.2, "{found:?}");
            }
        }
        assert_eq!(fall(2, 10.0, 0.0).unwrap().density, None);
    }
}
