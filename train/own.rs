//! The white noise a window holds before anything is injected.
//!
//! Second label of decision 9: `sigma_tot = sqrt(injected^2 + own^2)`.

use crate::windows::WINDOW;
use dpn_core::signal::SavitzkyGolay;
use std::sync::OnceLock;

/// Window and order of the filter whose residual counts as the window's own noise.
const OWN_FILTER: (usize, usize) = (5, 2);

/// Deviation of what Savitzky-Golay (5, 2) takes out of `window`, divided by the filter's gain for white noise: the
/// deviation of white noise that would leave the same residual.
///
/// # Shapes
/// `window`: [`WINDOW`] samples of one axis; the answer has their unit.
///
/// # Panics
/// When `window` has another length.
pub(crate) fn own_sigma(window: &[f64]) -> f64 {
    static FILTER: OnceLock<(SavitzkyGolay, f64)> = OnceLock::new();
    let (filter, gain) = FILTER.get_or_init(|| {
        let filter = SavitzkyGolay::new(OWN_FILTER.0, OWN_FILTER.1).expect("an odd window above its order");
        let gain = filter.residual_gain(WINDOW);
        (filter, gain)
    });
    let mut smooth = [0.0; WINDOW];
    filter.smooth_into(window, &mut smooth).expect("a window has `WINDOW` samples");
    let power = window.iter().zip(&smooth).map(|(x, s)| (x - s).powi(2)).sum::<f64>() / WINDOW as f64;
    power.sqrt() / gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::inject;
    use dpn_core::random::Stream;

    #[test]
    fn a_parabola_holds_no_noise_and_white_noise_holds_its_own() {
        let parabola: Vec<f64> = (0..WINDOW).map(|i| 9.81 + 1e-4 * (i as f64).powi(2)).collect();
        assert!(own_sigma(&parabola) < 1e-12);
        assert!(std::panic::catch_unwind(|| own_sigma(&parabola[1..])).is_err());
        let mut power = 0.0;
        for k in 0..400 {
            let mut window = parabola.clone();
            inject(&mut window, 0.05, &mut Stream::new(5).named("own").index(k).rng());
            power += own_sigma(&window).powi(2);
        }
        // The residual keeps about 100 degrees of freedom: 400 windows give the deviation to .35 %; four of these.
        assert!(((power / 400.0).sqrt() / 0.05 - 1.0).abs() < 0.013);
    }
}
