//! What a number in a configuration means, and the way from it to a density and back.

use super::units::{
    AccelBiasRateStd, AccelBiasStepStd, AccelBiasStepVariance, AccelBiasWalkDensity, AccelNoiseDensity,
    AccelPowerDensity, AccelSampleStd, AccelSampleVariance, BadNoise, GyroBiasRateStd, GyroBiasStepStd,
    GyroBiasStepVariance, GyroBiasWalkDensity, GyroNoiseDensity, GyroPowerDensity, GyroSampleStd,
    GyroSampleVariance,
};
use super::{Axes, Figure, ImuFigures};
use crate::time::SampleRate;

/// What a number means. The first four are white noise, the others the walk of a bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meaning {
    /// Density of white noise, for example \[rad/s/sqrt(Hz)\].
    Density,
    /// Its square, for example \[(rad/s)^2/Hz\].
    Power,
    /// Standard deviation of one sample, for example \[rad/s\].
    SampleStd,
    /// Variance of one sample, for example \[(rad/s)^2\].
    SampleVariance,
    /// Density of a walk, for example \[rad/s^2/sqrt(Hz)\].
    WalkDensity,
    /// Deviation of the bias's increment from sample to sample, for example \[rad/s\].
    WalkStepStd,
    /// Its square, for example \[(rad/s)^2\].
    WalkStepVariance,
    /// Deviation of the bias's rate of change, one value a sample, for example \[rad/s^2\].
    WalkRateStd,
}

impl Meaning {
    /// Whether it is the walk of a bias.
    pub fn is_walk(self) -> bool {
        matches!(self, Self::WalkDensity | Self::WalkStepStd | Self::WalkStepVariance | Self::WalkRateStd)
    }

    /// Whether the number is only meant together with a rate.
    pub fn needs_rate(self) -> bool {
        !matches!(self, Self::Density | Self::Power | Self::WalkDensity)
    }

    /// Unit of the number for `figure`'s sensor.
    pub fn unit(self, figure: Figure) -> &'static str {
        let accel = matches!(figure, Figure::AccelWhite | Figure::AccelWalk);
        match (self, accel) {
            (Self::Density, true) => "m/s^2/sqrt(Hz)",
            (Self::Density, false) => "rad/s/sqrt(Hz)",
            (Self::Power, true) => "(m/s^2)^2/Hz",
            (Self::Power, false) => "(rad/s)^2/Hz",
            (Self::SampleStd | Self::WalkStepStd, true) => "m/s^2",
            (Self::SampleStd | Self::WalkStepStd, false) => "rad/s",
            (Self::SampleVariance | Self::WalkStepVariance, true) => "(m/s^2)^2",
            (Self::SampleVariance | Self::WalkStepVariance, false) => "(rad/s)^2",
            (Self::WalkDensity, true) => "m/s^3/sqrt(Hz)",
            (Self::WalkDensity, false) => "rad/s^2/sqrt(Hz)",
            (Self::WalkRateStd, true) => "m/s^3",
            (Self::WalkRateStd, false) => "rad/s^2",
        }
    }

    /// What it is, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Density | Self::WalkDensity => "density",
            Self::Power => "power density",
            Self::SampleStd => "deviation of one sample",
            Self::SampleVariance => "variance of one sample",
            Self::WalkStepStd => "deviation of the bias's step from sample to sample",
            Self::WalkStepVariance => "variance of the bias's step from sample to sample",
            Self::WalkRateStd => "deviation of the bias's rate of change, one value a sample",
        }
    }

    /// What is done to `number` to get a density, as it is written out: `/ sqrt(200)`; empty where nothing is.
    pub fn to_density_words(self, number: &str, rate: &str) -> String {
        match self {
            Self::Density | Self::WalkDensity => number.to_owned(),
            Self::Power => format!("sqrt({number})"),
            Self::SampleStd | Self::WalkRateStd => format!("{number} / sqrt({rate})"),
            Self::SampleVariance => format!("sqrt({number}) / sqrt({rate})"),
            Self::WalkStepStd => format!("{number} * sqrt({rate})"),
            Self::WalkStepVariance => format!("sqrt({number}) * sqrt({rate})"),
        }
    }

    /// What is done to a density to get this, as it is written out.
    pub fn of_density_words(self, number: &str, rate: &str) -> String {
        match self {
            Self::Density | Self::WalkDensity => number.to_owned(),
            Self::Power => format!("{number}^2"),
            Self::SampleStd | Self::WalkRateStd => format!("{number} * sqrt({rate})"),
            Self::SampleVariance => format!("({number} * sqrt({rate}))^2"),
            Self::WalkStepStd => format!("{number} / sqrt({rate})"),
            Self::WalkStepVariance => format!("({number} / sqrt({rate}))^2"),
        }
    }
}

macro_rules! white {
    ($read:ident, $write:ident, $density:ident, $power:ident, $std:ident, $variance:ident) => {
        fn $read(meaning: Meaning, value: f64, rate: SampleRate) -> Result<$density, BadNoise> {
            match meaning {
                Meaning::Power => Ok($power::new(value)?.to_density()),
                Meaning::SampleStd => Ok($std::new(value)?.to_density(rate)),
                Meaning::SampleVariance => Ok($variance::new(value)?.to_sample_std().to_density(rate)),
                _ => $density::new(value),
            }
        }

        fn $write(meaning: Meaning, density: $density, rate: SampleRate) -> f64 {
            match meaning {
                Meaning::Power => density.to_power().get(),
                Meaning::SampleStd => density.to_sample_std(rate).get(),
                Meaning::SampleVariance => density.to_sample_std(rate).to_variance().get(),
                _ => density.get(),
            }
        }
    };
}

