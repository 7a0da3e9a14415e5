//! What a run learned of its IMU's noise, as figures: densities with intervals, and what it does not know.
//!
//! The figure of an axis is the root of the mean square of the noise in force, from the first frame at which levels were read to the end. Its logarithm is as unsure as all residuals
//! together leave it were it constant, or as its means over spans of three memories scatter, whichever is more. Several runs of one platform together: the mean square by their
//! lengths; from three runs on their scatter counts too (Student).

use super::drive::EstimatorOutput;
use super::recording::Recording;
use dpn_core::noise::{Figure, Interval};
use dpn_core::signal::stats::{Ddof, deviation};
use dpn_core::{NoiseTrack, SampleRate, Sensor};
use dpn_vio::EstimatorConfig;
use dpn_vio::components::Levels;
use dpn_vio::estimator::Update;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Factors on the deviations told: of the samples by axis, of the biases' walks, of the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LearnedLevels {
    /// Accelerometer x, y, z.
    pub accel: [f64; 3],
    /// Gyroscope x, y, z.
    pub gyro: [f64; 3],
    /// The walk of the accelerometer's bias.
    pub accel_walk: f64,
    /// The walk of the gyroscope's bias.
    pub gyro_walk: f64,
    /// The pixels.
    pub pixel: f64,
}

impl LearnedLevels {
    /// Those in force.
    pub fn of(levels: &Levels) -> Self {
        let [ax, ay, az, gx, gy, gz, accel_walk, gyro_walk] = levels.inertial.0;
        Self { accel: [ax, ay, az], gyro: [gx, gy, gz], accel_walk, gyro_walk, pixel: levels.pixel }
    }
}

/// A figure and how it came to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LearnedFigure {
    /// Which.
    pub figure: Figure,
    /// Its density, x, y, z, in [`Figure::unit`].
    pub density: [Interval; 3],
    /// Deviation of its logarithm by what residuals say alone, the worst axis, were it constant.
    pub unsure: f64,
    /// Whether an axis is at the data sheet's floor, below which nothing is learned: then it is a bound.
    pub at_floor: bool,
    /// Whether something speaks against believing the run: its levels are then no sensor's.
    #[serde(default)]
    pub doubted: bool,
}

impl LearnedFigure {
    /// Why it is no figure, where it is none.
    pub fn not_known(&self) -> Option<&'static str> {
        if self.doubted {
            Some("the run is not to be trusted")
        } else if Interval::of_log(1.0, self.unsure).width() > Interval::WIDEST {
            Some("the run says next to nothing of it: it stayed near its start")
        } else if self.at_floor {
            Some("at most its floor: less is not learned (components in the settings)")
        } else {
            None
        }
    }
}

/// What one run, or several of one platform, learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearnedNoise {
    /// Rate of the samples \[Hz\].
    pub rate_hz: SampleRate,
    /// How long levels were read \[s\].
    pub seconds: f64,
    /// Runs it is from.
    pub runs: usize,
    /// In the order of [`Figure::ALL`].
    pub figures: [LearnedFigure; 4],
}

/// Spans whose means are compared, in memories.
const SPAN: f64 = 3.0;
/// A level so near its floor is at it.
const AT_FLOOR: f64 = 1.02;

