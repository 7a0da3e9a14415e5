//! The periodogram of one long signal, averaged over neighbouring frequencies: what a model of its spectrum is fitted to.
//!
//! The whole signal is one segment, so that the lowest frequencies are there, under a taper (a tenth and a half at either end, raised cosine), which keeps what
//! drifts out of the rest and costs a tenth of the independent values. Lines, whose one frequency holds more than chance gives any, are counted and left out. A
//! band is 3 % wide; its density is a mean over as many frequencies as it has, chi-squared with twice [`Band::weight`] degrees of freedom.

use super::stats::median_in_place;
use crate::time::SampleRate;
use dpn_fft::{Complex, forward};
use std::f64::consts::{LN_2, PI};

/// Share of the signal that either end's taper takes.
const TAPER: f64 = 0.15;
/// Width of a band over its frequency.
const WIDTH: f64 = 0.03;
/// Bins that the taper's own width smears the mean and a drift over.
const FIRST: usize = 3;
/// Share of the way to half the rate that is looked at: above, filters made by the bilinear transform have a zero.
const HIGHEST: f64 = 0.9;
/// Bins on either side whose median is the level that a line stands out of.
const BESIDE: usize = 48;
/// A line stands above the level by the logarithm of the bins and this: by chance one signal in a hundred or so has one.
const STANDS_OUT: f64 = 5.0;
/// Longest transform; a longer signal is cut into segments of this, whose periodograms are averaged.
const LONGEST: usize = 1 << 18;

/// A band of neighbouring frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Its middle \[Hz\].
    pub hz: f64,
    /// Mean density, one-sided \[unit^2 / Hz\].
    pub density: f64,
    /// Independent values in the mean.
    pub weight: f64,
}

/// A periodogram in bands.
#[derive(Debug, Clone, PartialEq)]
pub struct Periodogram {
    /// From low to high.
    pub bands: Vec<Band>,
    /// Frequencies of lines that were left out \[Hz\].
    pub lines: Vec<f64>,
}

impl Periodogram {
    /// Of a signal without holes; none of fewer than 64 samples.
    pub fn of(signal: &[f64], rate: SampleRate) -> Option<Self> {
        let segment = signal.len().min(LONGEST);
        if segment < 64 {
            return None;
        }
        let length = segment as f64;
        let weights: Vec<f64> = (0..segment)
            .map(|i| {
                let edge = (i as f64 + 0.5).min(length - i as f64 - 0.5) / (TAPER * length);
                0.5 - 0.5 * (PI * edge.min(1.0)).cos()
            })
            .collect();
        let (squares, fourths) = weights.iter().fold((0.0, 0.0), |(s, f), w| (s + w * w, f + w.powi(4)));
        // Values that are as good as independent are fewer than bins by this.
        let smeared = length * fourths / (squares * squares);
        let fft = forward(segment);
        let mut density = vec![0.0; segment.div_ceil(2)];
        let segments = signal.len() / segment;
        let mut buffer = vec![Complex::default(); segment];
        for part in signal.chunks_exact(segment) {
            fill(&mut buffer, part, &weights);
            fft.process(&mut buffer);
            for (d, z) in density.iter_mut().zip(&buffer) {
                *d += 2.0 * z.norm_sqr() / (rate.hz() * squares * segments as f64);
            }
        }
        let bin = rate.hz() / length;
        let is_line = lines(&density, segments as f64);
        let mut found = Vec::new();
        for k in 1..density.len() {
            if is_line[k] && !is_line[k - 1] {
                let peak = (k..density.len())
                    .take_while(|j| is_line[*j])
                    .max_by(|a, b| density[*a].total_cmp(&density[*b]));
                found.extend(peak.map(|k| k as f64 * bin));
            }
        }
        Some(Self { bands: bands(&density, &is_line, bin, segments as f64 / smeared), lines: found })
    }
}

