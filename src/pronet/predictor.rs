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
}

impl Predictor {
    /// A predictor with these weights.
    pub fn new(weights: &Weights) -> Self {
        let engine = Engine::new(weights.config());
        let mut packed = Buffer::default();
        engine.pack(weights.parameters(), &mut packed);
        Self { engine, packed, chunk: Chunk::default(), config: weights.config().clone() }
    }

    /// What the network was made from.
    pub fn config(&self) -> &ProNetConfig {
        &self.config
    }

    /// Writes the deviation of each window into `sigma`.
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
        if !sigma.is_empty() {
            self.engine.infer(&self.packed, windows, &mut self.chunk, sigma);
        }
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::init::initial_parameters;
    use crate::weights::Card;
    use dpn_core::random::Stream;
    use rand::Rng;

    fn predictor() -> Predictor {
        let config = ProNetConfig::default();
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
        let mut p = predictor();
        p.predict(&x, &mut together);
        for (window, sigma) in x.chunks(200).zip(together) {
            let mut alone = [0.0];
            p.predict(window, &mut alone);
            assert_eq!(alone[0].to_bits(), sigma.to_bits());
        }
    }
}
