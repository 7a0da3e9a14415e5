//! What the sightings that leave the window say of the pixels' level.
//!
//! The oldest frame hosts landmarks; each loses a sighting with it. Of a landmark of `m` sightings the squares of all residuals, the host's pixel
//! error common to them as in the solver, are `2 (m - 1) - 1` degrees of freedom: its depth is fitted. The poses take some six of a frame's two hundred
//! rows more, which is left out. Of that sum a share `1/(m - 1)` is counted, the sighting that leaves; so that over its track each counts once.

use crate::window::{Handover, Landmark, Window};
use nalgebra::{Matrix2, Vector2};

/// A landmark farther off than so many times its expectation is an outlier, and counts as this.
const CLIP: f64 = 4.0;

/// Squares found and squares expected, in present deviations of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PixelScore {
    pub(super) squares: f64,
    pub(super) redundancy: f64,
}

impl Window {
    /// Of the landmarks that the oldest frame hosts.
    pub(super) fn oldest_pixel_score(&self) -> PixelScore {
        let mut score = PixelScore::default();
        for landmark in self.landmarks.iter().filter(|l| l.host() == 0 && l.sightings.len() > 2) {
            let Some(squares) = self.squares(landmark) else { continue };
            let others = (landmark.sightings.len() - 1) as f64;
            let redundancy = 2.0 * others - 1.0;
            let once = self.config.handover == Handover::Consume;
            let all = once && landmark.handed_over(1) > 0;
            let share = if all { 1.0 } else { 1.0 / others };
            score.squares += share * squares.min(CLIP * redundancy);
            score.redundancy += share * redundancy;
        }
        score
    }

    /// `r^T C^-1 r` over a landmark's sightings, `C` holding the host's pixel error common to them.
    fn squares(&self, landmark: &Landmark) -> Option<f64> {
        let inverse_depth = landmark.inverse_depth?;
        let host = landmark.host_sighting();
        let seen_by_host = self.sighting_at_offset(host);
        let (mut squares, mut common, mut by_host) = (0.0, Matrix2::identity(), Vector2::zeros());
        for (frame, sighting) in &landmark.sightings[1..] {
            let geometry = self.geometry(landmark.host(), *frame);
            let seen = geometry.linearise(&seen_by_host, &self.sighting_at_offset(sighting), inverse_depth);
            let pixel = seen.d_host_pixel(&host.spread);
            let pixel = Matrix2::from_fn(|r, c| pixel[r][c]);
            squares += seen.residual.norm_squared();
            common += pixel.tr_mul(&pixel);
            by_host += pixel.tr_mul(&seen.residual);
        }
        Some(squares - by_host.dot(&(common.try_inverse()? * by_host)))
    }

    /// Says that all pixels are `factor` times as far off as thought.
    pub(super) fn rescale_pixels(&mut self, factor: f64) {
        self.config.pixel_std *= factor;
        for (_, sighting) in self.landmarks.iter_mut().flat_map(|landmark| &mut landmark.sightings) {
            sighting.rescale(factor);
        }
    }
}