impl LearnedNoise {
    /// Of a run that learned its levels; `in_force` is the noise told times those, `doubted` whether something speaks against believing the run. None where none was read.
    pub(super) fn of(
        recording: &Recording,
        config: &EstimatorConfig,
        output: &EstimatorOutput,
        in_force: &NoiseTrack,
        doubted: bool,
    ) -> Option<Self> {
        let components = config.components?;
        let rate = recording.imu.rate();
        let read = |update: &&Update| {
            update.levels.as_ref().is_some_and(|levels| levels.unsure.iter().any(|unsure| *unsure < 1.0))
        };
        let updates: Vec<&Update> = output.updates.iter().skip_while(|update| !read(update)).collect();
        let (first, last) = (updates.first()?, updates.last()?);
        let seconds = last.t.seconds_since(first.t);
        if seconds <= 0.0 {
            return None;
        }
        let spans = ((seconds / (SPAN * components.memory_s)) as usize).max(1);
        let span_of = |t: dpn_core::Stamp| {
            ((t.seconds_since(first.t) / seconds * spans as f64) as usize).min(spans - 1)
        };
        // Mean squares by span: six axes, two walks.
        let mut squares = vec![[0.0; 8]; spans];
        let mut counts = vec![[0_usize; 2]; spans];
        for (t, noise) in
            in_force.stamps().iter().zip(in_force.noises()).filter(|(t, _)| (first.t..=last.t).contains(t))
        {
            let span = span_of(*t);
            counts[span][0] += 1;
            for (axis, sigma) in Sensor::ALL.iter().flat_map(|sensor| noise.of(*sensor)).enumerate() {
                squares[span][axis] += sigma * sigma * rate.period();
            }
        }
        let told = [config.imu.accel_bias_walk.get(), config.imu.gyro_bias_walk.get()];
        for update in &updates {
            let Some(levels) = update.levels.as_deref() else { continue };
            let span = span_of(update.t);
            counts[span][1] += 1;
            for k in 0..2 {
                squares[span][6 + k] += (told[k] * levels.inertial.0[6 + k]).powi(2);
            }
        }
        let unsure = last.levels.as_ref()?.unsure;
        let density = |k: usize| {
            let means: Vec<f64> = squares
                .iter()
                .zip(&counts)
                .map(|(square, count)| (square[k], count[k / 6]))
                .filter(|(_, count)| *count > 0)
                .map(|(square, count)| square / count as f64)
                .collect();
            let mean = means.iter().sum::<f64>() / means.len().max(1) as f64;
            let logs: Vec<f64> = means.iter().map(|mean| 0.5 * mean.ln()).collect();
            Interval::of_log(mean.sqrt(), unsure[k].max(deviation_of_mean(&logs)))
        };
        let floors = [
            components.accel_floor.get(),
            components.accel_walk_floor.get(),
            components.gyro_floor.get(),
            components.gyro_walk_floor.get(),
        ];
        let mut places = [[0, 1, 2], [6; 3], [3, 4, 5], [7; 3]].into_iter().zip(floors);
        let figures = Figure::ALL.map(|figure| {
            let (places, floor) = places.next().expect("four figures");
            let density = places.map(density);
            let worst = places.iter().map(|k| unsure[*k]).fold(0.0, f64::max);
            LearnedFigure {
                figure,
                density,
                unsure: worst,
                at_floor: density.iter().any(|d| d.value < AT_FLOOR * floor),
                doubted,
            }
        });
        Some(Self { rate_hz: rate, seconds, runs: 1, figures })
    }

    /// Several runs of one platform; none of none.
    pub fn together(runs: &[Self]) -> Option<Self> {
        let first = runs.first()?;
        let seconds: f64 = runs.iter().map(|run| run.seconds).sum();
        let figures = std::array::from_fn(|i| {
            let knows = |run: &&Self| run.figures[i].not_known().is_none();
            // A run that does not know is no voice, unless none does.
            let heard: Vec<&Self> = match runs.iter().filter(knows).collect::<Vec<_>>() {
                known if known.is_empty() => runs.iter().collect(),
                known => known,
            };
            let total: f64 = heard.iter().map(|run| run.seconds).sum();
            let weighted = |value: &dyn Fn(&Self) -> f64| {
                heard.iter().map(|run| run.seconds / total * value(run)).sum::<f64>()
            };
            let density = std::array::from_fn(|axis| {
                let of = |run: &Self| run.figures[i].density[axis];
                let value = weighted(&|run| of(run).value.powi(2)).sqrt();
                let own = weighted(&|run| run.seconds / total * of(run).log_deviation().powi(2)).sqrt();
                let logs: Vec<f64> = heard.iter().map(|run| of(run).value.ln()).collect();
                Interval::of_log(value, own.max(deviation_of_mean(&logs)))
            });
            let unsure = weighted(&|run| run.seconds / total * run.figures[i].unsure.powi(2)).sqrt();
            let at_floor = heard.iter().all(|run| run.figures[i].at_floor);
            let doubted = heard.iter().all(|run| run.figures[i].doubted);
            LearnedFigure { figure: first.figures[i].figure, density, unsure, at_floor, doubted }
        });
        Some(Self { rate_hz: first.rate_hz, seconds, runs: runs.iter().map(|run| run.runs).sum(), figures })
    }

