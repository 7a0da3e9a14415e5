//! The five kinds of noise that an Allan plot tells apart, after IEEE Std 952-1997, annex C.
//!
//! sigma^2(tau) = 3 Q^2 / tau^2 + N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3 + R^2 tau^2 / 2
//!
//! The model is linear in the squares of the coefficients; it is those that are fitted.

use dpn_core::{Sensor, named};
use serde::Serialize;
use std::f64::consts::{LN_2, PI};

named!(
    /// One of the five coefficients, by the slope they have.
    #[derive(PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Coefficient {
        /// Q: white noise of the integrated signal, slope -1.
        Quantisation = "quantisation",
        /// N: white noise, slope -1/2; angle and velocity random walk.
        White = "white noise",
        /// B: flicker noise, flat; the floor of the plot is .664 B.
        Instability = "bias instability",
        /// K: the walk of the bias, slope 1/2.
        Walk = "bias walk",
        /// R: a steady drift, slope 1.
        Ramp = "ramp",
    }
);

impl Coefficient {
    /// Allan variance at `tau` \[s\] of a coefficient of one.
    pub fn variance(self, tau: f64) -> f64 {
        match self {
            Self::Quantisation => 3.0 / (tau * tau),
            Self::White => 1.0 / tau,
            Self::Instability => 2.0 * LN_2 / PI,
            Self::Walk => tau / 3.0,
            Self::Ramp => tau * tau / 2.0,
        }
    }

    /// Its unit for a sensor.
    pub fn unit(self, sensor: Sensor) -> &'static str {
        match (self, sensor) {
            (Self::Quantisation, Sensor::Gyro) => "rad",
            (Self::Quantisation, Sensor::Accel) => "m/s",
            (Self::White, Sensor::Gyro) => "rad/s/sqrt(Hz)",
            (Self::White, Sensor::Accel) => "m/s^2/sqrt(Hz)",
            (Self::Instability, Sensor::Gyro) => "rad/s",
            (Self::Instability, Sensor::Accel) => "m/s^2",
            (Self::Walk, Sensor::Gyro) => "rad/s^2/sqrt(Hz)",
            (Self::Walk, Sensor::Accel) => "m/s^3/sqrt(Hz)",
            (Self::Ramp, Sensor::Gyro) => "rad/s^2",
            (Self::Ramp, Sensor::Accel) => "m/s^3",
        }
    }

    /// Its letter in the formula.
    pub fn letter(self) -> &'static str {
        match self {
            Self::Quantisation => "Q",
            Self::White => "N",
            Self::Instability => "B",
            Self::Walk => "K",
            Self::Ramp => "R",
        }
    }
}

/// The squares of the five coefficients, in the order of [`Coefficient::ALL`].
pub type Squares = [f64; 5];

/// The model's Allan variance at `tau` \[s\].
pub fn variance(squares: &Squares, tau: f64) -> f64 {
    Coefficient::ALL.iter().zip(squares).map(|(c, s)| s * c.variance(tau)).sum()
}
