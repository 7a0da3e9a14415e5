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
    /// Answers of more than one number, before they are taken apart.
    answers: Vec<f32>,
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
            answers: Vec::new(),
        }
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
        if sigma.is_empty() {
            return;
        }
        if self.says_spread() {
            self.ask(windows, sigma.len());
            for (sigma, answer) in sigma.iter_mut().zip(self.answers.chunks_exact(2)) {
                *sigma = answer[0];
            }
        } else {
            self.engine.infer(&self.packed, windows, &mut self.chunk, sigma);
        }
    }

    /// Whether the network says how far off it takes itself to be.
    pub fn says_spread(&self) -> bool {
        self.config.head.outputs() == 2
    }

    /// As [`predict`](Self::predict), with the deviation of every answer's logarithm: .1 is an answer that the network takes to be right
    /// within 10 % two times of three.
    ///
    /// # Shapes
    /// `windows`: `[count, window]`, row by row; `sigma` and `spread`: `[count]`.
    ///
    /// # Panics
    /// When the network does not say it ([`says_spread`](Self::says_spread)), or the lengths do not fit each other.
    pub fn predict_with_spread(&mut self, windows: &[f32], sigma: &mut [f32], spread: &mut [f32]) {
        assert!(self.says_spread(), "this network does not say how sure it is");
        assert_eq!(windows.len(), sigma.len() * self.config.window, "one window for each deviation");
        assert_eq!(sigma.len(), spread.len(), "one spread for each deviation");
        self.ask(windows, sigma.len());
        for ((sigma, spread), answer) in sigma.iter_mut().zip(spread).zip(self.answers.chunks_exact(2)) {
            (*sigma, *spread) = (answer[0], answer[1]);
        }
    }

    /// Answers to `count` windows.
    fn ask(&mut self, windows: &[f32], count: usize) {
        self.answers.resize(count * self.config.head.outputs(), 0.0);
        self.engine.infer(&self.packed, windows, &mut self.chunk, &mut self.answers);
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
    fn a_network_of_two_answers_says_the_same_deviations_with_its_spread_and_without() {
        let config = ProNetConfig { head: crate::config::Head::LogSigmaAndSpread, ..ProNetConfig::default() };
        let flat = initial_parameters(&config, &Stream::new(4));
        let mut two = Predictor::new(&Weights::new(&config, flat, Card::default()));
        let x = windows(3);
        let (mut alone, mut sigma, mut spread) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        two.predict(&x, &mut alone);
        two.predict_with_spread(&x, &mut sigma, &mut spread);
        assert_eq!(alone, sigma);
        assert!(
            sigma.iter().zip(spread).all(|(sigma, spread)| *sigma > 0.0 && spread > 0.0 && spread != *sigma)
        );
        assert!(two.says_spread() && !predictor().says_spread());
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