    /// Where it comes from, for people.
    pub fn words(&self) -> String {
        match self.runs {
            1 => format!("learned by the odometry, {:.0} s", self.seconds),
            runs => format!("learned by the odometry, {runs} runs, {:.0} s", self.seconds),
        }
    }
}

/// Of the mean of so many values by their scatter, as wide as Student's; 0 of fewer than three.
fn deviation_of_mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 3.0 {
        return 0.0;
    }
    let student = StudentsT::new(0.0, 1.0, n - 1.0).expect("two degrees of freedom or more");
    deviation(values, Ddof::One) / n.sqrt() * student.inverse_cdf(0.975) / 1.96
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seconds: f64, density: f64, deviation: f64) -> LearnedNoise {
        let figure = |figure| LearnedFigure {
            figure,
            density: [Interval::of_log(density, deviation); 3],
            unsure: deviation,
            at_floor: false,
            doubted: false,
        };
        LearnedNoise { rate_hz: SampleRate::HZ_200, seconds, runs: 1, figures: Figure::ALL.map(figure) }
    }

    #[test]
    fn runs_of_one_platform_are_surer_together_unless_they_disagree() {
        assert_eq!(LearnedNoise::together(&[]), None);
        let alike = LearnedNoise::together(&[run(100.0, 0.02, 0.1), run(100.0, 0.02, 0.1)]).unwrap();
        let found = alike.figures[0].density[0];
        assert!(
            (found.value - 0.02).abs() < 1e-12 && (found.log_deviation() - 0.1 / 2f64.sqrt()).abs() < 1e-9
        );
        assert_eq!((alike.runs, alike.seconds), (2, 200.0));
        let three = [run(100.0, 0.01, 0.01), run(100.0, 0.02, 0.01), run(100.0, 0.04, 0.01)];
        let apart = LearnedNoise::together(&three).unwrap().figures[0];
        // Logarithms one ln 2 apart: ln 2 / sqrt(3) times Student's 4.30 to 1.96.
        let expected = 2f64.ln() / 3f64.sqrt() * 4.303 / 1.96;
        assert!((apart.density[0].log_deviation() / expected - 1.0).abs() < 0.01, "{apart:?}");
        // They disagree, but each knows.
        assert_eq!(apart.not_known(), None);
        let with_one_that_knows_nothing =
            LearnedNoise::together(&[run(100.0, 0.02, 0.1), run(500.0, 0.5, 0.9)]).unwrap().figures[1];
        assert!((with_one_that_knows_nothing.density[2].value - 0.02).abs() < 1e-12);
        assert!(run(9.0, 0.5, 0.9).figures[0].not_known().is_some());
        // Nor is one that is not to be trusted, however sure it is.
        let mut doubted = run(500.0, 0.5, 0.01);
        doubted.figures.iter_mut().for_each(|figure| figure.doubted = true);
        assert!(doubted.figures[0].not_known().is_some());
        let beside = LearnedNoise::together(&[run(100.0, 0.02, 0.1), doubted]).unwrap().figures[0];
        assert!((beside.density[0].value - 0.02).abs() < 1e-12 && !beside.doubted);
        // The longer run counts more: (300 + 100 * 16) / 400.
        let long = LearnedNoise::together(&[run(300.0, 1.0, 0.1), run(100.0, 4.0, 0.1)]).unwrap();
        assert!((long.figures[2].density[1].value - 4.75f64.sqrt()).abs() < 1e-12);
    }
}
