//! A recording at a lower rate, behind the low pass that this needs.
//!
//! A new sample is a weighted mean of the samples around it, at their own stamps: a sinc that ends under Kaiser's window. What lies below 0.4 of the new rate passes, above 0.5 it is
//! 60 dB down, so that a white noise keeps its density and nothing folds back. Source: Oppenheim and Schafer, Discrete-Time Signal Processing, 7.5.3.

use crate::{ImuSample, SampleRate, Stamp};
use std::f64::consts::PI;

/// What lies below this share of the new rate passes,
pub const PASSES: f64 = 0.4;
/// and above this nothing does.
pub const STOPS: f64 = 0.5;
/// The middle of the slope, of the new rate.
const CUTOFF: f64 = 0.5 * (PASSES + STOPS);
/// Kaiser's shape for 60 dB,
const SHAPE: f64 = 5.65;
/// and the window that makes the slope as steep, in periods of the new rate: no shorter log can be resampled.
pub const WINDOW_PERIODS: f64 = 36.0;
/// A window with a smaller share of its samples has a gap.
const WHOLE: f64 = 0.98;

/// Samples of `rate` at the lower rate `to`. Half a window at both ends, and beside gaps, has no samples.
pub fn resampled(samples: &[ImuSample], rate: SampleRate, to: SampleRate) -> Vec<ImuSample> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Vec::new() };
    let (half_s, cutoff_hz) = (0.5 * WINDOW_PERIODS * to.period(), CUTOFF * to.hz());
    let weight = |seconds: f64| {
        let x = 2.0 * cutoff_hz * seconds;
        let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
        let at = seconds / half_s;
        sinc * bessel(SHAPE * (1.0 - at * at).max(0.0).sqrt())
    };
    let whole = WHOLE * 2.0 * half_s * rate.hz();
    let tick = |seconds: f64| (seconds / to.period()) as usize;
    let count = tick(last.t.seconds_since(first.t));
    let (mut out, mut next) = (Vec::new(), 0);
    while next <= count {
        let t: Stamp = first.t.plus_seconds(next as f64 * to.period());
        next += 1;
        let from = samples.partition_point(|s| s.t.seconds_since(t) <= -half_s);
        let end = samples.partition_point(|s| s.t.seconds_since(t) < half_s);
        if from == end {
            // A gap may be years long: the next sample that a window reaches, no tick before.
            let Some(sample) = samples.get(end) else { break };
            next = next.max(tick(sample.t.seconds_since(first.t) - half_s));
        }
        if ((end - from) as f64) < whole {
            continue;
        }
        let (mut gyro, mut accel, mut sum) = ([0.0; 3], [0.0; 3], 0.0);
        for sample in &samples[from..end] {
            let w = weight(sample.t.seconds_since(t));
            sum += w;
            for axis in 0..3 {
                gyro[axis] += w * sample.gyro[axis];
                accel[axis] += w * sample.accel[axis];
            }
        }
        out.push(ImuSample { t, gyro: gyro.map(|v| v / sum), accel: accel.map(|v| v / sum) });
    }
    out
}

/// Modified Bessel function of order zero, by its series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..40 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;

    fn recording(of: &mut dyn FnMut(f64) -> f64) -> Vec<ImuSample> {
        let sample = |i: i64| {
            let t = Stamp::from_ns(5_000_000 * i);
            ImuSample { t, gyro: [of(5e-3 * i as f64), 1.0, -2.0], accel: [0.0, 0.0, 9.81] }
        };
        (0..8000).map(sample).collect()
    }

    fn at_80(samples: &[ImuSample]) -> Vec<ImuSample> {
        resampled(samples, SampleRate::HZ_200, SampleRate::from_hz(80.0).unwrap())
    }

    fn rms(samples: &[ImuSample], less: &dyn Fn(f64) -> f64) -> f64 {
        let off = |s: &ImuSample| s.gyro[0] - less(s.t.ns() as f64 * 1e-9);
        (samples.iter().map(|s| off(s).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
    }

    #[test]
    fn slow_tones_pass_fast_ones_do_not_fold_and_constants_stand() {
        for (hz, passes) in
            [(0.5, true), (10.0, true), (30.0, true), (42.0, false), (75.0, false), (95.0, false)]
        {
            let tone = |t: f64| (2.0 * PI * hz * t).sin();
            let out = at_80(&recording(&mut { tone }));
            assert!(out.iter().all(|s| (s.gyro[1] - 1.0).abs() < 1e-12 && (s.accel[2] - 9.81).abs() < 1e-12));
            let off = rms(&out, &|t| if passes { tone(t) } else { 0.0 });
            assert!(off < 2e-3, "{hz} Hz: {off}");
        }
    }

    #[test]
    fn white_noise_keeps_its_density() {
        let mut rng = Stream::new(3).named("resample").rng();
        let out = at_80(&recording(&mut |_| rng.sample(StandardNormal)));
        // Of 200 Hz what lies below 36 Hz, twice, is left.
        let expected = (2.0 * 36.0 / 200.0_f64).sqrt();
        let found = rms(&out, &|_| 0.0);
        assert!((found / expected - 1.0).abs() < 0.04, "{found} {expected}");
    }

    #[test]
    fn no_sample_is_made_in_a_gap() {
        let mut samples = recording(&mut |t| t);
        samples.drain(3000..3400);
        let out = at_80(&samples);
        let in_gap = |s: &&ImuSample| (14.9..17.1).contains(&(s.t.ns() as f64 * 1e-9));
        assert!(out.iter().filter(in_gap).count() == 0 && out.len() > 2900, "{}", out.len());
        // Behind three years the samples are those of the log without them, and no tick between is looked at.
        let years = Stamp::from_ns(0).plus_seconds(1e8).ns();
        samples[5000..].iter_mut().for_each(|s| s.t = Stamp::from_ns(s.t.ns() + years));
        let apart = at_80(&samples);
        assert!(
            apart.len() > 2850
                && apart.windows(2).filter(|two| two[1].t.seconds_since(two[0].t) > 0.02).count() == 2
        );
        assert!(at_80(&samples[..20]).is_empty() && at_80(&[]).is_empty());
    }
}
