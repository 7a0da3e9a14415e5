//! How well a window knows the size of the path that its frames lie on.
//!
//! The size is the root mean square distance of the frames' positions `p_k` from their mean `m`, and with `s` the sum of these squares
//! ```text
//! d ln(size) / d p_k = (p_k - m) / s
//! ```
//! Its deviation, with the covariance of the window, is the relative deviation of the scale where nothing else gives one: large as well where the
//! frames hardly move and their size says little.

use super::window::Window;
use crate::state::POSITION;
use nalgebra::{DVector, Vector3};

impl Window {
    /// Derivative of the logarithm of the frames' size by the unknowns in their places; `None` where all frames are at one place.
    pub(crate) fn log_size_slope(&self) -> Option<DVector<f64>> {
        let layout = self.layout();
        let positions = || self.frames.iter().map(|f| f.state.world_from_body.translation.vector);
        let mean = positions().sum::<Vector3<f64>>() / self.frames.len().max(1) as f64;
        let spread: f64 = positions().map(|p| (p - mean).norm_squared()).sum();
        (spread > 0.0).then(|| {
            let mut slope = DVector::zeros(layout.dim());
            for (frame, position) in positions().enumerate() {
                let at = layout.state(frame, POSITION);
                slope.fixed_rows_mut::<3>(at).copy_from(&((position - mean) / spread));
            }
            slope
        })
    }

    /// Relative standard deviation of the scale, as the window believes it; `None` where it does not know.
    pub(crate) fn scale_std(&mut self) -> Option<f64> {
        let mut slope = self.log_size_slope()?;
        if !self.factor_information() {
            return None;
        }
        // |L^-1 slope|^2 = slope^T (L L^T)^-1 slope
        let first_pose = self.layout().pose(0);
        self.factor.solve_lower(slope.as_mut_slice(), first_pose);
        Some(slope.norm()).filter(|std| std.is_finite())
    }
}
