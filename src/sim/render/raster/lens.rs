//! The lines of sight of a camera's pixels, in square tiles.

use super::uncalibrated::Uncalibrated;
use dpn_core::camera::{self, CameraModel};
use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

/// Side of a tile \[px\].
pub(crate) const TILE: usize = 16;

/// Pixels of a tile, and of everything that is worked on at a time.
pub(crate) const BATCH: usize = TILE * TILE;

/// Tiles a side that are looked at together first.
const BLOCK: usize = 8;

/// Halvings of the way to a fish-eye's edge: a fifth of a pixel of a large image.
const HALVINGS: u32 = 13;

/// A pixel whose line of sight the lens model does not know.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the lens model has no line of sight for pixel ({u}, {v}): its distortion folds back inside the image; check the coefficients"
)]
pub struct NoLineOfSight {
    /// Column \[px\].
    pub u: f64,
    /// Row \[px\].
    pub v: f64,
}

/// Lines of sight as (x, y, 1) in the camera's frame.
pub(crate) type Lines = [f32; BATCH];

/// The smallest box around some lines of sight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cone {
    pub(crate) x: [f32; 2],
    pub(crate) y: [f32; 2],
}

/// A square of pixels.
#[derive(Debug, Clone)]
pub(crate) struct Tile {
    pub(crate) x: Lines,
    pub(crate) y: Lines,
    /// d(x, y) / d(u, v) at its centre, a row each \[1/px\].
    pub(crate) per_px: [[f32; 2]; 2],
    /// Holds every point of its pixels, and a pixel more on each side.
    pub(crate) cone: Cone,
}

/// All lines of sight of a camera, or of a coarser one: every `step`-th pixel of it, each as wide as `step`.
#[derive(Debug, Clone)]
pub(crate) struct Lens {
    /// Pixels in a row and in a column.
    pub(crate) size: [usize; 2],
    /// Tiles in a row and in a column.
    pub(crate) tiles_across: [usize; 2],
    /// Row after row. Where the image ends inside a tile, its border's lines are repeated.
    pub(crate) tiles: Vec<Tile>,
    /// Groups of neighbouring tiles: their cone and their places.
    pub(crate) blocks: Vec<(Cone, Vec<usize>)>,
}

impl Lens {
    /// The lines of sight of every `step`-th pixel of `camera`, which is calibrated but for `unknown`.
    ///
    /// # Errors
    /// A pixel without one.
    pub(crate) fn new(
        camera: &CameraModel,
        unknown: &Uncalibrated,
        step: usize,
    ) -> Result<Self, NoLineOfSight> {
        let full = camera.size().map(|side| side as usize);
        let size = full.map(|side| (side / step).max(1));
        let tiles_across = size.map(|side| side.div_ceil(TILE));
        let mut tiles = Vec::with_capacity(tiles_across[0] * tiles_across[1]);
        for row in 0..tiles_across[1] {
            for column in 0..tiles_across[0] {
                tiles.push(tile(camera, unknown, step, [column * TILE, row * TILE], size)?);
            }
        }
        let mut blocks = Vec::new();
        for top in (0..tiles_across[1]).step_by(BLOCK) {
            for left in (0..tiles_across[0]).step_by(BLOCK) {
                let rows = top..(top + BLOCK).min(tiles_across[1]);
                let columns = left..(left + BLOCK).min(tiles_across[0]);
                let places: Vec<usize> =
                    rows.flat_map(|row| columns.clone().map(move |c| row * tiles_across[0] + c)).collect();
                blocks.push((around(places.iter().map(|place| tiles[*place].cone)), places));
            }
        }
        Ok(Self { size, tiles_across, tiles, blocks })
    }
}

/// Centre of coarse pixel `index` in pixels of the camera.
fn centre(index: usize, step: usize) -> f64 {
    (index * step) as f64 + 0.5 * (step as f64 - 1.0)
}

