//! Adam over the flat parameters, whose whole state is two vectors and a count.
//!
//! Written out here, though burn has an Adam: burn's keeps its state by parameter identifier in records of its own, splits every step in
//! some three hundred small tensor operations, and has no decoupled weight decay with a clip over all gradients together. Over one flat vector it is a
//! loop, its state is saved to the bit in three lines, and a test holds it to PyTorch's numbers.
//!
//! `m <- b1 m + (1 - b1) g`, `v <- b2 v + (1 - b2) g^2`, `p <- p - lr (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + eps)`, after
//! `p <- p (1 - lr decay)` (Loshchilov and Hutter's decoupled decay; zero is plain Adam).
//! Source: Kingma and Ba 2015 (arXiv 1412.6980), Loshchilov and Hutter 2019 (arXiv 1711.05101).

dpn_core::settings!(
    /// Adam's constants; PyTorch's defaults.
    #[derive(Copy)]
    pub struct AdamConfig {
        /// Decay of the mean gradient \[0 to below 1\].
        pub beta1: f64 = 0.9,
        /// Decay of the mean squared gradient \[0 to below 1\].
        pub beta2: f64 = 0.999,
        /// Added to the root of the latter \[above 0\].
        pub epsilon: f64 = 1e-8,
        /// Decoupled weight decay \[0 or more, a step and unit of learning rate\].
        pub weight_decay: f64 = 0.0,
    }
);

/// Adam's constants and state.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    config: AdamConfig,
    pub(crate) mean: Vec<f32>,
    pub(crate) square: Vec<f32>,
    pub(crate) steps: u64,
}

impl Adam {
    /// Adam before its first step, for `count` parameters.
    pub fn new(config: AdamConfig, count: usize) -> Self {
        Self { config, mean: vec![0.0; count], square: vec![0.0; count], steps: 0 }
    }

    /// Goes on from [`Self::state`] after so many steps.
    pub fn resumed(config: AdamConfig, [mean, square]: [Vec<f32>; 2], steps: u64) -> Self {
        Self { config, mean, square, steps }
    }

    /// Its running means of the gradient and of the gradient's squares.
    pub fn state(&self) -> [&[f32]; 2] {
        [&self.mean, &self.square]
    }

    /// Its constants.
    pub fn config(&self) -> &AdamConfig {
        &self.config
    }

    /// How many steps were taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Moves `parameters` one step against `gradient` at the learning rate `rate`.
    ///
    /// # Panics
    /// When either has not as many numbers as this Adam was made for.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], rate: f64) {
        let count = self.mean.len();
        assert!(
            parameters.len() == count && gradient.len() == count,
            "this Adam is for {count} parameters, not {} with {} gradients",
            parameters.len(),
            gradient.len()
        );
        self.steps += 1;
        let AdamConfig { beta1, beta2, epsilon, weight_decay } = self.config;
        let correction = |beta: f64| 1.0 - beta.powf(self.steps as f64);
        let step = (rate / correction(beta1)) as f32;
        let per_root = (1.0 / correction(beta2).sqrt()) as f32;
        let (keep1, keep2, epsilon) = (beta1 as f32, beta2 as f32, epsilon as f32);
        let (take1, take2) = ((1.0 - beta1) as f32, (1.0 - beta2) as f32);
        let kept = (1.0 - rate * weight_decay) as f32;
        for (((p, g), m), v) in parameters.iter_mut().zip(gradient).zip(&mut self.mean).zip(&mut self.square)
        {
            *m = keep1 * *m + take1 * g;
            *v = keep2 * *v + take2 * (g * g);
            *p = *p * kept - step * *m / (v.sqrt() * per_root + epsilon);
        }
    }
}

/// Scales `gradient` down to the length `most` if it is longer, and returns the length it had (PyTorch's `clip_grad_norm_`).
pub fn clip_length(gradient: &mut [f32], most: f64) -> f64 {
    let length = gradient.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
    if length > most {
        let factor = (most / (length + 1e-6)) as f32;
        for g in gradient.iter_mut() {
            *g *= factor;
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_longer_gradient_is_cut_to_length_and_a_shorter_left_alone() {
        let mut g = [3.0f32, 4.0];
        assert_eq!(clip_length(&mut g, 10.0), 5.0);
        assert_eq!(g, [3.0, 4.0]);
        assert_eq!(clip_length(&mut g, 1.0), 5.0);
        assert!((g[0] - 0.6).abs() < 1e-6 && (g[1] - 0.8).abs() < 1e-6);
    }

    #[test]
    fn the_first_step_is_the_learning_rate_whatever_the_gradient() {
        // m / (1 - b1) = g and sqrt(v / (1 - b2)) = |g| at the first step.
        let mut adam = Adam::new(AdamConfig::default(), 3);
        let mut p = [1.0f32, 1.0, 1.0];
        adam.step(&mut p, &[1e-3, -5.0, 1e3], 0.01);
        for (p, want) in p.iter().zip([0.99, 1.01, 0.99]) {
            assert!((p - want).abs() < 1e-6, "{p} {want}");
        }
    }
}
