//! Detail coefficients of the finest wavelet level, for robust noise figures.
//!
//! `detail[k] = sum_j high[j] x[2 k + 1 - j]` with the orthonormal analysis high-pass
//! `high[j] = (-1)^(j+1) scaling[j]` of Daubechies' families (PyWavelets' `dec_hi`). Only coefficients whose filter
//! lies wholly inside the signal are returned: no border extension colours them, and those of white noise are white
//! with the same deviation. Source: Daubechies 1992, table 6.1; Donoho and Johnstone 1994 for the noise figure.
//! Not here: deeper levels, reconstruction.

use crate::named;

named!(
    /// An orthogonal wavelet, named by its vanishing moments.
    pub enum Wavelet {
        /// Haar = Daubechies 1: blind to a constant.
        Haar = "haar",
        /// Daubechies 2: blind to a straight line.
        Db2 = "db2",
        /// Daubechies 4: blind to a cubic.
        Db4 = "db4",
    }
);

const HAAR: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2];
const DB2: [f64; 4] =
    [0.482_962_913_144_534_16, 0.836_516_303_737_807_9, 0.224_143_868_042_013_4, -0.129_409_522_551_260_37];
const DB4: [f64; 8] = [
    0.230_377_813_308_896_5,
    0.714_846_570_552_915_7,
    0.630_880_767_929_858_9,
    -0.027_983_769_416_859_854,
    -0.187_034_811_719_093_09,
    0.030_841_381_835_560_764,
    0.032_883_011_666_885_2,
    -0.010_597_401_785_069_032,
];

impl Wavelet {
    /// Scaling coefficients, of sum `sqrt(2)` and norm 1.
    pub fn scaling(self) -> &'static [f64] {
        match self {
            Self::Haar => &HAAR,
            Self::Db2 => &DB2,
            Self::Db4 => &DB4,
        }
    }
}

/// Finest-level detail coefficients of `x` that no border touches.
///
/// # Shapes
/// Half as many values as samples, less the filter's reach; none for a signal shorter than the filter.
pub fn finest_detail(x: &[f64], wavelet: Wavelet) -> Vec<f64> {
    let scaling = wavelet.scaling();
    let last = scaling.len() - 1;
    let coefficient = |window: &[f64]| -> f64 {
        // `window[last - j]` is x[2 k + 1 - j]; `high[j]` is `scaling[j]`, its sign turned at even j.
        let term = |(j, s): (usize, &f64)| {
            let product = s * window[last - j];
            if j.is_multiple_of(2) { -product } else { product }
        };
        scaling.iter().enumerate().map(term).sum()
    };
    x.windows(scaling.len()).step_by(2).map(coefficient).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Golden {
        cases: Vec<Case>,
    }

    #[derive(Deserialize)]
    struct Case {
        wavelet: String,
        x: Vec<f64>,
        detail: Vec<f64>,
    }

    #[test]
    fn inner_coefficients_agree_with_pywavelets() {
        let golden: Golden = dpn_testing::golden("wavelet");
        for case in &golden.cases {
            let wavelet = Wavelet::called(&case.wavelet).unwrap();
            let got = finest_detail(&case.x, wavelet);
            assert_eq!(got.len(), case.detail.len(), "{} of {}", case.wavelet, case.x.len());
            for (a, b) in got.iter().zip(&case.detail) {
                assert!((a - b).abs() < 1e-13, "{}: {a} is not {b}", case.wavelet);
            }
        }
    }

    #[test]
    fn every_scaling_filter_is_orthonormal_to_its_even_shifts() {
        for wavelet in Wavelet::ALL {
            let s = wavelet.scaling();
            assert!((s.iter().sum::<f64>() - 2f64.sqrt()).abs() < 1e-12, "{}", wavelet.name());
            for shift in (0..s.len()).step_by(2) {
                let product: f64 = s[shift..].iter().zip(s).map(|(a, b)| a * b).sum();
                let expected = f64::from(u8::from(shift == 0));
                assert!((product - expected).abs() < 1e-12, "{} shift {shift}", wavelet.name());
            }
        }
    }

    #[test]
    fn a_polynomial_below_the_vanishing_moments_leaves_nothing() {
        for (wavelet, degree) in [(Wavelet::Haar, 0), (Wavelet::Db2, 1), (Wavelet::Db4, 3)] {
            let x: Vec<f64> = (0..40).map(|i| (f64::from(i) / 10.0).powi(degree)).collect();
            assert!(finest_detail(&x, wavelet).iter().all(|d| d.abs() < 1e-10), "{}", wavelet.name());
            let beyond: Vec<f64> = (0..40).map(|i| (f64::from(i) / 10.0).powi(degree + 1)).collect();
            assert!(finest_detail(&beyond, wavelet).iter().any(|d| d.abs() > 1e-4));
        }
    }

    #[test]
    fn a_signal_shorter_than_the_filter_has_no_inner_coefficient() {
        assert!(finest_detail(&[1.0; 7], Wavelet::Db4).is_empty());
        assert!(finest_detail(&[], Wavelet::Haar).is_empty());
    }
}