/// A part without its straight line, tapered.
fn fill(buffer: &mut [Complex<f64>], part: &[f64], weights: &[f64]) {
    let n = part.len() as f64;
    let mean = super::stats::mean(part);
    let middle = (n - 1.0) / 2.0;
    let slope = part.iter().enumerate().map(|(i, v)| (i as f64 - middle) * (v - mean)).sum::<f64>()
        / (n * (n * n - 1.0) / 12.0);
    for (i, ((z, v), w)) in buffer.iter_mut().zip(part).zip(weights).enumerate() {
        *z = Complex::new(w * (v - mean - slope * (i as f64 - middle)), 0.0);
    }
}

/// Which bins belong to a line.
fn lines(density: &[f64], segments: f64) -> Vec<bool> {
    let mut is_line = vec![false; density.len()];
    let limit = 1.0 + ((density.len() as f64).ln() + STANDS_OUT - 1.0) / segments.sqrt();
    let mut near = Vec::with_capacity(2 * BESIDE + 1);
    let mut k = FIRST;
    while k < density.len() {
        // Below, what drifts is no level; and few bins have no median to trust.
        let beside = BESIDE.min(k / 2);
        let step = (beside / 4).max(1);
        if beside >= 6 {
            near.clear();
            near.extend_from_slice(&density[k - beside..(k + beside + 1).min(density.len())]);
            let level = median_in_place(&mut near) / (LN_2 + (1.0 - LN_2) * (1.0 - 1.0 / segments));
            let limit = if beside >= BESIDE / 2 { limit } else { 2.0 * limit };
            for j in k..(k + step).min(density.len()) {
                if density[j] > limit * level {
                    is_line[j.saturating_sub(2)..(j + 3).min(density.len())].fill(true);
                }
            }
        }
        k += step;
    }
    is_line
}

fn bands(density: &[f64], is_line: &[bool], bin: f64, independent: f64) -> Vec<Band> {
    let last = (HIGHEST * density.len() as f64) as usize;
    let mut bands = Vec::new();
    let mut from = FIRST;
    while from < last {
        let to = ((from as f64 * (1.0 + WIDTH)).ceil() as usize).max(from + 1).min(last);
        let (mut count, mut sum, mut at) = (0.0, 0.0, 0.0);
        for k in (from..to).filter(|k| !is_line[*k]) {
            (count, sum, at) = (count + 1.0, sum + density[k], at + k as f64);
        }
        if count > 0.0 {
            bands.push(Band { hz: at / count * bin, density: sum / count, weight: count * independent });
        }
        from = to;
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn white(len: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        (0..len).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    #[test]
    fn white_noise_has_its_density_and_scatters_as_its_weights_say() {
        let rate = SampleRate::from_hz(200.0).unwrap();
        // Whole, and in segments.
        for len in [40_001, 3 * LONGEST] {
            let found = Periodogram::of(&white(len), rate).unwrap();
            assert!(found.lines.is_empty(), "{:?}", found.lines);
            let weight: f64 = found.bands.iter().map(|b| b.weight).sum();
            let mean = found.bands.iter().map(|b| b.weight * b.density).sum::<f64>() / weight;
            assert!((mean / 0.01 - 1.0).abs() < 4.0 / weight.sqrt(), "{mean} {weight}");
            let chi = found.bands.iter().map(|b| b.weight * (b.density / 0.01 - 1.0).powi(2)).sum::<f64>();
            let bands = found.bands.len() as f64;
            assert!((chi / bands - 1.0).abs() < 5.0 * (2.0 / bands).sqrt(), "{}", chi / bands);
        }
    }

    #[test]
    fn a_line_is_named_and_left_out() {
        let rate = SampleRate::from_hz(200.0).unwrap();
        let mut signal = white(20_000);
        for (i, v) in signal.iter_mut().enumerate() {
            *v += 0.5 * (2.0 * PI * 31.7 * i as f64 / 200.0).sin() + 1e-3 * i as f64;
        }
        let found = Periodogram::of(&signal, rate).unwrap();
        assert!(found.lines.len() == 1 && (found.lines[0] - 31.7).abs() < 0.02, "{:?}", found.lines);
        let near = found.bands.iter().filter(|b| (b.hz - 31.7).abs() < 2.0).map(|b| b.density);
        assert!(near.clone().count() > 0 && near.fold(0.0, f64::max) < 0.016);
    }
}
