//! How far tracks moved between two frames beyond what rotation alone explains.

use super::window::Window;

/// Parallax between two frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Parallax {
    /// Tracks seen by both.
    pub common: usize,
    /// Mean angle between the rays once the rotation between the frames is undone \[rad\].
    pub mean: f64,
}

impl Window {
    /// Parallax from `from` to `to`, the rotation between them undone by the window's own estimate of it.
    pub(crate) fn parallax(&self, from: usize, to: usize) -> Parallax {
        let rotation = |f: usize| self.frames[f].state.world_from_body.rotation * self.body_from_cam.rotation;
        let to_from_from = rotation(to).inverse() * rotation(from);
        let (mut sum, mut common) = (0.0, 0);
        for landmark in &self.landmarks {
            let seen = |f: usize| landmark.sightings.iter().find(|(frame, _)| *frame == f).map(|(_, s)| s);
            let (Some(a), Some(b)) = (seen(from), seen(to)) else { continue };
            sum += (to_from_from * a.bearing).cross(&b.bearing).norm().min(1.0).asin();
            common += 1;
        }
        Parallax { common, mean: if common == 0 { 0.0 } else { sum / common as f64 } }
    }
}
