//! A gyroscope's noise while the accelerometer beside it is quiet: what no sensor has is one of another unit.

use crate::imu::ImuSample;
use crate::samples::Samples;
use crate::signal::stats;
use std::io;

/// Noise of a sample above which numbers are no rad/s: real gyroscopes stay below .005, and .02 deg/s is little.
pub const LOUD_GYRO: f64 = 0.02;
/// Samples that are looked at.
const LOOKED_AT: usize = 200_000;
/// Samples of a stretch.
const STRETCH: usize = 100;
/// Quiet stretches that tell.
const LEAST: usize = 5;
/// Noise of the accelerometer, in lengths of its vector, below which nothing shakes.
const QUIET: f64 = 0.01;
/// Spread of a gyroscope's axis over a stretch, in its noise, above which it turns: slowly sampled turns have large differences too.
const TURNING: f64 = 3.0;

/// Noise of a sample on the loudest axis that does not turn in a stretch in which the accelerometer, in whatever unit, does not shake: the lowest tenth of the
/// stretches; none where there are hardly any.
///
/// # Errors
/// As [`Samples::piece`].
pub fn quiet_gyro_noise(samples: &dyn Samples) -> io::Result<Option<f64>> {
    let noise = |signal: &[f64]| {
        stats::deviation(&stats::differences(signal, 2), stats::Ddof::Zero) / stats::difference_gain(2)
    };
    let axes = |stretch: &[ImuSample], of: fn(&ImuSample) -> [f64; 3]| {
        [0, 1, 2].map(|i| stretch.iter().map(|s| of(s)[i]).collect::<Vec<f64>>())
    };
    let shakes =
        |stretch: &[ImuSample]| axes(stretch, |s| s.accel).iter().map(|x| noise(x)).fold(0.0, f64::max);
    // An axis that turns says nothing of its noise.
    let loudest = |stretch: &[ImuSample]| {
        let still = axes(stretch, |s| s.gyro).into_iter().filter_map(|signal| {
            let noise = noise(&signal);
            (stats::deviation(&signal, stats::Ddof::Zero) <= TURNING * noise).then_some(noise)
        });
        still.reduce(f64::max)
    };
    let length = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut noises = Vec::new();
    samples.pieces(0..samples.len().min(LOOKED_AT), STRETCH, &mut |stretch| {
        if stretch.len() == STRETCH && shakes(stretch) < QUIET * length(stretch[0].accel) {
            noises.extend(loudest(stretch));
        }
        Ok(())
    })?;
    noises.sort_by(f64::total_cmp);
    Ok((noises.len() >= LEAST).then(|| noises[noises.len() / 10]))
}
