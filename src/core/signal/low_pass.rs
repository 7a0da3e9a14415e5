//! What a sensor's low pass makes of white noise: the kinds that IMUs and their drivers have.

use crate::time::SampleRate;
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt;

/// How a filter of continuous time was made one of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Made {
    /// It was not: it lies before the sampling, or runs at a much higher rate.
    Analog,
    /// By the bilinear transform, at the log's rate.
    Bilinear,
    /// As exponential smoothing, `y += a (x - y)`, at the log's rate.
    Exponential,
}

/// A low pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum LowPass {
    /// None, or one above half the rate.
    None,
    /// One pole.
    FirstOrder {
        /// How it was made.
        made: Made,
    },
    /// Two poles of a quality near Butterworth's.
    SecondOrder {
        /// How it was made.
        made: Made,
    },
    /// A moving mean of neighbouring samples.
    MovingMean {
        /// Of so many.
        samples: usize,
    },
}

impl LowPass {
    /// All that are tried, with how much is bet on each before a log is seen.
    pub fn candidates() -> Vec<(Self, f64)> {
        let mut all = vec![(Self::None, 0.4)];
        for made in [Made::Analog, Made::Bilinear, Made::Exponential] {
            all.push((Self::FirstOrder { made }, 0.07));
        }
        for made in [Made::Analog, Made::Bilinear] {
            all.push((Self::SecondOrder { made }, 0.15));
        }
        all.extend((2..=8).map(|samples| (Self::MovingMean { samples }, 0.1 / 7.0)));
        all
    }

    /// Poles, 0 of what has none. It has as many parameters: the corner, and for two poles the quality.
    pub fn order(self) -> usize {
        match self {
            Self::None | Self::MovingMean { .. } => 0,
            Self::FirstOrder { .. } => 1,
            Self::SecondOrder { .. } => 2,
        }
    }

    /// The highest corner that a log of this rate shows anything of \[Hz\].
    pub fn highest_corner(self, rate: SampleRate) -> f64 {
        let bilinear = matches!(
            self,
            Self::FirstOrder { made: Made::Bilinear } | Self::SecondOrder { made: Made::Bilinear }
        );
        rate.hz() * if bilinear { 0.47 } else { 3.0 }
    }

    /// Share of the power that passes at `hz`, for a corner \[Hz\] and a quality.
    pub fn gain(self, hz: f64, rate: SampleRate, corner: f64, quality: f64) -> f64 {
        let (w, wc) = (PI * hz / rate.hz(), PI * corner / rate.hz());
        let over = |made: Made| match made {
            Made::Bilinear => w.tan() / wc.min(0.49 * PI).tan(),
            Made::Analog | Made::Exponential => hz / corner,
        };
        match self {
            Self::None => 1.0,
            Self::FirstOrder { made: Made::Exponential } => {
                let kept = (-2.0 * wc).exp();
                (1.0 - kept).powi(2) / (1.0 - 2.0 * kept * (2.0 * w).cos() + kept * kept)
            }
            Self::FirstOrder { made } => 1.0 / (1.0 + over(made).powi(2)),
            Self::SecondOrder { made } => {
                let u = over(made);
                1.0 / ((1.0 - u * u).powi(2) + (u / quality).powi(2))
            }
            Self::MovingMean { samples } => {
                let m = samples as f64;
                ((m * w).sin() / (m * w.sin())).powi(2)
            }
        }
    }
}

impl fmt::Display for LowPass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::FirstOrder { .. } => f.write_str("1st order"),
            Self::SecondOrder { .. } => f.write_str("2nd order"),
            Self::MovingMean { samples } => write!(f, "mean of {samples} samples"),
        }
    }
}
