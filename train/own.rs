//! The white noise a window holds before anything is injected.
//!
//! Second label of decision 9: `sigma_tot = sqrt(injected^2 + own^2)`.

use dpn_core::signal::{FilterError, SavitzkyGolay};

/// Window and order of the filter whose residual counts as the window's own noise.
const OWN_FILTER: (usize, usize) = (5, 2);

/// What says it, of windows of one length.
#[derive(Debug, Clone)]
pub(crate) struct OwnNoise {
    filter: SavitzkyGolay,
    gain: f64,
}

impl OwnNoise {
    /// For windows of `len` samples.
    ///
    /// # Errors
    /// A window shorter than the filter.
    pub(crate) fn new(len: usize) -> Result<Self, FilterError> {
        let (window, order) = OWN_FILTER;
        if len < window {
            return Err(FilterError::SignalTooShort { len, window });
        }
        let filter = SavitzkyGolay::new(window, order)?;
        let gain = filter.residual_gain(len);
        Ok(Self { filter, gain })
    }

    /// Deviation of what Savitzky-Golay (5, 2) takes out of `window`, divided by the filter's gain for white noise: the
    /// deviation of white noise that would leave the same residual. It has the window's unit.
    ///
    /// # Panics
    /// When `window` is shorter than the filter.
    pub(crate) fn sigma(&self, window: &[f64]) -> f64 {
        let mut smooth = vec![0.0; window.len()];
        self.filter.smooth_into(window, &mut smooth).expect("no window is shorter than the filter");
        let power =
            window.iter().zip(&smooth).map(|(x, s)| (x - s).powi(2)).sum::<f64>() / window.len() as f64;
        power.sqrt() / self.gain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::inject;
    use crate::windows::WINDOW;
    use dpn_core::random::Stream;

    #[test]
    fn a_parabola_holds_no_noise_and_white_noise_holds_its_own() {
        let parabola: Vec<f64> = (0..WINDOW).map(|i| 9.81 + 1e-4 * (i as f64).powi(2)).collect();
        let own = OwnNoise::new(WINDOW).unwrap();
        assert!(own.sigma(&parabola) < 1e-12);
        assert!(OwnNoise::new(4).is_err());
        let mut power = 0.0;
        for k in 0..400 {
            let mut window = parabola.clone();
            inject(&mut window, 0.05, &mut Stream::new(5).named("own").index(k).rng());
            power += own.sigma(&window).powi(2);
        }
        // The residual keeps about 100 degrees of freedom: 400 windows give the deviation to .35 %; four of these.
        assert!(((power / 400.0).sqrt() / 0.05 - 1.0).abs() < 0.013);
    }
}
