//! Which deviations are injected (decision 10).

use dpn_core::Sensor;
use rand::Rng;
use serde::{Deserialize, Serialize};

/// How injected deviations are chosen over `[low, high]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelKind {
    /// The paper's grid: evenly spaced levels, each as likely.
    Grid,
    /// Any value, evenly.
    Uniform,
    /// Any value, evenly in its logarithm.
    LogUniform,
}

impl LevelKind {
    /// `"grid"` or `"continuous"`: the word used in result rows.
    pub fn family(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Uniform | Self::LogUniform => "continuous",
        }
    }
}

/// Levels of injected white noise for one sensor \[m/s^2 or rad/s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    /// How values are chosen.
    pub kind: LevelKind,
    /// Smallest deviation.
    pub low: f64,
    /// Largest deviation.
    pub high: f64,
    /// Number of grid points.
    pub steps: usize,
}

impl Levels {
    /// The paper's grids: .01 to .21 by .02 m/s^2 and .001 to .015 by .002 rad/s.
    ///
    /// # Source
    /// VIO-DualProNet, section "Data Preprocessing".
    pub fn paper(sensor: Sensor, kind: LevelKind) -> Self {
        match sensor {
            Sensor::Accel => Self { kind, low: 0.01, high: 0.21, steps: 11 },
            Sensor::Gyro => Self { kind, low: 0.001, high: 0.015, steps: 8 },
        }
    }

    /// Every grid point, in rising order.
    pub fn grid(&self) -> Vec<f64> {
        let step = if self.steps > 1 { (self.high - self.low) / (self.steps - 1) as f64 } else { 0.0 };
        (0..self.steps).map(|i| self.low + step * i as f64).collect()
    }

    /// One level at random.
    ///
    /// # Panics
    /// When there is none: no grid points, or `low` above `high`.
    pub fn draw(&self, rng: &mut impl Rng) -> f64 {
        match self.kind {
            LevelKind::Grid => {
                let at = rng.random_range(0..self.steps);
                self.grid()[at]
            }
            LevelKind::Uniform => rng.random_range(self.low..=self.high),
            LevelKind::LogUniform => rng.random_range(self.low.ln()..=self.high.ln()).exp(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn the_papers_grids_come_out() {
        let accel = Levels::paper(Sensor::Accel, LevelKind::Grid).grid();
        assert_eq!(accel.len(), 11);
        assert!((accel[5] - 0.11).abs() < 1e-15 && (accel[10] - 0.21).abs() < 1e-15);
        let gyro = Levels::paper(Sensor::Gyro, LevelKind::Grid).grid();
        assert_eq!(gyro.len(), 8);
        assert!((gyro[1] - 0.003).abs() < 1e-15);
    }

    #[test]
    fn grid_draws_hit_grid_points_and_uniform_ones_fill_the_range() {
        let mut rng = Stream::new(3).named("levels").rng();
        let grid = Levels::paper(Sensor::Gyro, LevelKind::Grid);
        let mut seen = vec![0; 8];
        for _ in 0..800 {
            let level = grid.draw(&mut rng);
            let at = grid.grid().iter().position(|g| *g == level).expect("a grid point");
            seen[at] += 1;
        }
        // 100 expected each, deviation 9.4.
        assert!(seen.iter().all(|&n| (60..140).contains(&n)), "{seen:?}");
        let uniform = Levels::paper(Sensor::Accel, LevelKind::Uniform);
        let draws: Vec<f64> = (0..2000).map(|_| uniform.draw(&mut rng)).collect();
        let mean = draws.iter().sum::<f64>() / 2000.0;
        assert!((mean - 0.11).abs() < 4.0 * 0.0577 / 2000f64.sqrt());
        assert!(draws.iter().all(|d| (0.01..=0.21).contains(d)));
    }
}
