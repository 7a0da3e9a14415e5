//! Deviations of a few windows at a time, without burn: what runs beside an estimator.

use crate::config::ProNetConfig;
use crate::engine::{Buffer, Chunk, Engine};
use crate::weights::Weights;

/// A network ready to be asked: packed weights and the room it computes in. One thread; the same input gives the same bits.
#[derive(Debug)]
pub struct Predictor {
    engine: Engine,
    packed: Buffer,
    chunk: Chunk,
    config: ProNetConfig,
    negated: Vec<f32>,
    other: Vec<f32>,
}

impl Predictor {
    /// A predictor with these weights.
    pub fn new(weights: &Weights) -> Self {
        let engine = Engine::new(weights.config());
        let mut packed = Buffer::default();
        engine.pack(weights.parameters(), &mut packed);
        Self {
            engine,
            packed,
            chunk: Chunk::default(),
            config: weights.config().clone(),
            negated: Vec::new(),
            other: Vec::new(),
        }
    }

    /// What the network was made from.
    pub fn config(&self) -> &ProNetConfig {
        &self.config
    }

    /// Writes the deviation of each window into `sigma`; with `symmetrise` the mean of those of the window and of its negative.
    ///
    /// # Shapes
    /// `windows`: `[count, window]`, row by row; `sigma`: `[count]`.
    ///
    /// # Units and frames
    /// Samples of one axis and their deviation, both in m/s^2 or rad/s.
    ///
    /// # Panics
    /// When `windows` does not hold one window for each entry of `sigma`.
    pub fn predict(&mut self, windows: &[f32], sigma: &mut [f32]) {
        assert_eq!(windows.len(), sigma.len() * self.config.window, "one window for each deviation");
        if sigma.is_empty() {
            return;
        }
        self.engine.infer(&self.packed, windows, &mut self.chunk, sigma);
        if self.config.symmetrise {
            self.negated.clear();
            self.negated.extend(windows.iter().map(|w| -w));
            self.other.resize(sigma.len(), 0.0);
            self.engine.infer(&self.packed, &self.negated, &mut self.chunk, &mut self.other);
            for (s, o) in sigma.iter_mut().zip(&self.other) {
                *s = 0.5 * (*s + o);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::init::initial_parameters;
    use crate::weights::Card;
    use dpn_core::random::Stream;
    use rand::Rng;

    fn predictor(symmetrise: bool) -> Predictor {
        let config = ProNetConfig { symmetrise, ..ProNetConfig::default() };
        let flat = initial_parameters(&config, &Stream::new(4));
        Predictor::new(&Weights::new(&config, flat, Card::default()))
    }

    fn windows(count: usize) -> Vec<f32> {
        let mut rng = Stream::new(9).rng();
        (0..count * 200).map(|_| 9.81 + 0.1 * (rng.random::<f32>() - 0.5)).collect()
    }

    #[test]
    fn a_window_gets_the_same_bits_alone_and_in_company() {
        let x = windows(7);
        let mut together = vec![0.0; 7];
        let mut p = predictor(false);
        p.predict(&x, &mut together);
        for (window, sigma) in x.chunks(200).zip(together) {
            let mut alone = [0.0];
            p.predict(window, &mut alone);
            assert_eq!(alone[0].to_bits(), sigma.to_bits());
        }
    }

    #[test]
    fn symmetrised_deviations_do_not_see_the_sign() {
        let x = windows(3);
        let negative: Vec<f32> = x.iter().map(|v| -v).collect();
        let (mut a, mut b, mut plain) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let mut p = predictor(true);
        p.predict(&x, &mut a);
        p.predict(&negative, &mut b);
        assert_eq!(a, b);
        predictor(false).predict(&x, &mut plain);
        assert_ne!(a, plain);
    }
}
