//! What every estimator owes: no bias under white noise, a known spread, scale with the signal, blindness to the
//! trends it promises to ignore.

use super::spec::{EstimatorSpec, NoiseSpec, SensorPair, SensorSpec};
use super::{WindowSigma, allan, differences, sg_residual};
use crate::bounds::cramer_rao_sigma;
use crate::random::Stream;
use crate::signal::stats::{Ddof, deviation, mean};
use proptest::prelude::*;
use rand::Rng;
use rand_distr::StandardNormal;
use std::sync::Arc;

const SAMPLES: usize = 200;
const WINDOWS: u64 = 20_000;

fn estimator(spec: &str) -> Arc<dyn WindowSigma> {
    let NoiseSpec::Sensors(SensorPair { accel: SensorSpec::Estimator(estimator), .. }) =
        spec.parse().unwrap()
    else {
        panic!("{spec} is no estimator")
    };
    estimator.for_windows(SAMPLES).unwrap()
}

fn white(window: u64, sigma: f64) -> Vec<f64> {
    let mut rng = Stream::new(8).named("estimate").named("white").index(window).rng();
    (0..SAMPLES).map(|_| sigma * rng.sample::<f64, _>(StandardNormal)).collect()
}

/// Spread over the Cramer-Rao bound under white noise, 200 samples; the table of `estimate`'s opening text.
const SPREADS: [(&str, f64); 17] = [
    ("sg(5,2)", 1.61),
    ("sg(11,2)", 1.19),
    ("sg(51,3)", 1.04),
    ("diff1", 1.23),
    ("diff2", 1.40),
    ("diff3", 1.52),
    ("diff4", 1.63),
    ("allan", 1.23),
    ("mad2", 1.99),
    ("wavelet(haar)", 2.31),
    ("wavelet(db4)", 2.36),
    ("running", 1.00),
    ("running(50)", 2.02),
    ("sliding(200)", 1.00),
    ("ewma(0.01)", 1.15),
    ("ewma(0.1)", 3.24),
    ("kalman(0.1)", 1.04),
];

