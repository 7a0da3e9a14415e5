//! A jump of the biases inside one interval of the window: what says that there was one, and the windows that allow for it or do without it.
//!
//! # Score
//! A bias that changes by `d` in the middle of an interval of residual `r`, covariance `Q` and bias Jacobian `J` moves its rows by
//! `-(J/2; I) d`. What the window's cost gains by it at first order is
//! ```text
//! u = -(J/2; I)^T Q^-1 r
//! ```
//! At the solution this is all that the later frames say against the bias that the earlier ones tell: the walk's own rows hold the two together.
//!
//! # Trial
//! Whether there was one is asked of the whole window, solved anew with the walks of the interval raised by a jump's variance. An interval that is wrong for another
//! reason, after a blow or where the truth has a kink, is explained by that too: within it the bias may have been anything. So the window
//! that does not believe this interval and the next is held against it; what a jump explains better, it explains in the intervals that follow.

use super::window::Window;
use crate::factors::inertial::{inertial_residual, sqrt_information};
use crate::preint::Preintegration;
use crate::state::{ACCEL_BIAS, ImuBias};
use nalgebra::SVector;

/// The white noise of an interval that is not believed, as a factor on its deviation.
const DISBELIEVED: f64 = 100.0;
/// A sighting is off by at most so many variances when its frames are judged: what is farther off is another point.
const CLIP: f64 = 9.0;

impl Window {
    /// Derivative of the cost by a jump of the biases in the interval that ends at frame `j`, in the order accelerometer, gyro; `None` where there is
    /// no interval that could be weighed.
    pub(crate) fn jump_score(&self, j: usize) -> Option<SVector<f64, 6>> {
        let frame = self.frames.get(j)?;
        let preint = frame.preint.as_ref()?;
        let root = sqrt_information(preint)?;
        let residual = inertial_residual(preint, &self.frames[j - 1].state, &frame.state);
        let weighed = root.tr_mul(&(root * residual));
        let motion = weighed.fixed_rows::<9>(0);
        Some(-(0.5 * preint.jacobian().tr_mul(&motion) + weighed.fixed_rows::<6>(ACCEL_BIAS)))
    }

    /// The window solved with a jump of deviation `std` an axis, accelerometer \[m/s^2\] and gyro \[rad/s\], in the interval that ends at frame `j`, and
    /// its cost.
    pub(crate) fn with_jump(&self, j: usize, std: [f64; 2]) -> Option<(Self, f64)> {
        let mut window = self.clone();
        window.interval_mut(j)?.set_jump(std);
        let cost = window.optimise().last_cost;
        Some((window, cost))
    }

    /// The cost of the window solved without a jump in the interval that ends at frame `j`, the motion there and in the next not believed; `None`
    /// where nothing comes after.
    pub(crate) fn cost_disbelieving(&self, j: usize) -> Option<f64> {
        let mut window = self.clone();
        window.interval_mut(j)?.set_jump([0.0; 2]);
        for k in [j, j + 1] {
            let preint = window.interval_mut(k)?;
            let mut levels = *preint.levels();
            levels.0[..6].iter_mut().for_each(|level| *level *= DISBELIEVED);
            preint.set_levels(levels);
        }
        Some(window.optimise().last_cost)
    }

    fn interval_mut(&mut self, j: usize) -> Option<&mut Preintegration> {
        self.frames.get_mut(j)?.preint.as_mut()
    }

    /// By how much the biases changed over the interval that ends at frame `j`.
    pub(crate) fn bias_change(&self, j: usize) -> ImuBias {
        let (before, after) = (&self.frames[j - 1].state.bias, &self.frames[j].state.bias);
        ImuBias { accel: after.accel - before.accel, gyro: after.gyro - before.gyro }
    }

    /// Integrates the intervals after frame `j` with the biases that their first frames have now.
    pub(crate) fn reintegrate_after(&mut self, j: usize) {
        for k in j + 1..self.frames.len() {
            let bias = self.frames[k - 1].state.bias;
            if let Some(preint) = self.interval_mut(k) {
                preint.reintegrate(bias);
            }
        }
    }

    /// How many landmarks the images follow through the window at the place where they follow least: the fewest that are seen both before and after any
    /// interval. Where all are lost, inertial motion alone ties the frames before to those after.
    pub(crate) fn least_followed(&self) -> usize {
        let mut through = vec![0_usize; self.frames.len().saturating_sub(1)];
        for landmark in self.landmarks.iter().filter(|landmark| landmark.inverse_depth.is_some()) {
            let last = landmark.sightings.last().map_or(landmark.host(), |(frame, _)| *frame);
            through[landmark.host()..last].iter_mut().for_each(|count| *count += 1);
        }
        through.into_iter().min().unwrap_or(0)
    }

    /// Mean square of the whitened motion of all intervals but the one that ends at frame `j`; `None` where there is none.
    pub(crate) fn mean_inertial_square(&self, j: usize) -> Option<f64> {
        let (mut sum, mut rows) = (0.0, 0);
        for (k, pair) in self.frames.windows(2).enumerate().filter(|(k, _)| k + 1 != j) {
            let Some(preint) = &self.frames[k + 1].preint else { continue };
            let Some(root) = sqrt_information(preint) else { continue };
            let whitened = root * inertial_residual(preint, &pair[0].state, &pair[1].state);
            sum += whitened.fixed_rows::<9>(0).norm_squared();
            rows += 9;
        }
        (rows > 0).then(|| sum / f64::from(rows))
    }

    /// Mean square of what sightings in the frames from `j` on are off their landmarks, an axis \[variances of a pixel\], each at most nine; `None` where
    /// there is none.
    pub(crate) fn mean_visual_square(&self, j: usize) -> Option<f64> {
        let (mut sum, mut rows) = (0.0, 0);
        for landmark in &self.landmarks {
            let Some(inverse_depth) = landmark.inverse_depth.filter(|_| landmark.sightings.len() > 2) else {
                continue;
            };
            let host = self.sighting_at_offset(landmark.host_sighting());
            for (frame, seen) in landmark.sightings[1..].iter().filter(|(frame, _)| *frame >= j) {
                let geometry = self.geometry(landmark.host(), *frame);
                let residual = geometry.residual(&host, &self.sighting_at_offset(seen), inverse_depth);
                sum += (0.5 * residual.norm_squared()).min(CLIP);
                rows += 1;
            }
        }
        (rows > 0).then(|| sum / f64::from(rows))
    }
}
