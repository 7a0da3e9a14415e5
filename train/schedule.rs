//! Course of the learning rate.

use crate::config::{FitConfig, Schedule};
use std::f64::consts::PI;

/// Learning rate of update `step` (from 0) of `total`.
pub fn learning_rate(fit: &FitConfig, step: u64, total: u64) -> f64 {
    let warm = fit.warmup_steps.min(total);
    if step < warm {
        return fit.learning_rate * (step + 1) as f64 / warm as f64;
    }
    match fit.schedule {
        Schedule::Constant => fit.learning_rate,
        Schedule::Cosine => {
            let share = (step - warm) as f64 / (total - warm).max(1) as f64;
            fit.learning_rate * 0.5 * (1.0 + (PI * share).cos())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_to_its_top_and_falls_to_nothing() {
        let fit = FitConfig {
            learning_rate: 1.0,
            warmup_steps: 10,
            schedule: Schedule::Cosine,
            ..FitConfig::default()
        };
        assert!((learning_rate(&fit, 0, 110) - 0.1).abs() < 1e-12);
        assert!((learning_rate(&fit, 10, 110) - 1.0).abs() < 1e-12);
        assert!((learning_rate(&fit, 60, 110) - 0.5).abs() < 1e-12);
        assert!(learning_rate(&fit, 109, 110) < 3e-4);
        let constant = FitConfig { schedule: Schedule::Constant, warmup_steps: 0, ..fit };
        assert_eq!(learning_rate(&constant, 0, 110), learning_rate(&constant, 109, 110));
    }
}
