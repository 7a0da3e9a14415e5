//! A whole log: where it is at rest, six Allan plots, and the figures an estimator asks for.

use super::bridge::bridged;
use super::deviation;
use super::fit::{Estimate, Fit, Planner};
use super::model::Coefficient;
use super::nnls::NnlsError;
use super::rest::{Rest, rest};
use crate::phases::phases;
use crate::rest_noise::RestNoise;
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
use dpn_core::noise::{Axes, ImuFigures, Interval};
use dpn_core::{ImuRecording, SampleRate, Sensor};
use rayon::prelude::*;
use serde::Serialize;

/// The shortest stretch at rest that is looked at \[s\].
pub const LEAST_S: f64 = 10.0;

/// Why a log has no Allan plot.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AllanError {
    /// Nothing to work with between the seconds that moved and the holes.
    #[error(
        "the log is not at rest: {moved_s:.0} of {length_s:.0} s moved, first at {first_s:.0} s; the longest stretch at rest has {longest_s:.1} s, and {LEAST_S:.0} s are needed"
    )]
    NotAtRest {
        /// Seconds that moved.
        moved_s: f64,
        /// Length of the log \[s\].
        length_s: f64,
        /// When it first moved \[s\].
        first_s: f64,
        /// Its longest stretch at rest \[s\].
        longest_s: f64,
    },
    /// A log that is too short for anything.
    #[error(
        "the log has {length_s:.1} s without a hole; an Allan plot needs {LEAST_S:.0} s, one with a bias walk hours"
    )]
    TooShort {
        /// Length of its longest part without a hole \[s\].
        length_s: f64,
    },
    /// An axis that never changes.
    #[error("{sensor} {} reads {value} throughout; a live sensor is never without noise", ["x", "y", "z"][*axis])]
    Constant {
        /// The sensor.
        sensor: Sensor,
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Its only value.
        value: f64,
    },
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] NnlsError),
    /// A fitted value that no noise has.
    #[error(transparent)]
    Value(#[from] BadNoise),
}

impl AllanError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NotAtRest { .. } => Some(
                "record with the motors off on a heavy table; or add --all to take moving parts for noise too, or ask `dpn noise`".into(),
            ),
            Self::TooShort { .. } => Some("record for longer: minutes for white noise, hours for the bias".into()),
            Self::Constant { .. } => Some("look at the wiring or the column".into()),
            Self::Fit(_) | Self::Value(_) => {
                Some("no sensor's noise looks like this log's: look at its values and units with `dpn check`".into())
            }
        }
    }
}

/// One axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisFit {
    /// The sensor.
    pub sensor: Sensor,
    /// `x`, `y` or `z`.
    pub axis: &'static str,
    /// Its plot and coefficients.
    #[serde(flatten)]
    pub fit: Fit,
}

/// A log at rest and what it says of the sensor's noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AllanLog {
    /// Samples a second \[Hz\].
    pub rate: SampleRate,
    /// Samples used.
    pub samples: usize,
    /// Their length \[s\].
    pub length_s: f64,
    /// When the log moved.
    pub rest: Rest,
    /// Whether moving parts were used too.
    pub everything: bool,
    /// Single lost samples for which straight lines stand, of the whole log.
    pub bridged: usize,
    /// Accelerometer x, y, z, gyroscope x, y, z.
    pub axes: Vec<AxisFit>,
    /// The same rest by its whole spectrum: what stands between the noise and the log; none with `everything`, which is no rest.
    pub spectrum: Option<RestNoise>,
}

