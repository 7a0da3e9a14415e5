//! Single lost samples bridged, so that a log is one even series.
//!
//! A straight line stands in for up to [`BRIDGED`] samples. It has two thirds or half of their white noise, so of a log of which a share p was lost a
//! density reads less than p / 4 low; beyond [`MOST_BRIDGED`] nothing is bridged.

use crate::rest_noise::stretch::{BRIDGED, EVEN, MOST_BRIDGED};
use dpn_core::{ImuRecording, ImuSample};

/// The recording with its single lost samples put in, and how many; none where none is to be.
pub(super) fn bridged(recording: &ImuRecording) -> Option<(ImuRecording, usize)> {
    let (samples, period) = (recording.samples(), recording.rate().period());
    let steps = || samples.windows(2).map(|pair| pair[1].t.seconds_since(pair[0].t) / period);
    let lost = |step: f64| (step.round() as usize).saturating_sub(1);
    let is_bridged = |step: f64| (1..=BRIDGED).contains(&lost(step));
    let count: usize = steps().filter(|step| is_bridged(*step)).map(lost).sum();
    let even = steps().filter(|step| (step - 1.0).abs() < 0.25).count() as f64;
    // Stamps that jitter tell of no loss.
    let tells = even >= EVEN * (1.0 - MOST_BRIDGED) * (samples.len() - 1) as f64;
    if count == 0 || count as f64 > MOST_BRIDGED * samples.len() as f64 || !tells {
        return None;
    }
    let mut all = Vec::with_capacity(samples.len() + count);
    for (pair, step) in samples.windows(2).zip(steps()) {
        let [a, b] = [pair[0], pair[1]];
        all.push(a);
        let parts = if is_bridged(step) { lost(step) } else { 0 };
        for k in 1..=parts {
            let share = k as f64 / (parts + 1) as f64;
            let line = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share);
            let t = a.t.plus_seconds(b.t.seconds_since(a.t) * share);
            all.push(ImuSample { t, gyro: line(a.gyro, b.gyro), accel: line(a.accel, b.accel) });
        }
    }
    all.push(samples[samples.len() - 1]);
    Some((
        ImuRecording::new(all).expect("a line between two samples is finite and between their stamps"),
        count,
    ))
}
