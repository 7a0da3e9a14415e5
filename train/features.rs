//! What a regressor sees of a window: logarithms of deviations that white noise raises and motion or vibration raise
//! otherwise.

use crate::base::Base;
use crate::windows::WINDOW;
use dpn_core::SampleRate;
use dpn_core::signal::spectrum::Welch;
use dpn_core::signal::stats::{Ddof, deviation, difference_gain, differences, mad};
use dpn_core::signal::wavelet::{Wavelet, finest_detail};
use dpn_core::signal::{FilterError, SavitzkyGolay};
use rayon::prelude::*;

/// Bands of equal width between 0 and half the rate whose deviation is a feature.
const BANDS: usize = 10;

/// Highest order of differences used.
const MAX_DIFFERENCE: usize = 4;

/// Logarithms are taken of deviations no smaller than this share of the sensor's unit: a constant window has features too.
const FLOOR: f64 = 1e-9;

/// Computes the features of windows; holds the filters.
pub struct Features {
    filters: Vec<(SavitzkyGolay, f64)>,
    welch: Welch,
}

/// Why features cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum FeatureError {
    /// A filter of the study cannot be built.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The spectrum's segment cannot be.
    #[error(transparent)]
    Spectrum(#[from] dpn_core::signal::spectrum::SpectrumError),
}

impl Features {
    /// Number of features of a window.
    pub const COUNT: usize = Base::STUDY.len() + MAX_DIFFERENCE + 2 + BANDS;

    /// Builds filters and spectrum for windows of [`WINDOW`] samples.
    ///
    /// # Errors
    /// None for the constants used here; kept typed because filters are data elsewhere.
    pub fn new() -> Result<Self, FeatureError> {
        let mut filters = Vec::new();
        for base in Base::STUDY {
            if let Some(filter) = base.filter()? {
                let gain = filter.residual_gain(WINDOW);
                filters.push((filter, gain));
            }
        }
        Ok(Self { filters, welch: Welch::new(WINDOW)? })
    }

    /// The features of one window, in their order: logarithms of what each base of the study leaves, of differences, of two robust deviations and of the spectrum's bands.
    ///
    /// # Shapes
    /// `window`: [`WINDOW`] samples; the answer: [`COUNT`](Self::COUNT) numbers.
    ///
    /// # Panics
    /// When `window` is shorter than the study's filters or a segment of the spectrum.
    pub fn of(&self, window: &[f64]) -> Vec<f64> {
        let mut features = Vec::with_capacity(Self::COUNT);
        let mut smooth = vec![0.0; window.len()];
        for (filter, gain) in &self.filters {
            filter.smooth_into(window, &mut smooth).expect("a window is longer than the study's filters");
            let squares = window.iter().zip(&smooth).map(|(x, s)| (x - s).powi(2)).sum::<f64>();
            let residual = squares / window.len() as f64;
            features.push(residual.sqrt() / gain);
        }
        for order in 1..=MAX_DIFFERENCE {
            features.push(deviation(&differences(window, order), Ddof::One) / difference_gain(order));
        }
        features.push(mad(&differences(window, 2)) / difference_gain(2));
        features.push(mad(&finest_detail(window, Wavelet::Db4)));
        // The rate only names the bands: shares of the Nyquist frequency are meant.
        let spectrum =
            self.welch.spectrum(window, SampleRate::HZ_200).expect("a window is longer than a segment");
        let width = 100.0 / BANDS as f64;
        let band = |b: usize| spectrum.band_power(b as f64 * width, (b + 1) as f64 * width);
        features.extend((0..BANDS).map(|b| band(b).max(0.0).sqrt()));
        features.iter_mut().for_each(|value| *value = value.max(FLOOR).ln());
        features
    }

    /// The features of many windows, row by row.
    ///
    /// # Shapes
    /// `samples`: rows of [`WINDOW`]; the answer: rows of [`COUNT`](Self::COUNT).
    pub fn table(&self, samples: &[f64]) -> Vec<f64> {
        let rows: Vec<Vec<f64>> = samples.par_chunks_exact(WINDOW).map(|window| self.of(window)).collect();
        rows.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::inject;
    use dpn_core::random::Stream;

    #[test]
    fn doubling_the_signal_adds_ln_2_to_every_feature() {
        let features = Features::new().unwrap();
        let mut window = vec![0.0; WINDOW];
        inject(&mut window, 0.1, &mut Stream::new(1).named("features").rng());
        let twice: Vec<f64> = window.iter().map(|v| 2.0 * v).collect();
        let (a, b) = (features.of(&window), features.of(&twice));
        assert_eq!(a.len(), Features::COUNT);
        for (i, (x, y)) in a.iter().zip(&b).enumerate() {
            assert!((y - x - 2f64.ln()).abs() < 1e-9, "feature {i}");
        }
    }

    #[test]
    fn the_boosted_trees_see_the_same_features() {
        let text = include_str!("../golden/boosted_trees/result.json");
        let golden: serde_json::Value = serde_json::from_str(text).unwrap();
        let numbers = |key: &str| -> Vec<f64> {
            let list = golden["features"][key].as_array().unwrap();
            list.iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let (found, expected) = (Features::new().unwrap().of(&numbers("window")), numbers("values"));
        assert_eq!(found.len(), expected.len());
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() < 1e-9, "feature {i}: {a} {b}");
        }
    }

    #[test]
    fn a_constant_window_has_finite_features() {
        assert!(Features::new().unwrap().of(&[9.81; WINDOW]).iter().all(|f| f.is_finite()));
    }
}