fn tile(
    camera: &CameraModel,
    unknown: &Uncalibrated,
    step: usize,
    [left, top]: [usize; 2],
    size: [usize; 2],
) -> Result<Tile, NoLineOfSight> {
    let sight =
        |u: f64, v: f64| sight(camera, &unknown.calibrated(Vector2::new(u, v))).ok_or(NoLineOfSight { u, v });
    let (mut x, mut y) = ([0.0; BATCH], [0.0; BATCH]);
    for i in 0..BATCH {
        let column = (left + i % TILE).min(size[0] - 1);
        let row = (top + i / TILE).min(size[1] - 1);
        let n = sight(centre(column, step), centre(row, step))?;
        (x[i], y[i]) = (n.x as f32, n.y as f32);
    }
    let middle = |first: usize, side: usize| centre((first + TILE / 2).min(side - 1), step);
    let (u, v) = (middle(left, size[0]), middle(top, size[1]));
    let per_px = jacobian(camera, &sight(u, v)?).ok_or(NoLineOfSight { u, v })? * step as f64;
    // A fish-eye's lines spread within a tile: its corners say by how much.
    let mut most = per_px.abs();
    if !camera.sees_all() {
        let edges =
            |first: usize, side: usize| [first, first + TILE - 1].map(|i| centre(i.min(side - 1), step));
        for u in edges(left, size[0]) {
            for v in edges(top, size[1]) {
                most = most.sup(
                    &(jacobian(camera, &sight(u, v)?).ok_or(NoLineOfSight { u, v })? * step as f64).abs(),
                );
            }
        }
    }
    let range = |values: &Lines, row: usize| {
        let reach = 1.2 * (most[(row, 0)] + most[(row, 1)]) as f32;
        let low = values.iter().copied().fold(f32::MAX, f32::min);
        let high = values.iter().copied().fold(f32::MIN, f32::max);
        [low - reach, high + reach]
    };
    let cone = Cone { x: range(&x, 0), y: range(&y, 1) };
    let per_px = [0, 1].map(|row| [0, 1].map(|column| per_px[(row, column)] as f32));
    Ok(Tile { x, y, per_px, cone })
}

/// What a pixel sees. Outside a fish-eye's circle it is what the circle's edge sees, and dark (`sensor`).
fn sight(camera: &CameraModel, px: &Vector2<f64>) -> Option<Vector2<f64>> {
    let seen = camera.normalise(px);
    if seen.is_some() || matches!(camera.lens(), camera::Lens::Radtan(_)) {
        return seen;
    }
    let towards = |share: f64| camera.principal() + share * (px - camera.principal());
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        if camera.normalise(&towards(middle)).is_some() { inside = middle } else { outside = middle }
    }
    camera.normalise(&towards(inside))
}

/// d(x, y) / d(u, v) at normalised coordinates.
fn jacobian(camera: &CameraModel, normalised: &Vector2<f64>) -> Option<Matrix2<f64>> {
    let (_, by_point) = camera.project_with_jacobian(&normalised.push(1.0))?;
    by_point.fixed_columns::<2>(0).into_owned().try_inverse()
}

