//! A model of a spectrum at rest, fitted to a periodogram by Whittle's likelihood.
//!
//! `S(f) = white |H(f)|^2 + flicker / f + walk / f^2 + floor`: white noise behind a low pass, the drift of the bias, and what is added behind the filter, as rounding
//! to steps is. Logarithms of the four and of the filter's corner and quality are found by Fisher scoring (Levenberg's damping), each start's amplitudes by
//! multiplicative steps before. The negative logarithm of the likelihood is `sum weight (ln S + P / S)`; the inverse of its information is the covariance.

use dpn_core::SampleRate;
use dpn_core::signal::LowPass;
use dpn_core::signal::periodogram::Periodogram;
use nalgebra::{Cholesky, SMatrix, SVector};

/// White, flicker, walk, floor.
const AMPLITUDES: usize = 4;
const CORNER: usize = 4;
const QUALITY: usize = 5;
const ALL: usize = 6;
/// Butterworth's quality, and how far others are from it (a factor, one deviation).
const BUTTERWORTH: f64 = std::f64::consts::FRAC_1_SQRT_2;
const APART: f64 = 0.2;
const QUALITIES: [f64; 2] = [0.45, 1.2];
/// Corners at which a search starts.
const STARTS: usize = 6;

type Vector = SVector<f64, ALL>;
type Matrix = SMatrix<f64, ALL, ALL>;

/// A fitted model.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) low_pass: LowPass,
    /// Density below the corner, without drift, one-sided: white noise and floor \[unit^2 / Hz\].
    pub(super) plateau: f64,
    /// Deviation of its logarithm.
    pub(super) plateau_deviation: f64,
    /// \[Hz\].
    pub(super) corner: f64,
    /// Deviation of its logarithm.
    pub(super) corner_deviation: f64,
    pub(super) quality: f64,
    /// Twice the negative logarithm of the likelihood, and what parameters cost (Schwarz).
    pub(super) cost: f64,
    /// Deviance over degrees of freedom: 1 where the model is the log's.
    pub(super) misfit: f64,
    /// Independent values in which the plateau is most of the density.
    pub(super) seen: f64,
}

struct Model<'a> {
    periodogram: &'a Periodogram,
    rate: SampleRate,
    low_pass: LowPass,
    /// Below these a part is none.
    least: [f64; AMPLITUDES],
}

/// Cost, gradient, information.
type Slope = (f64, Vector, Matrix);

impl Model<'_> {
    fn gain(&self, hz: f64, at: &Vector) -> f64 {
        self.low_pass.gain(hz, self.rate, at[CORNER].exp(), at[QUALITY].exp())
    }

    /// Without a filter the floor is white noise itself.
    fn basis(&self, hz: f64, at: &Vector) -> [f64; AMPLITUDES] {
        let floor = if self.low_pass == LowPass::None { 0.0 } else { 1.0 };
        [self.gain(hz, at), 1.0 / hz, 1.0 / (hz * hz), floor]
    }

    fn parts(&self, hz: f64, at: &Vector) -> [f64; AMPLITUDES] {
        let basis = self.basis(hz, at);
        std::array::from_fn(|j| at[j].exp() * basis[j])
    }

    fn slope(&self, at: &Vector) -> Slope {
        const STEP: f64 = 1e-4;
        let (mut cost, mut gradient, mut information) = (0.0, Vector::zeros(), Matrix::zeros());
        for band in &self.periodogram.bands {
            let parts = self.parts(band.hz, at);
            let density: f64 = parts.iter().sum();
            let mut of = Vector::zeros();
            for (j, part) in parts.iter().enumerate() {
                of[j] = part / density;
            }
            for j in CORNER..CORNER + self.low_pass.order() {
                let moved = |by: f64| {
                    let mut at = *at;
                    at[j] += by;
                    self.gain(band.hz, &at)
                };
                of[j] = at[0].exp() * (moved(STEP) - moved(-STEP)) / (2.0 * STEP) / density;
            }
            cost += band.weight * (density.ln() + band.density / density);
            gradient += of * band.weight * (1.0 - band.density / density);
            information.ger(band.weight, &of, &of, 1.0);
        }
        if self.low_pass.order() == 2 {
            let off = (at[QUALITY] - BUTTERWORTH.ln()) / APART;
            cost += 0.5 * off * off;
            gradient[QUALITY] += off / APART;
            information[(QUALITY, QUALITY)] += 1.0 / (APART * APART);
        }
        (cost, gradient, information)
    }

    /// Amplitudes for a filter that stays as it is: multiplicative steps, which go downhill from anywhere.
    fn amplitudes(&self, at: &mut Vector) {
        const STEPS: usize = 30;
        let bases: Vec<_> = self.periodogram.bands.iter().map(|band| self.basis(band.hz, at)).collect();
        for _ in 0..STEPS {
            let (mut up, mut down) = ([0.0; AMPLITUDES], [f64::MIN_POSITIVE; AMPLITUDES]);
            for (band, basis) in self.periodogram.bands.iter().zip(&bases) {
                let density: f64 = basis.iter().enumerate().map(|(j, g)| at[j].exp() * g).sum();
                for (j, g) in basis.iter().enumerate() {
                    up[j] += band.weight * g * band.density / (density * density);
                    down[j] += band.weight * g / density;
                }
            }
            for j in 0..AMPLITUDES {
                at[j] = (at[j] + 0.5 * (up[j] / down[j]).max(1e-30).ln()).max(self.least[j]);
            }
        }
    }

    fn descend(&self, mut at: Vector) -> (Vector, Slope) {
        const STEPS: usize = 100;
        const ENOUGH: f64 = 1e-4;
        let highest = self.low_pass.highest_corner(self.rate).ln();
        let lowest = self.periodogram.bands[0].hz.ln();
        self.amplitudes(&mut at);
        let mut now = self.slope(&at);
        let mut damping = 1e-2;
        for _ in 0..STEPS {
            let mut damped = now.2;
            for j in 0..ALL {
                damped[(j, j)] += damping * (now.2[(j, j)] + 1e-3) + 1e-12;
            }
            let Some(cholesky) = Cholesky::new(damped) else { break };
            let step = cholesky.solve(&now.1);
            let mut next = at;
            for j in 0..ALL {
                next[j] -= step[j].clamp(-2.0, 2.0);
            }
            for j in 0..AMPLITUDES {
                next[j] = next[j].max(self.least[j]);
            }
            next[CORNER] = next[CORNER].clamp(lowest, highest);
            next[QUALITY] = next[QUALITY].clamp(QUALITIES[0].ln(), QUALITIES[1].ln());
            let slope = self.slope(&next);
            if slope.0 < now.0 {
                let gained = now.0 - slope.0;
                (at, now) = (next, slope);
                damping = (0.3 * damping).max(1e-9);
                if gained < ENOUGH {
                    break;
                }
            } else {
                damping *= 5.0;
                if damping > 1e9 {
                    break;
                }
            }
        }
        (at, now)
    }
}

