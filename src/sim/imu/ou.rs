//! Slow wander: an Ornstein-Uhlenbeck process, sampled exactly.
//!
//! x_{k+1} = a x_k + sigma sqrt(1 - a^2) w_k, a = exp(-dt / tau): stationary deviation sigma, correlation time tau.

use dpn_core::random::StreamRng;
use rand::Rng;
use rand_distr::StandardNormal;

/// A stationary wander of deviation `sigma`.
#[derive(Debug, Clone)]
pub(crate) struct Wander {
    keep: f64,
    kick: f64,
    at: f64,
    rng: StreamRng,
}

impl Wander {
    /// Starts from the stationary distribution.
    pub(crate) fn new(sigma: f64, tau: f64, dt: f64, mut rng: StreamRng) -> Self {
        let keep = (-dt / tau).exp();
        let start: f64 = rng.sample(StandardNormal);
        Self { keep, kick: sigma * (1.0 - keep * keep).sqrt(), at: sigma * start, rng }
    }

    /// The value now; moves on by one step.
    pub(crate) fn next(&mut self) -> f64 {
        let now = self.at;
        let draw: f64 = self.rng.sample(StandardNormal);
        self.at = self.keep * now + self.kick * draw;
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn deviation_and_correlation_are_those_asked_for() {
        let (sigma, tau, dt, n) = (0.7, 0.5, 0.05, 200_000);
        let mut wander = Wander::new(sigma, tau, dt, Stream::new(3).rng());
        let x: Vec<f64> = (0..n).map(|_| wander.next()).collect();
        let variance = x.iter().map(|v| v * v).sum::<f64>() / n as f64;
        let lag = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
        // About n dt / tau = 20,000 independent samples: 1 % of the variance is one standard error.
        assert!((variance / (sigma * sigma) - 1.0).abs() < 0.04);
        assert!((lag / variance - (-0.1_f64).exp()).abs() < 0.005);
    }
}
