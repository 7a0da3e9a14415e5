//! Units and columns that nobody named, told from the numbers.
//!
//! * Accelerometer: the median length of its vector is gravity's on any vehicle, within a factor: .5 to 2 is g, 500 to 2000 mg,
//!   but within a per cent of 981, where it is cm/s^2; all else m/s^2.
//! * Gyroscope: where the accelerometer is quiet, a gyroscope's sample scatters by less than .02 rad/s, while .02 deg/s is little. Else, were
//!   the numbers rad/s, they would turn the accelerometer's vector back to one that is the same for seconds: gravity. Where they do not, they
//!   count in degrees. (That gravity turns in the body's frame as the gyroscope says would be simpler and is wrong in the air: a rotor craft
//!   feels its thrust, which stays where it is.)
//! * Columns without a header: the triple that has gravity's length is the accelerometer's.

use super::columns::{AccelUnit, GyroUnit};
use dpn_core::imu::ImuSample;
use dpn_core::signal::stats;
use dpn_core::{LOUD_GYRO, Samples, quiet_gyro_noise};
use nalgebra::{UnitQuaternion, Vector3};
use std::io;

/// Samples that are looked at.
const LOOKED_AT: usize = 200_000;
/// Length of a stretch over which turned vectors should stay gravity \[s\].
const STRETCH_S: f64 = 5.0;
/// A stretch says something when it turns by this much, were its numbers in rad/s.
const TURNS: f64 = 1.0;
/// Mean of the turned vectors, in lengths of the vector, below which the numbers are no rad/s.
const STAYS: f64 = 0.85;

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn thinned(samples: &dyn Samples, take: &mut dyn FnMut(&ImuSample)) -> io::Result<()> {
    let step = samples.len().div_ceil(LOOKED_AT).max(1);
    let mut index = 0_usize;
    samples.each(0..samples.len(), &mut |sample| {
        if index.is_multiple_of(step) {
            take(sample);
        }
        index += 1;
    })
}

/// Median length of a sensor's vector; none of no samples.
fn length(samples: &dyn Samples, of: fn(&ImuSample) -> [f64; 3]) -> io::Result<Option<f64>> {
    let mut lengths = Vec::new();
    thinned(samples, &mut |s| lengths.push(norm(of(s))))?;
    Ok(stats::median_of(lengths))
}

/// The unit of an accelerometer whose numbers stand in `samples`.
pub(crate) fn accel_unit(samples: &dyn Samples) -> io::Result<AccelUnit> {
    Ok(match length(samples, |s| s.accel)? {
        Some(g) if (0.5..2.0).contains(&g) => AccelUnit::StandardGravity,
        // Nearer to 980.665 than to 1000.
        Some(gal) if (970.0..990.3).contains(&gal) => AccelUnit::CentimetrePerSecond2,
        Some(mg) if (500.0..2000.0).contains(&mg) => AccelUnit::MilliGravity,
        _ => AccelUnit::MetrePerSecond2,
    })
}

/// The unit of a gyroscope whose numbers stand in `samples`; the accelerometer may be in any unit.
pub(crate) fn gyro_unit(samples: &dyn Samples) -> io::Result<GyroUnit> {
    let mut fastest = 0.0_f64;
    thinned(samples, &mut |s| fastest = s.gyro.into_iter().map(f64::abs).fold(fastest, f64::max))?;
    // 2000 deg/s, the largest range of the usual sensors, is 34.9 rad/s.
    if fastest > 36.0 {
        return Ok(GyroUnit::DegPerSecond);
    }
    // Without gravity there is nothing to be turned back.
    let scattered = || {
        let is_out = |share| share < STAYS;
        Ok::<_, io::Error>(has_gravity(samples)? && stays_gravity(samples)?.is_some_and(is_out))
    };
    Ok(if quiet_gyro_noise(samples)?.is_some_and(|noise| noise > LOUD_GYRO) || scattered()? {
        GyroUnit::DegPerSecond
    } else {
        GyroUnit::RadPerSecond
    })
}

