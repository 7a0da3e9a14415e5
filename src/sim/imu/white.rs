//! White noise whose deviation is known at every sample and axis.
//!
//! n = sigma(t, axis) w, w ~ N(0, 1), one random stream per sensor and axis: ("white", sensor, axis). The deviation is
//! the base times a factor that the flight's schedule moves by steps and ramps; it is known before a draw is made,
//! and the draws w do not depend on it.

use super::series::ImuSeries;
use crate::flight::Flight;
use dpn_core::noise::{AccelNoiseDensity, AccelSampleStd, GyroNoiseDensity, GyroSampleStd};
use dpn_core::random::Stream;
use dpn_core::{SampleRate, Sensor};
use rand::Rng;
use rand_distr::StandardNormal;
use serde::Serialize;

dpn_core::settings!(
    /// White noise of a simulated IMU.
    pub struct WhiteConfig {
        /// Scales all white noise, 0 to 1000; 0 switches it off. Default 1.
        pub scale: f64 = 1.0 => 0.0..=1000.0,
        /// Whether the deviation changes in time by the flight's schedule; else it is the base throughout. Default true.
        pub schedule: bool = true,
        /// Base deviation of an accelerometer sample \[m/s^2\], up to 1. Default .0283, the ADIS16448's data sheet at 200 Hz.
        pub accel_sample_std: AccelSampleStd = AccelNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200),
        /// Base deviation of a gyroscope sample \[rad/s\], up to 1. Default .0024, the ADIS16448's data sheet at 200 Hz.
        pub gyro_sample_std: GyroSampleStd = GyroNoiseDensity::EUROC.to_sample_std(SampleRate::HZ_200),
    }
);

impl WhiteConfig {
    fn base(&self, sensor: Sensor) -> f64 {
        self.scale
            * match sensor {
                Sensor::Accel => self.accel_sample_std.get(),
                Sensor::Gyro => self.gyro_sample_std.get(),
            }
    }
}

/// White noise of some axes, multiplied during a part of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SigmaEvent {
    /// Which sensor.
    pub sensor: Sensor,
    /// Which of its axes x, y, z.
    pub axes: [bool; 3],
    /// Begin and end, as fractions of the recording's length.
    pub span: (f64, f64),
    /// Factor at begin and at end, linear in between: equal for a step, different for a ramp.
    pub factor: (f64, f64),
}

const ALL: [bool; 3] = [true; 3];
const X: [bool; 3] = [true, false, false];
const Y: [bool; 3] = [false, true, false];
const Z: [bool; 3] = [false, false, true];

fn event(sensor: Sensor, axes: [bool; 3], begin: f64, end: f64, from: f64, to: f64) -> SigmaEvent {
    SigmaEvent { sensor, axes, span: (begin, end), factor: (from, to) }
}

/// How the white noise of `flight` changes in time. Factors of overlapping events multiply; elsewhere it is 1.
///
/// The largest factors, 7 and 6, bring the base to .2 m/s^2 and .0144 rad/s, the top of the paper's grids.
///
/// | flight | accelerometer | gyroscope |
/// |---|---|---|
/// | hall-slow, hover | base | base |
/// | hall-calm | step x3 | base |
/// | hall-fast | base | step x4 |
/// | hall-loops | ramp 1 to 5 to 1 | ramp 1 to 5 to 1 |
/// | hall-lines | two short steps x6 | ramp 1 to 3, held |
/// | room-slow | z alone x6 | x alone x5 |
/// | room-medium | ramp 1 to 7, back at once | step x2 |
/// | room-aggressive | stairs 2, 4, 7 | stairs 6, 3, 1.5 |
/// | room-spiral | x, y, z one after the other x4 | x, y, z one after the other x4 |
/// | room-wild | x ramps up while z ramps down | y steps x6 |
pub(crate) fn sigma_schedule(flight: Flight) -> Vec<SigmaEvent> {
    use Sensor::{Accel, Gyro};
    match flight {
        Flight::HallSlow | Flight::Hover => vec![],
        Flight::HallCalm => vec![event(Accel, ALL, 0.4, 0.7, 3.0, 3.0)],
        Flight::HallFast => vec![event(Gyro, ALL, 0.3, 0.6, 4.0, 4.0)],
        Flight::HallLoops => Sensor::ALL
            .into_iter()
            .flat_map(|s| [event(s, ALL, 0.2, 0.5, 1.0, 5.0), event(s, ALL, 0.5, 0.8, 5.0, 1.0)])
            .collect(),
        Flight::HallLines => vec![
            event(Accel, ALL, 0.3, 0.36, 6.0, 6.0),
            event(Accel, ALL, 0.7, 0.76, 6.0, 6.0),
            event(Gyro, ALL, 0.2, 0.5, 1.0, 3.0),
            event(Gyro, ALL, 0.5, 1.01, 3.0, 3.0),
        ],
        Flight::RoomSlow => vec![event(Accel, Z, 0.35, 0.65, 6.0, 6.0), event(Gyro, X, 0.5, 0.8, 5.0, 5.0)],
        Flight::RoomMedium => {
            vec![event(Accel, ALL, 0.25, 0.75, 1.0, 7.0), event(Gyro, ALL, 0.4, 0.6, 2.0, 2.0)]
        }
        Flight::RoomAggressive => vec![
            event(Accel, ALL, 0.2, 0.4, 2.0, 2.0),
            event(Accel, ALL, 0.4, 0.6, 4.0, 4.0),
            event(Accel, ALL, 0.6, 0.8, 7.0, 7.0),
            event(Gyro, ALL, 0.2, 0.4, 6.0, 6.0),
            event(Gyro, ALL, 0.4, 0.6, 3.0, 3.0),
            event(Gyro, ALL, 0.6, 0.8, 1.5, 1.5),
        ],
        Flight::RoomSpiral => Sensor::ALL
            .into_iter()
            .flat_map(|s| {
                [
                    event(s, X, 0.2, 0.4, 4.0, 4.0),
                    event(s, Y, 0.4, 0.6, 4.0, 4.0),
                    event(s, Z, 0.6, 0.8, 4.0, 4.0),
                ]
            })
            .collect(),
        Flight::RoomWild => vec![
            event(Accel, X, 0.15, 0.85, 1.0, 6.0),
            event(Accel, Z, 0.15, 0.85, 6.0, 1.0),
            event(Gyro, Y, 0.5, 0.7, 6.0, 6.0),
        ],
    }
}

