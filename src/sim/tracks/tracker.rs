//! The tracker: which points it follows, and how wrong it is about them.
//!
//! At every camera frame a track that is still seen ends with probability period / life time, or when its point moved too far; else it
//! may turn into an outlier, an outlier may end, and its error grows by a step: a draw of the drift, or the outlier's slide. What is handed
//! over is truth + error so far + white noise, in hundredths of a pixel.
//!
//! Every track has a generator of its own and draws the same numbers from it at every frame, whatever they are used for. So the noise of
//! a track does not depend on any other, nor on how large drift and noise are.

use super::config::TracksConfig;
use super::sight::Sight;
use dpn_core::random::{Stream, StreamRng};
use dpn_core::{Stamp, Track, TrackFrame};
use nalgebra::Vector2;
use rand::{Rng, RngCore};
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// One point that is followed.
struct Live {
    id: u64,
    point: u32,
    /// True pixel in the last frame.
    px: Vector2<f64>,
    /// Error that stays: drift and slide so far \[px\].
    error: Vector2<f64>,
    /// An outlier's step a frame \[px\].
    slide: Option<Vector2<f64>>,
    /// This frame's white noise, of deviation 1.
    white: Vector2<f64>,
    rng: StreamRng,
}

/// What a track draws at every frame.
struct Draws {
    end: f64,
    outlier: f64,
    direction: f64,
    outlier_end: f64,
    drift: Vector2<f64>,
    white: Vector2<f64>,
}

impl Draws {
    fn new(rng: &mut StreamRng) -> Self {
        let [end, outlier, direction, outlier_end] = std::array::from_fn(|_| rng.random());
        let mut normal = || Vector2::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
        Self { end, outlier, direction, outlier_end, drift: normal(), white: normal() }
    }
}

/// The points followed, in the order of their birth.
pub(super) struct Tracker<'a> {
    config: &'a TracksConfig,
    /// Chance that a track ends for no reason at a frame.
    end_chance: f64,
    stream: Stream,
    live: Vec<Live>,
    followed: Vec<bool>,
    next_id: u64,
    grid: Grid,
    /// Room for the draws of a frame's births.
    order: Vec<u64>,
    bytes: Vec<u8>,
}

impl<'a> Tracker<'a> {
    /// For a camera with `period_s` between its frames and a world of `points`.
    pub(super) fn new(config: &'a TracksConfig, period_s: f64, points: usize, stream: &Stream) -> Self {
        Self {
            config,
            end_chance: period_s / config.life_time_s,
            stream: stream.clone(),
            live: Vec::new(),
            followed: vec![false; points],
            next_id: 0,
            grid: Grid::new(config.spacing_px),
            order: Vec::new(),
            bytes: vec![0; 4 * points],
        }
    }

    /// Ends every track.
    pub(super) fn lose_all(&mut self) {
        for track in self.live.drain(..) {
            self.followed[track.point as usize] = false;
        }
    }

    /// Follows the tracks into the next frame.
    pub(super) fn follow(&mut self, sight: &Sight<'_>) {
        let (config, end_chance, followed) = (self.config, self.end_chance, &mut self.followed);
        let model = sight.model();
        self.live.retain_mut(|track| {
            let stays = track.follow(config, end_chance, sight.px(track.point))
                && model.contains(&(track.px + track.error), 0.0);
            followed[track.point as usize] = stays;
            stays
        });
    }

