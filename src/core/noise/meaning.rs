//! What a number in a configuration means, and the way from it to a density and back.

use super::units::{
    AccelBiasWalkDensity, AccelNoiseDensity, BadNoise, GyroBiasWalkDensity, GyroNoiseDensity, checked,
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
    /// Variance of the bias's increment from sample to sample, for example \[(rad/s)^2\].
    WalkStepVariance,
    /// Deviation of the bias's rate of change, one value a sample, for example \[rad/s^2\].
    WalkRateStd,
}

impl Meaning {
    /// Whether it is the walk of a bias.
    pub fn is_walk(self) -> bool {
        matches!(self, Self::WalkDensity | Self::WalkStepVariance | Self::WalkRateStd)
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
            (Self::SampleStd, true) => "m/s^2",
            (Self::SampleStd, false) => "rad/s",
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
            Self::WalkStepVariance => format!("({number} / sqrt({rate}))^2"),
        }
    }
}

impl Meaning {
    /// The density that `number` stands for at `rate`.
    fn to_density(self, number: f64, rate: SampleRate) -> f64 {
        let root = rate.hz().sqrt();
        match self {
            Self::Density | Self::WalkDensity => number,
            Self::Power => number.sqrt(),
            Self::SampleStd | Self::WalkRateStd => number / root,
            Self::SampleVariance => number.sqrt() / root,
            Self::WalkStepVariance => number.sqrt() * root,
        }
    }

    /// The number that stands for `density` at `rate`.
    fn of_density(self, density: f64, rate: SampleRate) -> f64 {
        let root = rate.hz().sqrt();
        let square = |value: f64| value * value;
        match self {
            Self::Density | Self::WalkDensity => density,
            Self::Power => square(density),
            Self::SampleStd | Self::WalkRateStd => density * root,
            Self::SampleVariance => square(density * root),
            Self::WalkStepVariance => square(density / root),
        }
    }

    /// What a number of `figure` means: a meaning of the other kind of noise is the density's.
    fn of(self, figure: Figure) -> Self {
        if self.is_walk() == figure.is_walk() { self } else { Self::Density }
    }
}

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
        let density = |number| Ok::<_, BadNoise>(meaning.of(figure).to_density(checked(number)?, rate));
        let densities = values.try_map(density)?;
        match figure {
            Figure::AccelWhite => self.accel_white = Some(densities.try_map(AccelNoiseDensity::new)?),
            Figure::GyroWhite => self.gyro_white = Some(densities.try_map(GyroNoiseDensity::new)?),
            Figure::AccelWalk => self.accel_walk = Some(densities.try_map(AccelBiasWalkDensity::new)?),
            Figure::GyroWalk => self.gyro_walk = Some(densities.try_map(GyroBiasWalkDensity::new)?),
        }
        Ok(())
    }

    /// The numbers of one figure as `meaning` at `rate`, where known.
    pub fn get(&self, figure: Figure, meaning: Meaning, rate: SampleRate) -> Option<Axes<f64>> {
        let densities = self.density(figure)?;
        Some(densities.map(|density| meaning.of(figure).of_density(density, rate)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHITE: [Meaning; 4] =
        [Meaning::Density, Meaning::Power, Meaning::SampleStd, Meaning::SampleVariance];
    const WALK: [Meaning; 3] = [Meaning::WalkDensity, Meaning::WalkStepVariance, Meaning::WalkRateStd];

    #[test]
    fn a_hundredth_per_sample_at_a_hundred_hertz_is_known_in_every_meaning() {
        let rate = SampleRate::from_hz(100.0).unwrap();
        let mut figures = ImuFigures::default();
        let near = |figures: &ImuFigures, figure, meanings: &[Meaning], wanted: &[f64]| {
            for (m, wanted) in meanings.iter().zip(wanted) {
                let got = figures.get(figure, *m, rate).unwrap().largest();
                assert!((got / wanted - 1.0).abs() < 1e-12, "{m:?}: {got} {wanted}");
            }
        };
        for figure in [Figure::AccelWhite, Figure::GyroWhite] {
            figures.set(figure, Meaning::SampleStd, Axes::Same(0.01), rate).unwrap();
            near(&figures, figure, &WHITE, &[1e-3, 1e-6, 1e-2, 1e-4]);
        }
        for figure in [Figure::AccelWalk, Figure::GyroWalk] {
            figures.set(figure, Meaning::WalkStepVariance, Axes::Same(1e-4), rate).unwrap();
            near(&figures, figure, &WALK, &[0.1, 1e-4, 1.0]);
        }
    }

    #[test]
    fn a_step_and_a_rate_are_the_same_walk() {
        let (rate, walk) = (SampleRate::HZ_200, Figure::AccelWalk);
        let as_meant = |meaning| ImuFigures::euroc().get(walk, meaning, rate).unwrap().largest();
        // One step of 5 ms at the rate moves the bias by the step.
        let moved = as_meant(Meaning::WalkRateStd) * rate.period();
        assert!((moved - as_meant(Meaning::WalkStepVariance).sqrt()).abs() < 1e-18);
        let mut figures = ImuFigures::default();
        let variance = Axes::Same(as_meant(Meaning::WalkStepVariance));
        figures.set(walk, Meaning::WalkStepVariance, variance, rate).unwrap();
        assert!((figures.density(walk).unwrap().largest() - 3e-3).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn every_meaning_there_and_back_is_the_same(log in -9.0..2.0f64, hz in 1.0..5000.0f64, pick in 0usize..4) {
            let (value, rate) = (10f64.powf(log), SampleRate::from_hz(hz).unwrap());
            for figure in Figure::ALL {
                let meaning = if figure.is_walk() { WALK[pick % WALK.len()] } else { WHITE[pick] };
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