/// Whether the accelerometer's vector has a length of its own, in any unit: of an acceleration from which gravity was taken it is anything.
fn has_gravity(samples: &dyn Samples) -> io::Result<bool> {
    let mut lengths = Vec::new();
    thinned(samples, &mut |s| lengths.push(norm(s.accel)))?;
    let [low, middle, high] = [0.1, 0.5, 0.9].map(|share| stats::quantile(&lengths, share));
    Ok(high - low < middle)
}

/// Length of the mean of the accelerometer's vectors, turned back as the numbers say were they rad/s, in lengths of the vector: the median over
/// the stretches that turn; none where hardly any does.
fn stays_gravity(samples: &dyn Samples) -> io::Result<Option<f64>> {
    let count = samples.len().min(LOOKED_AT);
    if count == 0 {
        return Ok(None);
    }
    let period = samples.at(count - 1)?.t.seconds_since(samples.at(0)?.t) / count as f64;
    let size = ((STRETCH_S / period.max(1e-6)) as usize).clamp(2, count.max(2));
    let mut shares = Vec::new();
    samples.pieces(0..count, size, &mut |stretch| {
        if stretch.len() < size {
            return Ok(());
        }
        let (mut start_from_body, mut turned) = (UnitQuaternion::identity(), 0.0);
        let (mut sum, mut length) = (Vector3::zeros(), 0.0);
        for pair in stretch.windows(2) {
            let accel = Vector3::from(pair[0].accel);
            sum += start_from_body * accel;
            length += accel.norm();
            // A hole is no turn.
            let turn = Vector3::from(pair[0].gyro) * pair[1].t.seconds_since(pair[0].t).min(4.0 * period);
            turned += turn.norm();
            start_from_body *= UnitQuaternion::from_scaled_axis(turn);
        }
        if turned > TURNS && length > 0.0 {
            shares.push(sum.norm() / length);
        }
        Ok(())
    })?;
    Ok((shares.len() >= 2).then(|| stats::median(&shares)))
}

/// Whether the triples read as gyroscope and accelerometer are more likely the other way round: gravity stands in the former and not in
/// the latter, which is shorter or, in degrees, whose length changes more.
pub(crate) fn swapped(samples: &dyn Samples) -> io::Result<bool> {
    let mut lengths = [Vec::new(), Vec::new()];
    thinned(samples, &mut |s| {
        for (lengths, v) in lengths.iter_mut().zip([s.gyro, s.accel]) {
            lengths.push(norm(v));
        }
    })?;
    if lengths[0].is_empty() {
        return Ok(false);
    }
    let [gyro, accel] = lengths.map(|lengths| [0.1, 0.5, 0.9].map(|share| stats::quantile(&lengths, share)));
    let spread = |[low, middle, high]: [f64; 3]| (high - low) / middle;
    let looks_so = accel[1] < gyro[1] || spread(gyro) < 0.3 * spread(accel);
    Ok(is_gravity(gyro[1]) && !is_gravity(accel[1]) && looks_so)
}