    /// Begins new tracks at `t` until there are as many as there may be, spaced in the image, in an order drawn for this frame.
    pub(super) fn replenish(&mut self, t: Stamp, sight: &Sight<'_>) {
        let most = self.config.max_tracks;
        if self.live.len() >= most {
            return;
        }
        self.grid.clear(sight.model().size());
        for track in &self.live {
            self.grid.put(track.px);
        }
        // One draw for every point of the world, seen or not: what one frame sees moves no draw of another point.
        self.stream.named("births").index(t.ns() as u64).rng().fill_bytes(&mut self.bytes);
        let draw = |point: u32| {
            let at = 4 * point as usize;
            let bytes = [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2], self.bytes[at + 3]];
            u64::from(u32::from_le_bytes(bytes))
        };
        self.order.clear();
        let free =
            sight.seen().iter().map(|(point, _)| *point).filter(|point| !self.followed[*point as usize]);
        self.order.extend(free.map(|point| draw(point) << 32 | u64::from(point)));
        self.order.sort_unstable();
        for key in &self.order {
            if self.live.len() >= most {
                break;
            }
            let point = *key as u32;
            let Some(px) = sight.px(point).filter(|px| self.grid.is_free(px)) else {
                continue;
            };
            let mut rng = self.stream.named("track").index(u64::from(point)).index(t.ns() as u64).rng();
            let white = Draws::new(&mut rng).white;
            let (id, error, slide) = (self.next_id, Vector2::zeros(), None);
            self.live.push(Live { id, point, px, error, slide, white, rng });
            self.grid.put(px);
            self.followed[point as usize] = true;
            self.next_id += 1;
        }
    }

    /// The tracks as the tracker says they are.
    pub(super) fn hand_over(&self, t: Stamp) -> TrackFrame {
        let noise = self.config.pixel_noise_px;
        let tracks = self.live.iter().map(|track| {
            let px = track.px + track.error + noise * track.white;
            Track { id: track.id, px: px.map(|v| (100.0 * v).round() / 100.0) }
        });
        TrackFrame::new(t, tracks.collect())
    }
}

impl Live {
    /// Moves it into the next frame, in which its point is at `px`; `false` when it ends.
    fn follow(&mut self, config: &TracksConfig, end_chance: f64, px: Option<Vector2<f64>>) -> bool {
        let draws = Draws::new(&mut self.rng);
        let Some(px) = px else {
            return false;
        };
        if draws.end < end_chance || (px - self.px).norm() > config.largest_motion_px {
            return false;
        }
        match self.slide {
            Some(_) if draws.outlier_end < config.outlier_end_share => return false,
            None if draws.outlier < config.outlier_share => {
                let (sin, cos) = (TAU * draws.direction).sin_cos();
                self.slide = Some(config.outlier_slide_px * Vector2::new(cos, sin));
            }
            _ => {}
        }
        self.error += self.slide.unwrap_or(config.drift_px * draws.drift);
        self.px = px;
        self.white = draws.white;
        true
    }
}

/// Pixels taken, in square cells as wide as the spacing: who is too near stands in one of nine.
struct Grid {
    spacing: f64,
    cell: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<Vector2<f64>>>,
}

impl Grid {
    /// The smallest cell \[px\], so that a small spacing makes no huge grid.
    const SMALLEST: f64 = 8.0;

    fn new(spacing: f64) -> Self {
        Self { spacing, cell: spacing.max(Self::SMALLEST), columns: 0, rows: 0, cells: Vec::new() }
    }

    fn clear(&mut self, size: [u32; 2]) {
        let [columns, rows] = size.map(|size| (f64::from(size) / self.cell) as usize + 1);
        (self.columns, self.rows) = (columns, rows);
        self.cells.resize_with(columns * rows, Vec::new);
        self.cells.iter_mut().for_each(Vec::clear);
    }

    /// Column and row of a pixel of the image.
    fn at(&self, px: &Vector2<f64>) -> (usize, usize) {
        let index = |v: f64, most: usize| ((v / self.cell).max(0.0) as usize).min(most - 1);
        (index(px.x, self.columns), index(px.y, self.rows))
    }

    fn put(&mut self, px: Vector2<f64>) {
        let (column, row) = self.at(&px);
        self.cells[row * self.columns + column].push(px);
    }

    fn is_free(&self, px: &Vector2<f64>) -> bool {
        let (column, row) = self.at(px);
        let near = self.spacing * self.spacing;
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        (row.saturating_sub(1)..(row + 2).min(self.rows)).all(|row| {
            let cells = &self.cells[row * self.columns + columns.start..row * self.columns + columns.end];
            cells.iter().flatten().all(|taken| (taken - px).norm_squared() >= near)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_grid_agrees_with_looking_at_every_pixel(
            taken in prop::collection::vec((0.0..752.0f64, 0.0..480.0f64), 0..40),
            u in 0.0..752.0f64, v in 0.0..480.0f64, spacing in 0.0..60.0f64,
        ) {
            let mut grid = Grid::new(spacing);
            grid.clear([752, 480]);
            let px = Vector2::new(u, v);
            taken.iter().for_each(|(u, v)| grid.put(Vector2::new(*u, *v)));
            let free = taken.iter().all(|(u, v)| (Vector2::new(*u, *v) - px).norm_squared() >= spacing * spacing);
            prop_assert_eq!(grid.is_free(&px), free);
        }
    }
}