#[test]
fn under_white_noise_no_estimator_is_biased_and_each_spreads_as_documented() {
    let estimators: Vec<_> = SPREADS.iter().map(|(spec, _)| estimator(spec)).collect();
    let mut answers = vec![Vec::with_capacity(WINDOWS as usize); SPREADS.len()];
    for window in 0..WINDOWS {
        let x = white(window, 0.05);
        for (answers, estimator) in answers.iter_mut().zip(&estimators) {
            answers.push(estimator.sigma(&x) / 0.05);
        }
    }
    let bound = cramer_rao_sigma(1.0, SAMPLES);
    let mut faults = Vec::new();
    for ((spec, documented), answers) in SPREADS.iter().zip(&answers) {
        let spread = deviation(answers, Ddof::One);
        let errors = (mean(answers) - 1.0) / (spread / (WINDOWS as f64).sqrt());
        let ratio = spread / bound;
        if errors.abs() > 3.0 || (ratio / documented - 1.0).abs() > 0.02 {
            faults.push(format!(
                "{spec}: bias {errors:.2} standard errors, spread {ratio:.3} x bound, not {documented}"
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_exact_spread_of_the_quadratic_estimators_is_the_measured_one() {
    // spread / bound = sqrt(n / nu), from the linear map alone.
    let centred = |order: usize| {
        move |x: &[f64]| {
            let d = crate::signal::stats::differences(x, order);
            let m = mean(&d);
            d.iter().map(|v| v - m).collect::<Vec<_>>()
        }
    };
    for (order, documented) in [(1, 1.23), (2, 1.40), (3, 1.52), (4, 1.63)] {
        let nu = super::quadratic::Gain::of(SAMPLES, centred(order)).nu();
        let ratio = (SAMPLES as f64 / nu).sqrt();
        assert!((ratio - documented).abs() < 0.01, "diff{order}: {ratio:.4}");
    }
}

#[test]
fn other_window_lengths_than_the_designed_one_are_unbiased_too() {
    for spec in ["sg(11,2)", "diff2", "allan", "mad2", "wavelet", "ewma(0.1)", "kalman", "running"] {
        let estimator = estimator(spec);
        let answers: Vec<f64> = (0..600).map(|w| estimator.sigma(&white(w, 1.0)[..40])).collect();
        let error = deviation(&answers, Ddof::One) / (answers.len() as f64).sqrt();
        assert!((mean(&answers) - 1.0).abs() < 3.0 * error, "{spec}: {} +- {error}", mean(&answers));
    }
}

#[test]
fn a_constant_window_gives_zero_and_a_short_one_nan() {
    for spec in EstimatorSpec::all() {
        let estimator = spec.for_windows(SAMPLES).unwrap();
        assert!(estimator.sigma(&[9.81; SAMPLES]).abs() < 1e-13, "{spec}");
        assert!(estimator.sigma(&vec![9.81; estimator.min_len() - 1]).is_nan(), "{spec}");
        assert!(estimator.sigma(&vec![9.81; estimator.min_len()]).is_finite(), "{spec}");
    }
}

#[test]
fn a_streaming_estimator_in_window_form_starts_fresh_every_time() {
    for spec in EstimatorSpec::all() {
        let estimator = spec.for_windows(SAMPLES).unwrap();
        let first = estimator.sigma(&white(0, 1.0));
        estimator.sigma(&white(1, 30.0));
        assert_eq!(estimator.sigma(&white(0, 1.0)), first, "{spec}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn sigma_scales_with_the_signal_and_ignores_its_level(
        window in 0_u64..1000, a in prop::sample::select(vec![-3.0, -0.01, 0.5, 40.0]), b in -20.0..20.0_f64,
    ) {
        let x = white(window, 1.0);
        let y: Vec<f64> = x.iter().map(|v| a * v + b).collect();
        for spec in EstimatorSpec::all() {
            let estimator = spec.for_windows(SAMPLES).unwrap();
            let (before, after) = (estimator.sigma(&x), estimator.sigma(&y));
            prop_assert!((after / (a.abs() * before) - 1.0).abs() < 1e-9, "{}: {} {}", spec, before, after);
        }
    }

    #[test]
    fn trends_an_estimator_promises_to_ignore_leave_it_unmoved(
        window in 0_u64..1000, c in prop::collection::vec(-5.0..5.0_f64, 4),
    ) {
        let x = white(window, 1.0);
        let with_trend = |degree: usize| -> Vec<f64> {
            let trend = |t: f64| c[..=degree].iter().rev().fold(0.0, |sum, c| sum * t + c);
            x.iter().enumerate().map(|(i, v)| v + trend(i as f64 / 100.0)).collect()
        };
        for (spec, degree) in
            [("diff1", 1), ("diff2", 2), ("diff3", 3), ("mad2", 2), ("sg(11,2)", 2), ("sg(51,3)", 3), ("wavelet(db4)", 3)]
        {
            let estimator = estimator(spec);
            let (before, after) = (estimator.sigma(&x), estimator.sigma(&with_trend(degree)));
            prop_assert!((after / before - 1.0).abs() < 1e-9, "{}: {} {}", spec, before, after);
        }
    }
}

#[test]
fn a_steep_slope_moves_those_that_promise_nothing() {
    let x: Vec<f64> = white(0, 1.0).iter().enumerate().map(|(i, v)| v + i as f64).collect();
    assert!(allan(SAMPLES).unwrap().sigma(&x) > 1.15);
    for spec in ["running", "sliding", "ewma", "kalman"] {
        assert!(estimator(spec).sigma(&x) > 1.5, "{spec}");
    }
    assert!(differences(1, SAMPLES).unwrap().sigma(&x) < 1.15);
    assert!(sg_residual(11, 2, SAMPLES).unwrap().sigma(&x) < 1.15);
}