/// Fits white noise behind `low_pass`; none of a periodogram that has no power.
pub(super) fn fit(periodogram: &Periodogram, rate: SampleRate, low_pass: LowPass) -> Option<Fit> {
    let bands = &periodogram.bands;
    let (first, last) = (bands.first()?, bands.last()?);
    let of = |below: f64, above: f64| {
        let inside = bands.iter().filter(|b| (above..below).contains(&b.hz));
        dpn_core::signal::stats::median_of(inside.map(|b| b.density))
    };
    let level = of(f64::INFINITY, 0.0).filter(|level| *level > 0.0)?;
    let least = [1e-9 * level, 1e-7 * level * first.hz, 1e-7 * level * first.hz.powi(2), 1e-12 * level];
    let model = Model { periodogram, rate, low_pass, least: least.map(f64::ln) };
    let corners: Vec<f64> = if low_pass.order() == 0 {
        vec![last.hz]
    } else {
        let lowest = (20.0 * first.hz).max(last.hz / 80.0);
        let at = |i: usize| lowest * (1.2 * last.hz / lowest).powf(i as f64 / (STARTS - 1) as f64);
        (0..STARTS).map(|i| at(i).min(0.46 * rate.hz())).collect()
    };
    let start = |corner: f64| {
        let plateau = of(corner, corner / 20.0).filter(|p| *p > 0.0).unwrap_or(level);
        let floor = 0.3 * last.density.max(1e-6 * level);
        let amplitudes = [plateau, 0.3 * plateau * first.hz, 0.3 * plateau * first.hz.powi(2), floor];
        let mut at = Vector::zeros();
        for (j, amplitude) in amplitudes.into_iter().enumerate() {
            at[j] = amplitude.ln();
        }
        (at[CORNER], at[QUALITY]) = (corner.ln(), BUTTERWORTH.ln());
        at
    };
    let descents = corners.into_iter().map(|corner| model.descend(start(corner)));
    let (at, (cost, _, information)) = descents.min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;

    let mut pinned = information;
    let fitted = |j: usize| match j {
        3 if low_pass == LowPass::None => false,
        0..AMPLITUDES => at[j] > model.least[j] + 1e-9,
        _ => j < CORNER + low_pass.order(),
    };
    for j in 0..ALL {
        pinned[(j, j)] += if fitted(j) { 1e-4 } else { 1e12 };
    }
    let covariance = pinned.try_inverse()?;
    let floor = if low_pass == LowPass::None { 0.0 } else { at[3].exp() };
    let plateau = at[0].exp() + floor;
    let mut of_plateau = Vector::zeros();
    (of_plateau[0], of_plateau[3]) = (at[0].exp() / plateau, floor / plateau);
    let (mut deviance, mut freedom, mut seen) = (0.0, 0.0, 0.0);
    for band in bands {
        let parts = model.parts(band.hz, &at);
        let density: f64 = parts.iter().sum();
        let ratio = band.density / density;
        deviance += 2.0 * band.weight * (ratio - 1.0 - ratio.max(f64::MIN_POSITIVE).ln());
        freedom += 1.0 + 1.0 / (6.0 * band.weight);
        if model.gain(band.hz, &at) > 0.5 {
            seen += band.weight * ((parts[0] + parts[3]) / density).powi(2);
        }
    }
    let parameters = 3 + usize::from(low_pass != LowPass::None) + low_pass.order();
    Some(Fit {
        low_pass,
        plateau,
        plateau_deviation: (of_plateau.transpose() * covariance * of_plateau)[0].max(0.0).sqrt(),
        corner: at[CORNER].exp(),
        corner_deviation: covariance[(CORNER, CORNER)].max(0.0).sqrt(),
        quality: at[QUALITY].exp(),
        cost: 2.0 * cost + parameters as f64 * (bands.len() as f64).ln(),
        misfit: deviance / (freedom - parameters as f64).max(1.0),
        seen,
    })
}
