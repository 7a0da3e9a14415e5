//! What a linearisation keeps of landmarks: the geometry they are linearised with, and how their depths follow the states.

use super::frame::Estimates;
use crate::factors::reprojection::{PairGeometry, Projected};

/// What is kept of the landmarks that were taken out: enough to find their depths' steps afterwards.
#[derive(Debug, Clone, Default)]
pub(super) struct Depths {
    pub(super) rows: Vec<DepthRow>,
    /// The rows of `L^-1 W`, three for each landmark.
    pub(super) w: Vec<f64>,
    /// One landmark's sightings but the host's while it is worked on: which, its point in the target's camera, the root of its weight.
    pub(super) projected: Vec<(usize, Projected, f64)>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct DepthRow {
    pub(super) landmark: usize,
    /// `L^-1 g` of the depth, and its pivot.
    pub(super) g: f64,
    pub(super) pivot: f64,
    /// Where the depth's row of `L^-1 W` begins in [`Depths::w`].
    pub(super) start: usize,
    /// The states it is about.
    pub(super) at: usize,
    pub(super) width: usize,
}

impl Depths {
    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.w.clear();
    }

    /// Twice what the depths alone would lower the cost by, were the states held.
    pub(super) fn gain(&self) -> f64 {
        self.rows.iter().map(|row| row.g * row.g).sum()
    }

    /// Each landmark's step after the states' step `d`.
    pub(super) fn steps<'a>(&'a self, d: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.rows.iter().map(|row| {
            let w = &self.w[row.start..row.start + row.width];
            let sum: f64 = w.iter().zip(&d[row.at..]).map(|(w, d)| w * d).sum();
            (row.landmark, -(row.g + sum) / row.pivot)
        })
    }
}

/// Geometry of pairs of frames, host times frames plus target.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    pub(super) frames: usize,
    pub(super) geometry: Vec<Option<PairGeometry>>,
}

impl Pairs {
    /// Of all pairs whose host is one of the first `hosts` frames.
    pub(super) fn of(&mut self, now: Estimates<'_>, hosts: usize) {
        let n = now.frames.len();
        self.frames = n;
        self.geometry.clear();
        self.geometry.resize(n * n, None);
        for target in 1..n {
            for host in 0..target.min(hosts) {
                self.geometry[host * n + target] =
                    Some(now.frames[host].seen_with(&now.frames[target], now.body_from_cam));
            }
        }
    }
}
