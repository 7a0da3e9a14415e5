//! What is known of an IMU's noise, as densities: the form that everything is converted through.

use super::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
use crate::imu::Sensor;
use crate::time::SampleRate;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The four figures every configuration asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// White noise of the accelerometer.
    AccelWhite,
    /// White noise of the gyroscope.
    GyroWhite,
    /// Walk of the accelerometer's bias.
    AccelWalk,
    /// Walk of the gyroscope's bias.
    GyroWalk,
}

impl Figure {
    /// All four, in the order in which they are written.
    pub const ALL: [Self; 4] = [Self::AccelWhite, Self::AccelWalk, Self::GyroWhite, Self::GyroWalk];

    /// The white noise of a sensor.
    pub fn white(sensor: Sensor) -> Self {
        match sensor {
            Sensor::Accel => Self::AccelWhite,
            Sensor::Gyro => Self::GyroWhite,
        }
    }

    /// Whose noise it is.
    pub fn sensor(self) -> Sensor {
        match self {
            Self::AccelWhite | Self::AccelWalk => Sensor::Accel,
            Self::GyroWhite | Self::GyroWalk => Sensor::Gyro,
        }
    }

    /// Whether it is the walk of a bias.
    pub fn is_walk(self) -> bool {
        matches!(self, Self::AccelWalk | Self::GyroWalk)
    }

    /// Unit of its density.
    pub fn unit(self) -> &'static str {
        match self {
            Self::AccelWhite => "m/s^2/sqrt(Hz)",
            Self::GyroWhite => "rad/s/sqrt(Hz)",
            Self::AccelWalk => "m/s^3/sqrt(Hz)",
            Self::GyroWalk => "rad/s^2/sqrt(Hz)",
        }
    }

    /// The flag that gives it on the command line, without dashes.
    pub fn flag(self) -> &'static str {
        match self {
            Self::AccelWhite => "accel-noise",
            Self::GyroWhite => "gyro-noise",
            Self::AccelWalk => "accel-walk",
            Self::GyroWalk => "gyro-walk",
        }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AccelWhite => "accelerometer noise",
            Self::GyroWhite => "gyroscope noise",
            Self::AccelWalk => "accelerometer bias walk",
            Self::GyroWalk => "gyroscope bias walk",
        })
    }
}

/// One value for all axes, or one an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Axes<T> {
    /// The same on x, y, z.
    Same(T),
    /// x, y, z.
    Each([T; 3]),
}

impl<T: Copy> Axes<T> {
    /// The same with `f` applied to every value.
    pub(crate) fn map<U>(self, mut f: impl FnMut(T) -> U) -> Axes<U> {
        match self {
            Self::Same(value) => Axes::Same(f(value)),
            Self::Each(values) => Axes::Each(values.map(f)),
        }
    }

    /// The same with `f` applied to every value, or the first failure.
    ///
    /// # Errors
    /// Those of `f`.
    pub fn try_map<U: Copy, E>(self, mut f: impl FnMut(T) -> Result<U, E>) -> Result<Axes<U>, E> {
        Ok(match self {
            Self::Same(value) => Axes::Same(f(value)?),
            Self::Each([x, y, z]) => Axes::Each([f(x)?, f(y)?, f(z)?]),
        })
    }

    /// x, y, z.
    pub fn each(self) -> [T; 3] {
        match self {
            Self::Same(value) => [value; 3],
            Self::Each(values) => values,
        }
    }
}

impl<T: Copy + PartialOrd> Axes<T> {
    /// The largest of the three.
    pub fn largest(self) -> T {
        self.each().into_iter().reduce(|a, b| if b > a { b } else { a }).expect("there are three axes")
    }
}

/// White noise and bias walk of both sensors as densities, each where known, and the IMU's rate.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ImuFigures {
    /// Samples a second \[Hz\].
    pub rate: Option<SampleRate>,
    /// Accelerometer's white noise \[m/s^2/sqrt(Hz)\].
    pub accel_white: Option<Axes<AccelNoiseDensity>>,
    /// Walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\].
    pub accel_walk: Option<Axes<AccelBiasWalkDensity>>,
    /// Gyroscope's white noise \[rad/s/sqrt(Hz)\].
    pub gyro_white: Option<Axes<GyroNoiseDensity>>,
    /// Walk of the gyroscope's bias \[rad/s^2/sqrt(Hz)\].
    pub gyro_walk: Option<Axes<GyroBiasWalkDensity>>,
}

impl ImuFigures {
    /// EuRoC's `sensor.yaml`: an ADIS16448 at 200 Hz.
    pub fn euroc() -> Self {
        Self {
            rate: Some(SampleRate::HZ_200),
            accel_white: Some(Axes::Same(AccelNoiseDensity::EUROC)),
            accel_walk: Some(Axes::Same(AccelBiasWalkDensity::EUROC)),
            gyro_white: Some(Axes::Same(GyroNoiseDensity::EUROC)),
            gyro_walk: Some(Axes::Same(GyroBiasWalkDensity::EUROC)),
        }
    }

    /// The density of `figure` as numbers in [`Figure::unit`], where known.
    pub fn density(&self, figure: Figure) -> Option<Axes<f64>> {
        match figure {
            Figure::AccelWhite => self.accel_white.map(|a| a.map(f64::from)),
            Figure::AccelWalk => self.accel_walk.map(|a| a.map(f64::from)),
            Figure::GyroWhite => self.gyro_white.map(|a| a.map(f64::from)),
            Figure::GyroWalk => self.gyro_walk.map(|a| a.map(f64::from)),
        }
    }
}
