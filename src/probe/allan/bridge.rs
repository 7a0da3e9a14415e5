//! Single lost samples bridged, so that a log is one even series.
//!
//! A straight line stands in for up to [`BRIDGED`] samples. It has two thirds or half of their white noise, so of a log of which a share p was lost a
//! density reads less than p / 4 low; beyond [`MOST_BRIDGED`] nothing is bridged.

use crate::rest_noise::stretch::{BRIDGED, MOST_BRIDGED, is_even, lost_in, tell_of_loss};
use dpn_core::{ImuRecording, ImuSample};

/// The recording with its single lost samples put in, and how many; none where none is to be.
pub(super) fn bridged(recording: &ImuRecording) -> Option<(ImuRecording, usize)> {
    let (samples, period) = (recording.samples(), recording.rate().period());
    let steps = || samples.windows(2).map(|pair| pair[1].t.seconds_since(pair[0].t) / period);
    let put_in = |step: f64| Some(lost_in(step)).filter(|lost| *lost <= BRIDGED).unwrap_or(0);
    let count: usize = steps().map(put_in).sum();
    let tells = tell_of_loss(steps().filter(|step| is_even(*step)).count(), samples.len() - 1);
    if count == 0 || count as f64 > MOST_BRIDGED * samples.len() as f64 || !tells {
        return None;
    }
    let mut all = Vec::with_capacity(samples.len() + count);
    for (pair, step) in samples.windows(2).zip(steps()) {
        let [a, b] = [pair[0], pair[1]];
        all.push(a);
        let parts = put_in(step);
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