impl AllanLog {
    /// Looks at `recording`: its longest stretch at rest, or with `everything` all of it.
    ///
    /// # Errors
    /// See [`AllanError`].
    pub fn of(recording: &ImuRecording, everything: bool) -> Result<Self, AllanError> {
        let bridged = bridged(recording);
        let (recording, bridged) = bridged.as_ref().map_or((recording, 0), |(whole, count)| (whole, *count));
        let rest = rest(recording).expect("a recording lies in memory");
        let rate = recording.rate();
        let used = if everything { 0..recording.len() } else { rest.longest.clone() };
        let length_s = used.len() as f64 * rate.period();
        if length_s < LEAST_S || deviation::averages(used.len()).len() < 8 {
            return Err(match rest.moved.first() {
                Some(first) if !everything => AllanError::NotAtRest {
                    moved_s: rest.moved_s,
                    length_s: recording.duration(),
                    first_s: first.from_s,
                    longest_s: length_s,
                },
                _ => AllanError::TooShort { length_s },
            });
        }
        let planner = Planner::new(used.len(), rate);
        let all: Vec<(Sensor, usize)> =
            Sensor::ALL.into_iter().flat_map(|s| (0..3).map(move |axis| (s, axis))).collect();
        let axes = all
            .into_par_iter()
            .map(|(sensor, axis)| {
                let signal: Vec<f64> =
                    recording.samples()[used.clone()].iter().map(|s| s.of(sensor)[axis]).collect();
                if signal.iter().all(|v| *v == signal[0]) {
                    return Err(AllanError::Constant { sensor, axis, value: signal[0] });
                }
                Ok(AxisFit { sensor, axis: ["x", "y", "z"][axis], fit: planner.fit(&signal)? })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let spectrum = match everything {
            true => None,
            false => {
                let stretches = phases(recording).expect("a recording lies in memory");
                RestNoise::of(recording, &stretches).expect("a recording lies in memory")
            }
        };
        let log = Self { rate, samples: used.len(), length_s, rest, everything, bridged, axes, spectrum };
        log.checked_figures()?;
        Ok(log)
    }

    /// One coefficient of the three axes of a sensor.
    pub fn estimates(&self, sensor: Sensor, coefficient: Coefficient) -> [Estimate; 3] {
        let mut of = self.axes.iter().filter(|a| a.sensor == sensor).map(|a| a.fit.of(coefficient));
        std::array::from_fn(|_| of.next().expect("a log is fitted on three axes of either sensor"))
    }

    /// Whether `coefficient` is seen on all three axes.
    pub fn seen(&self, sensor: Sensor, coefficient: Coefficient) -> bool {
        self.estimates(sensor, coefficient).iter().all(|e| e.seen)
    }

    /// Densities of a sensor's white noise by the spectrum of the rest, where something stands between noise and log: averages over a time that a low pass, held values
    /// or rounding reach are not the noise's. Where nothing does and the fit says otherwise, the spectrum's too: it leaves lines out.
    pub fn behind(&self, sensor: Sensor) -> Option<[Interval; 3]> {
        let found = self.spectrum.as_ref()?.sensor(sensor);
        let densities = found.densities()?;
        let fitted = self.estimates(sensor, Coefficient::White);
        let agree = fitted.iter().zip(&densities).all(|(fit, d)| fit.low < d.high && d.low < fit.high);
        (found.is_shaped() || !agree).then_some(densities)
    }

    /// White noise and bias walks as densities: white noise by the spectrum [where something is in its way](Self::behind). Where a walk is not seen, what it stays below
    /// stands for it.
    pub fn figures(&self) -> ImuFigures {
        self.checked_figures().expect("checked when the log was fitted")
    }

    fn checked_figures(&self) -> Result<ImuFigures, BadNoise> {
        let value = |e: Estimate| if e.seen { e.value } else { e.high };
        let axes =
            |sensor, coefficient| match self.behind(sensor).filter(|_| coefficient == Coefficient::White) {
                Some(densities) => Axes::Each(densities.map(|density| density.value)),
                None => Axes::Each(self.estimates(sensor, coefficient).map(value)),
            };
        Ok(ImuFigures {
            rate: Some(self.rate),
            accel_white: Some(axes(Sensor::Accel, Coefficient::White).try_map(AccelNoiseDensity::new)?),
            accel_walk: Some(axes(Sensor::Accel, Coefficient::Walk).try_map(AccelBiasWalkDensity::new)?),
            gyro_white: Some(axes(Sensor::Gyro, Coefficient::White).try_map(GyroNoiseDensity::new)?),
            gyro_walk: Some(axes(Sensor::Gyro, Coefficient::Walk).try_map(GyroBiasWalkDensity::new)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::{ImuSample, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;

    /// A minute at 200 Hz, white noise of .05 m/s^2 and .004 rad/s a sample, the accelerometer's behind a pole.
    fn log(pole: f64) -> ImuRecording {
        let mut rng = Stream::new(8).named("allan-low-pass").rng();
        let mut held = [0.0; 3];
        let samples = (0..12_000).map(|i| {
            let mut white = || [0; 3].map(|_| rng.sample::<f64, _>(StandardNormal));
            for (held, now) in held.iter_mut().zip(white()) {
                *held += (1.0 - pole) * (0.05 * now - *held);
            }
            ImuSample { t: Stamp::from_ns(5_000_000 * i), gyro: white().map(|v| 0.004 * v), accel: held }
        });
        ImuRecording::new(samples.collect()).unwrap()
    }

    #[test]
    fn behind_a_low_pass_the_figure_is_the_spectrums_and_the_low_pass_is_named() {
        let truth = 0.05 / 200f64.sqrt();
        let allan = AllanLog::of(&log(0.5), false).unwrap();
        let Some(Axes::Each(white)) = allan.figures().accel_white else { panic!("three axes were fitted") };
        for (density, white) in allan.behind(Sensor::Accel).unwrap().iter().zip(white) {
            assert_eq!(density.value, white.get());
            assert!((white.get() / truth - 1.0).abs() < 0.08, "{density:?}");
        }
        let between = allan.spectrum.as_ref().unwrap().between();
        assert!(
            between.len() == 1 && between[0].contains("accel: behind a low pass, 1st order"),
            "{between:?}"
        );
        assert_eq!(allan.behind(Sensor::Gyro), None);
        // Without one the two agree.
        let allan = AllanLog::of(&log(0.0), false).unwrap();
        assert_eq!(allan.behind(Sensor::Accel), None);
        let spectrum = allan.spectrum.as_ref().unwrap().sensor(Sensor::Accel).densities().unwrap();
        for (fit, density) in allan.estimates(Sensor::Accel, Coefficient::White).iter().zip(spectrum) {
            assert!(fit.low < density.high && density.low < fit.high, "{fit:?} {density:?}");
        }
    }
}