fn around(cones: impl Iterator<Item = Cone>) -> Cone {
    let nothing = [f32::MAX, f32::MIN];
    let wider = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    cones.fold(Cone { x: nothing, y: nothing }, |all, cone| Cone {
        x: wider(all.x, cone.x),
        y: wider(all.y, cone.y),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    fn none() -> Uncalibrated {
        Uncalibrated::new(0.0, 752, &Stream::new(0))
    }

    #[test]
    fn every_pixel_has_its_line_and_tiles_hold_what_they_see() {
        let camera =
            CameraModel::radtan([50, 37], [40.0, 41.0, 24.0, 19.0], [-0.2, 0.03, 1e-3, 0.0, 0.0]).unwrap();
        let lens = Lens::new(&camera, &none(), 1).unwrap();
        assert_eq!((lens.size, lens.tiles_across, lens.tiles.len()), ([50, 37], [4, 3], 12));
        for (place, tile) in lens.tiles.iter().enumerate() {
            let corner = [place % 4 * TILE, place / 4 * TILE];
            for i in (0..BATCH).step_by(7) {
                let (u, v) = ((corner[0] + i % TILE).min(49) as f64, (corner[1] + i / TILE).min(36) as f64);
                let px = camera
                    .project(&Vector2::new(f64::from(tile.x[i]), f64::from(tile.y[i])).push(1.0))
                    .unwrap();
                assert!((px - Vector2::new(u, v)).norm() < 1e-4, "{px} {u} {v}");
                // A pixel aside, by the tile's own derivative, is the neighbour's line to a few hundredths of a pixel.
                let [[a, b], [c, d]] = tile.per_px.map(|row| row.map(f64::from));
                let aside = Vector2::new(
                    f64::from(tile.x[i]) + 0.5 * a + 0.5 * b,
                    f64::from(tile.y[i]) + 0.5 * (c + d),
                );
                assert!(
                    (camera.project(&aside.push(1.0)).unwrap() - Vector2::new(u + 0.5, v + 0.5)).norm() < 0.2
                );
                assert!((tile.cone.x[0]..=tile.cone.x[1]).contains(&(aside.x as f32)));
                assert!((tile.cone.y[0]..=tile.cone.y[1]).contains(&(aside.y as f32)));
            }
        }
        let all: usize = lens.blocks.iter().map(|(_, places)| places.len()).sum();
        assert_eq!(all, 12);
    }

    #[test]
    fn a_coarse_lens_looks_at_the_middle_of_its_wide_pixels() {
        let camera = CameraModel::euroc_cam0();
        let lens = Lens::new(&camera, &none(), 16).unwrap();
        assert_eq!(lens.size, [47, 30]);
        let tile = &lens.tiles[0];
        let px =
            camera.project(&Vector2::new(f64::from(tile.x[17]), f64::from(tile.y[17])).push(1.0)).unwrap();
        assert!((px - Vector2::new(23.5, 23.5)).norm() < 1e-3, "{px}");
        let fine = Lens::new(&camera, &none(), 1).unwrap();
        // The middle of the fine one's tile (10, 8) is within that of the coarse one's first tile, whose pixels are wider.
        let ratio = lens.tiles[0].per_px[0][0] / fine.tiles[8 * 47 + 8].per_px[0][0];
        assert!((ratio / 16.0 - 1.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    fn a_fish_eyes_pixels_see_what_they_should_and_its_corners_what_its_edge_does() {
        let camera = CameraModel::tumvi_cam0();
        let lens = Lens::new(&camera, &none(), 1).unwrap();
        let mut outside = 0;
        for (place, tile) in lens.tiles.iter().enumerate() {
            let corner = [place % 32 * TILE, place / 32 * TILE];
            for i in 0..BATCH {
                let px = Vector2::new((corner[0] + i % TILE) as f64, (corner[1] + i / TILE) as f64);
                let line = Vector2::new(f64::from(tile.x[i]), f64::from(tile.y[i]));
                assert!((tile.cone.x[0]..=tile.cone.x[1]).contains(&tile.x[i]));
                match camera.normalise(&px) {
                    Some(_) => assert!((camera.project(&line.push(1.0)).unwrap() - px).norm() < 1e-3),
                    None => {
                        outside += 1;
                        assert!((line.norm().atan() - 80_f64.to_radians()).abs() < 2e-3, "{line}");
                    }
                }
            }
        }
        assert!((20_000..60_000).contains(&outside), "{outside}");
    }

    #[test]
    fn a_lens_that_folds_back_inside_the_image_is_refused() {
        let folding =
            CameraModel::radtan([752, 480], [200.0, 200.0, 376.0, 240.0], [-0.9, 0.0, 0.0, 0.0, 0.0])
                .unwrap();
        let error = Lens::new(&folding, &none(), 1).unwrap_err();
        assert!(error.to_string().starts_with("the lens model has no line of sight for pixel ("), "{error}");
    }
}
