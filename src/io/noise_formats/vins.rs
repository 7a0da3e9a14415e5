//! What VINS-Mono and VINS-Fusion make of their figures: deviations per sample, which the code squares and never scales by the rate.
//!
//! A step of its mid-point integration counts the noise of two samples with half weight each and takes the sample that two steps share
//! for two independent ones. So what it propagates is half of the variance of white noise of that deviation: a density of
//! `acc_n * sqrt(dt / 2)`, not `acc_n * sqrt(dt)`. `acc_w` and `gyr_w` enter as a rate of change of the bias that holds for one step.

use super::number::{number, short};
use super::step::Remark;
use dpn_core::noise::Meaning;
use dpn_core::noise::{Figure, ImuFigures};
use dpn_core::time::SampleRate;

/// What VINS makes of numbers it is given.
pub(super) fn written(figures: &ImuFigures, rate: SampleRate) -> Option<Remark> {
    let std = |figure| Some(figures.get(figure, Meaning::SampleStd, rate)?.largest());
    let (accel, gyro) = (std(Figure::AccelWhite)?, std(Figure::GyroWhite)?);
    let whole = |v: f64| number(v * 2f64.sqrt());
    Some(Remark(format!(
        "vins: its mid-point integration counts half of this variance; to have all of it propagated write acc_n: {}, gyr_n: {} \
         (times sqrt(2))",
        whole(accel),
        whole(gyro)
    )))
}

/// What VINS made of the numbers it was given.
pub(super) fn was_read(figures: &ImuFigures) -> Option<Remark> {
    let half = |figure| Some(short(figures.density(figure)?.largest() / 2f64.sqrt()));
    Some(Remark(format!(
        "vins: its mid-point integration counts half of this variance, so it acts as with densities of {} m/s^2/sqrt(Hz) and \
         {} rad/s/sqrt(Hz)",
        half(Figure::AccelWhite)?,
        half(Figure::GyroWhite)?
    )))
}
