//! Adam over one flat list of parameters, with decoupled weight decay, and the running mean of the weights.
//!
//! Written out instead of burn's optimiser so that its whole state is three lists of numbers: a run that is stopped and
//! resumed goes on to the same bits. Same update as PyTorch's `AdamW`: `golden/adam` holds its trace.
//!
//! m <- b1 m + (1 - b1) g,  v <- b2 v + (1 - b2) g^2,
//! w <- w - lr wd w - lr (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + eps)
//!
//! # Source
//! Kingma and Ba 2015; Loshchilov and Hutter 2019 (decoupled decay).

/// Decays of the two means, and the number that keeps the quotient finite: the usual ones.
const BETA_1: f32 = 0.9;
const BETA_2: f32 = 0.999;
const EPSILON: f32 = 1e-8;

/// State of the optimiser.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// Running mean of the gradient.
    pub mean: Vec<f32>,
    /// Running mean of its square.
    pub square: Vec<f32>,
    /// Updates made.
    pub step: u64,
}

impl Adam {
    /// The state before the first update of `count` parameters.
    pub fn new(count: usize) -> Self {
        Self { mean: vec![0.0; count], square: vec![0.0; count], step: 0 }
    }

    /// Changes `weights` along `gradient`.
    ///
    /// # Shapes
    /// `weights` and `gradient` have as many numbers as the state.
    pub fn update(&mut self, weights: &mut [f32], gradient: &[f32], rate: f64, decay: f64) {
        self.step += 1;
        let t = self.step as f64;
        let correct_1 = 1.0 - f64::from(BETA_1).powf(t);
        let correct_2 = (1.0 - f64::from(BETA_2).powf(t)).sqrt();
        let pull = (1.0 - rate * decay) as f32;
        let size = (rate / correct_1) as f32;
        let root = correct_2 as f32;
        let moments = self.mean.iter_mut().zip(&mut self.square);
        for ((weight, g), (mean, square)) in weights.iter_mut().zip(gradient).zip(moments) {
            *mean += (1.0 - BETA_1) * (g - *mean);
            *square = BETA_2 * *square + (1.0 - BETA_2) * g * g;
            *weight = *weight * pull - size * *mean / (square.sqrt() / root + EPSILON);
        }
    }
}

/// Shrinks `gradient` so that its norm is at most `limit` (0: never); returns the norm it had.
pub fn clip(gradient: &mut [f32], limit: f64) -> f64 {
    let norm = gradient.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
    if limit > 0.0 && norm > limit {
        let factor = (limit / (norm + 1e-6)) as f32;
        gradient.iter_mut().for_each(|g| *g *= factor);
    }
    norm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_has_the_learning_rates_size_whatever_the_gradient() {
        let mut weights = [1.0f32, -2.0];
        Adam::new(2).update(&mut weights, &[1e-4, -3.0], 0.1, 0.0);
        assert!((weights[0] - 0.9).abs() < 1e-4 && (weights[1] + 1.9).abs() < 1e-6);
    }

    #[test]
    fn clipping_keeps_the_direction_and_leaves_small_gradients_alone() {
        let mut gradient = [3.0f32, 4.0];
        assert!((clip(&mut gradient, 1.0) - 5.0).abs() < 1e-12);
        assert!((gradient[0] - 0.6).abs() < 1e-6 && (gradient[1] - 0.8).abs() < 1e-6);
        let mut small = [0.3f32, 0.4];
        clip(&mut small, 1.0);
        assert_eq!(small, [0.3, 0.4]);
        let mut free = [30.0f32, 40.0];
        clip(&mut free, 0.0);
        assert_eq!(free, [30.0, 40.0]);
    }
}