/// White noise and the deviation each of its samples was drawn with.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct White {
    pub noise: ImuSeries,
    pub sigma: ImuSeries,
}

/// Draws `n` samples.
pub(crate) fn draw(config: &WhiteConfig, flight: Flight, n: usize, stream: &Stream) -> White {
    let mut sigma = ImuSeries::zeros(n);
    for sensor in Sensor::ALL {
        sigma.of_mut(sensor).fill([config.base(sensor); 3]);
    }
    let events = if config.schedule { sigma_schedule(flight) } else { vec![] };
    for event in &events {
        let ((begin, end), (from, to)) = (event.span, event.factor);
        for (i, values) in sigma.of_mut(event.sensor).iter_mut().enumerate() {
            let at = i as f64 / n as f64;
            if at >= begin && at < end {
                let factor = from + (to - from) * (at - begin) / (end - begin);
                for axis in (0..3).filter(|&a| event.axes[a]) {
                    values[axis] *= factor;
                }
            }
        }
    }
    let mut noise = ImuSeries::zeros(n);
    for sensor in Sensor::ALL {
        for axis in 0..3 {
            let mut rng = stream.named(sensor.name()).index(axis as u64).rng();
            for (value, sigma) in noise.of_mut(sensor).iter_mut().zip(sigma.of(sensor)) {
                let draw: f64 = rng.sample(StandardNormal);
                value[axis] = sigma[axis] * draw;
            }
        }
    }
    White { noise, sigma }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sampled_deviation_is_the_stated_one_on_every_axis_and_stretch() {
        let n = 24_000;
        for flight in Flight::ALL {
            let white = draw(&WhiteConfig::default(), flight, n, &Stream::new(11).named(flight.name()));
            for sensor in Sensor::ALL {
                for axis in 0..3 {
                    for stretch in 0..10 {
                        let range = stretch * n / 10..(stretch + 1) * n / 10;
                        let chi2: f64 = range
                            .clone()
                            .map(|i| {
                                (white.noise.of(sensor)[i][axis] / white.sigma.of(sensor)[i][axis]).powi(2)
                            })
                            .sum();
                        // A chi-square of m degrees is m +- sqrt(2 m): four standard errors.
                        let m = range.len() as f64;
                        assert!((chi2 - m).abs() < 4.0 * (2.0 * m).sqrt(), "{flight} {sensor} {axis} {chi2}");
                    }
                }
            }
        }
    }

    #[test]
    fn noise_is_white_and_axes_are_independent() {
        let n = 40_000;
        let config = WhiteConfig { schedule: false, ..WhiteConfig::default() };
        let white = draw(&config, Flight::Hover, n, &Stream::new(2));
        let unit = |sensor, axis| -> Vec<f64> {
            let scale = config.base(sensor);
            white.noise.axis(sensor, axis).iter().map(|v| v / scale).collect()
        };
        let x = unit(Sensor::Accel, 0);
        // Correlations of independent unit variables have a standard error of 1 / sqrt(n); four of them.
        let bound = 4.0 / (n as f64).sqrt();
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(u, v)| u * v).sum::<f64>() / a.len() as f64;
        for lag in 1..=5 {
            assert!(mean(&x[lag..], &x[..n - lag]).abs() < bound);
        }
        for other in [unit(Sensor::Accel, 1), unit(Sensor::Gyro, 0), unit(Sensor::Gyro, 2)] {
            assert!(mean(&x, &other).abs() < bound);
        }
    }

    #[test]
    fn the_schedule_moves_the_deviation_and_not_the_draws() {
        let with = draw(&WhiteConfig::default(), Flight::RoomSlow, 1000, &Stream::new(4));
        let without = WhiteConfig { schedule: false, ..WhiteConfig::default() };
        let without = draw(&without, Flight::RoomSlow, 1000, &Stream::new(4));
        assert_eq!(with.noise.accel[..350], without.noise.accel[..350]);
        for i in 350..650 {
            assert!((with.sigma.accel[i][2] / without.sigma.accel[i][2] - 6.0).abs() < 1e-12);
            assert!((with.noise.accel[i][2] / without.noise.accel[i][2] - 6.0).abs() < 1e-9);
            assert_eq!(with.noise.accel[i][0], without.noise.accel[i][0]);
        }
    }
}