/// Whether a vector of this length is gravity in one of the usual units.
pub(crate) fn is_gravity(v: f64) -> bool {
    (9.3..10.3).contains(&v) || (0.95..1.05).contains(&v) || (950.0..1050.0).contains(&v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::time::Stamp;
    use rand_distr::{Distribution, StandardNormal};

    /// A level sensor with the ADIS16448's noise that swings about x by `swing` rad at .5 Hz, and 20 s at rest.
    fn samples(swing: f64) -> Vec<ImuSample> {
        let mut rng = Stream::new(6).named("guess").rng();
        let mut noise =
            |sigma: f64| sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng);
        (0..4000)
            .map(|i| {
                let t = f64::from(i) * 0.005;
                let w = std::f64::consts::PI;
                let (angle, rate) = (swing * (w * t).sin(), swing * w * (w * t).cos());
                ImuSample {
                    t: Stamp::from_ns(i64::from(i) * 5_000_000),
                    gyro: [rate + noise(0.0024), 0.03 + noise(0.0024), noise(0.0024)],
                    accel: [noise(0.03), 9.81 * angle.sin() + noise(0.03), 9.81 * angle.cos() + noise(0.03)],
                }
            })
            .collect()
    }

    fn scaled(mut samples: Vec<ImuSample>, gyro: f64, accel: f64) -> Vec<ImuSample> {
        for s in &mut samples {
            s.gyro = s.gyro.map(|v| v * gyro);
            s.accel = s.accel.map(|v| v * accel);
        }
        samples
    }

    #[test]
    fn the_gyroscopes_unit_is_told_swinging_slowly_fast_and_at_rest() {
        for swing in [0.0, 0.02, 0.2, 1.0] {
            let rad = samples(swing);
            let degrees = scaled(samples(swing), 180.0 / std::f64::consts::PI, 1.0 / 9.81);
            assert_eq!(gyro_unit(&rad.as_slice()).unwrap(), GyroUnit::RadPerSecond, "{swing}");
            assert_eq!(gyro_unit(&degrees.as_slice()).unwrap(), GyroUnit::DegPerSecond, "{swing}");
        }
    }

    #[test]
    fn without_gravity_a_gyroscope_that_turns_is_not_taken_for_one_in_degrees() {
        let mut without = samples(1.0);
        for s in &mut without {
            s.accel =
                std::array::from_fn(|axis| (0.37 * s.t.ns() as f64 * 1e-6 + axis as f64).sin() * s.gyro[0]);
        }
        assert_eq!(gyro_unit(&without.as_slice()).unwrap(), GyroUnit::RadPerSecond);
    }

    #[test]
    fn the_accelerometers_unit_is_that_of_its_gravity() {
        for (factor, unit) in [
            (1.0, AccelUnit::MetrePerSecond2),
            (1.0 / 9.80665, AccelUnit::StandardGravity),
            (1000.0 / 9.80665, AccelUnit::MilliGravity),
            (100.0, AccelUnit::CentimetrePerSecond2),
        ] {
            assert_eq!(accel_unit(&scaled(samples(0.2), 1.0, factor).as_slice()).unwrap(), unit);
        }
        assert_eq!(accel_unit(&[].as_slice()).unwrap(), AccelUnit::MetrePerSecond2);
    }

    #[test]
    fn gravity_in_the_gyroscopes_columns_means_that_they_are_swapped() {
        let sound = samples(0.2);
        let mut other = sound.clone();
        other.iter_mut().for_each(|s| std::mem::swap(&mut s.gyro, &mut s.accel));
        let swapped = |samples: &[ImuSample]| super::swapped(&samples).unwrap();
        assert!(!swapped(&sound) && swapped(&other) && !swapped(&[]));
    }

    #[test]
    fn a_slowly_sampled_gyroscope_that_swings_is_not_taken_for_one_in_degrees() {
        // Level, about the upright axis: the accelerometer feels nothing of it.
        let swings = |unit: f64| {
            let still = samples(0.0).into_iter().enumerate();
            let at_15_hz = still.map(|(i, s)| {
                let t_s = i as f64 / 15.0;
                let rate = 0.7 * (3.0 * std::f64::consts::PI * t_s).sin();
                let [x, y, z] = s.gyro;
                ImuSample {
                    t: Stamp::from_ns((t_s * 1e9) as i64),
                    gyro: [x * unit, y * unit, (z + rate) * unit],
                    ..s
                }
            });
            at_15_hz.collect::<Vec<_>>()
        };
        assert_eq!(gyro_unit(&swings(1.0).as_slice()).unwrap(), GyroUnit::RadPerSecond);
        // The axes that do not turn tell.
        let degrees = swings(180.0 / std::f64::consts::PI);
        assert_eq!(gyro_unit(&degrees.as_slice()).unwrap(), GyroUnit::DegPerSecond);
    }
}