macro_rules! walk {
    ($read:ident, $write:ident, $density:ident, $step:ident, $variance:ident, $rate_std:ident) => {
        fn $read(meaning: Meaning, value: f64, rate: SampleRate) -> Result<$density, BadNoise> {
            match meaning {
                Meaning::WalkStepStd => Ok($step::new(value)?.to_density(rate)),
                Meaning::WalkStepVariance => Ok($variance::new(value)?.to_step_std().to_density(rate)),
                Meaning::WalkRateStd => Ok($rate_std::new(value)?.to_density(rate)),
                _ => $density::new(value),
            }
        }

        fn $write(meaning: Meaning, density: $density, rate: SampleRate) -> f64 {
            match meaning {
                Meaning::WalkStepStd => density.to_step_std(rate).get(),
                Meaning::WalkStepVariance => density.to_step_std(rate).to_variance().get(),
                Meaning::WalkRateStd => density.to_rate_std(rate).get(),
                _ => density.get(),
            }
        }
    };
}

white!(read_accel, write_accel, AccelNoiseDensity, AccelPowerDensity, AccelSampleStd, AccelSampleVariance);
white!(read_gyro, write_gyro, GyroNoiseDensity, GyroPowerDensity, GyroSampleStd, GyroSampleVariance);
walk!(
    read_accel_walk,
    write_accel_walk,
    AccelBiasWalkDensity,
    AccelBiasStepStd,
    AccelBiasStepVariance,
    AccelBiasRateStd
);
walk!(
    read_gyro_walk,
    write_gyro_walk,
    GyroBiasWalkDensity,
    GyroBiasStepStd,
    GyroBiasStepVariance,
    GyroBiasRateStd
);

impl ImuFigures {
    /// Takes the numbers of one figure, meant as `meaning` at `rate` (which densities do not ask for).
    ///
    /// # Errors
    /// A number that is negative or not finite.
    pub fn set(
        &mut self,
        figure: Figure,
        meaning: Meaning,
        values: Axes<f64>,
        rate: SampleRate,
    ) -> Result<(), BadNoise> {
        match figure {
            Figure::AccelWhite => self.accel_white = Some(values.try_map(|v| read_accel(meaning, v, rate))?),
            Figure::GyroWhite => self.gyro_white = Some(values.try_map(|v| read_gyro(meaning, v, rate))?),
            Figure::AccelWalk => {
                self.accel_walk = Some(values.try_map(|v| read_accel_walk(meaning, v, rate))?);
            }
            Figure::GyroWalk => self.gyro_walk = Some(values.try_map(|v| read_gyro_walk(meaning, v, rate))?),
        }
        Ok(())
    }

    /// The numbers of one figure as `meaning` at `rate`, where known.
    pub fn get(&self, figure: Figure, meaning: Meaning, rate: SampleRate) -> Option<Axes<f64>> {
        match figure {
            Figure::AccelWhite => self.accel_white.map(|a| a.map(|v| write_accel(meaning, v, rate))),
            Figure::GyroWhite => self.gyro_white.map(|a| a.map(|v| write_gyro(meaning, v, rate))),
            Figure::AccelWalk => self.accel_walk.map(|a| a.map(|v| write_accel_walk(meaning, v, rate))),
            Figure::GyroWalk => self.gyro_walk.map(|a| a.map(|v| write_gyro_walk(meaning, v, rate))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHITE: [Meaning; 4] =
        [Meaning::Density, Meaning::Power, Meaning::SampleStd, Meaning::SampleVariance];
    const WALK: [Meaning; 4] =
        [Meaning::WalkDensity, Meaning::WalkStepStd, Meaning::WalkStepVariance, Meaning::WalkRateStd];

    #[test]
    fn a_hundredth_per_sample_at_a_hundred_hertz_is_known_in_every_meaning() {
        let rate = SampleRate::from_hz(100.0).unwrap();
        let mut figures = ImuFigures::default();
        let values = |figures: &ImuFigures, figure, meanings: [Meaning; 4]| {
            meanings.map(|m| figures.get(figure, m, rate).unwrap().largest())
        };
        let near = |got: [f64; 4], wanted: [f64; 4]| {
            assert!(got.iter().zip(wanted).all(|(g, w)| (g / w - 1.0).abs() < 1e-12), "{got:?} {wanted:?}");
        };
        for figure in [Figure::AccelWhite, Figure::GyroWhite] {
            figures.set(figure, Meaning::SampleStd, Axes::Same(0.01), rate).unwrap();
            near(values(&figures, figure, WHITE), [1e-3, 1e-6, 1e-2, 1e-4]);
        }
        for figure in [Figure::AccelWalk, Figure::GyroWalk] {
            figures.set(figure, Meaning::WalkStepStd, Axes::Same(0.01), rate).unwrap();
            near(values(&figures, figure, WALK), [0.1, 1e-2, 1e-4, 1.0]);
        }
    }

    proptest! {
        #[test]
        fn every_meaning_there_and_back_is_the_same(log in -9.0..2.0f64, hz in 1.0..5000.0f64, pick in 0usize..4) {
            let (value, rate) = (10f64.powf(log), SampleRate::from_hz(hz).unwrap());
            for figure in Figure::ALL {
                let meaning = if figure.is_walk() { WALK[pick] } else { WHITE[pick] };
                let mut figures = ImuFigures::default();
                figures.set(figure, meaning, Axes::Each([value, 2.0 * value, 3.0 * value]), rate).unwrap();
                let back = figures.get(figure, meaning, rate).unwrap().each();
                for (k, v) in [1.0, 2.0, 3.0].into_iter().zip(back) {
                    prop_assert!((v / (k * value) - 1.0).abs() < 1e-13);
                }
            }
        }
    }
}
