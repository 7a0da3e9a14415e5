//! The overlapping Allan variance from cumulative sums.
//!
//! With theta the integral of the signal and m samples to an average,
//! sigma^2(m) = sum over i of (theta_(i+2m) - 2 theta_(i+m) + theta_i)^2 / (2 (m tau0)^2 (n + 1 - 2m)).
//! Source: Riley, Handbook of Frequency Stability Analysis (NIST SP 1065), 5.2.

use dpn_core::SampleRate;

/// How many averaging times there are to a decade.
const PER_DECADE: f64 = 8.0;

/// Averaging times from one sample to a third of `samples`, evenly spaced in their logarithm, in samples.
pub(crate) fn averages(samples: usize) -> Vec<usize> {
    let most = samples / 3;
    let mut averages: Vec<usize> = (0..)
        .map(|k| 10f64.powf(f64::from(k) / PER_DECADE).round() as usize)
        .take_while(|m| *m <= most)
        .collect();
    averages.dedup();
    averages
}

/// Overlapping Allan variance of `signal` at each of `averages` (samples, at most half of the signal's); squared unit of the signal.
///
/// Rounding: sums run over the signal less its mean, so that gravity does not eat digits.
pub fn variances(signal: &[f64], rate: SampleRate, averages: &[usize]) -> Vec<f64> {
    let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
    let mut theta = Vec::with_capacity(signal.len() + 1);
    let mut sum = 0.0;
    theta.push(sum);
    theta.extend(signal.iter().map(|v| {
        sum += (v - mean) * rate.period();
        sum
    }));
    averages.iter().map(|&m| variance(&theta, rate, m)).collect()
}

fn variance(theta: &[f64], rate: SampleRate, m: usize) -> f64 {
    /// Sums of this many terms are added up on their own: fast, and the same bits on every run.
    const LANES: usize = 8;
    let Some(terms) = theta.len().checked_sub(2 * m).filter(|n| *n > 0 && m > 0) else {
        return f64::NAN;
    };
    let (early, middle, late) = (&theta[..terms], &theta[m..m + terms], &theta[2 * m..]);
    let mut sums = [0.0; LANES];
    let whole = terms - terms % LANES;
    let square = |a: f64, b: f64, c: f64| {
        let second = c - 2.0 * b + a;
        second * second
    };
    for at in (0..whole).step_by(LANES) {
        let (a, b, c) = (&early[at..at + LANES], &middle[at..at + LANES], &late[at..at + LANES]);
        for lane in 0..LANES {
            sums[lane] += square(a[lane], b[lane], c[lane]);
        }
    }
    let rest: f64 = (whole..terms).map(|i| square(early[i], middle[i], late[i])).sum();
    let tau = m as f64 * rate.period();
    (sums.iter().sum::<f64>() + rest) / (2.0 * tau * tau * terms as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_rise_from_one_sample_to_a_third() {
        let averages = averages(1_000_000);
        assert_eq!(averages[..4], [1, 2, 3, 4]);
        assert!(averages.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(averages.last(), Some(&316_228));
        assert!(super::averages(2).is_empty());
    }

    #[test]
    fn a_steady_slope_is_the_ramp_of_the_model() {
        let rate = SampleRate::from_hz(50.0).unwrap();
        let ramp: Vec<f64> = (0..600).map(|i| 9.81 + 0.3 * f64::from(i) / 50.0).collect();
        for (m, got) in [1, 7, 200].into_iter().zip(variances(&ramp, rate, &[1, 7, 200])) {
            let tau = f64::from(m) / 50.0;
            assert!((got / (0.09 * tau * tau / 2.0) - 1.0).abs() < 1e-8, "{m}");
        }
    }

    #[test]
    fn too_long_an_average_is_no_number() {
        assert!(variances(&[1.0, 2.0, 3.0], SampleRate::HZ_200, &[2])[0].is_nan());
        assert!(variances(&[], SampleRate::HZ_200, &[1])[0].is_nan());
    }
}
