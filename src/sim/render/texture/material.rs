//! What surfaces are covered with, painted from random streams.
//!
//! Sizes are in texels: of 4 mm in a room, 8 mm in a hall.

use super::canvas::{Canvas, SIDE};
use rand::Rng;
use std::f32::consts::{PI, TAU};

/// A kind of surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Material {
    /// Mattresses and curtains: weave and folds, little contrast.
    Cloth,
    /// A floor's grain and stains.
    Carpet,
    /// Things upon things, of every size: shelves, machines, posters.
    Clutter,
    /// White chips on black.
    Chips,
    /// Masonry.
    Blocks,
    /// A printed sheet: roads, dots, letters, a chequered patch.
    Print,
    /// Boards.
    Planks,
    /// Nothing but light: windows and lamps.
    Plain,
    /// A board's grain and knots.
    Grain,
    /// A net of cords over something bright.
    Net,
    /// A grating: the same dark holes over and over.
    Grating,
}

impl Material {
    /// Every kind, in the order of their textures.
    pub(crate) const ALL: [Self; 11] = [
        Self::Cloth,
        Self::Carpet,
        Self::Clutter,
        Self::Chips,
        Self::Blocks,
        Self::Print,
        Self::Planks,
        Self::Plain,
        Self::Grain,
        Self::Net,
        Self::Grating,
    ];

    /// Its grey values.
    pub(super) fn paint(self, rng: &mut impl Rng) -> Vec<f32> {
        let mut canvas = match self {
            Self::Cloth => cloth(rng),
            Self::Carpet => carpet(rng),
            Self::Clutter => clutter(rng),
            Self::Chips => chips(rng),
            Self::Blocks => blocks(rng),
            Self::Print => print(rng),
            Self::Planks => planks(rng),
            Self::Plain => Canvas::new(128.0),
            Self::Grain => grain(rng),
            Self::Net => net(rng),
            Self::Grating => grating(rng),
        };
        canvas.soften();
        canvas.grey
    }
}

fn place(rng: &mut impl Rng) -> [f32; 2] {
    [rng.random::<f32>() * SIDE as f32, rng.random::<f32>() * SIDE as f32]
}

/// A size between `low` and `high` of which small ones are many: as many between r and 2 r fall as 1/r^2, so that all sizes cover
/// areas alike, as things in pictures do.
fn size(low: f32, high: f32, rng: &mut impl Rng) -> f32 {
    let (a, b) = (low.powi(-2), high.powi(-2));
    (a + (b - a) * rng.random::<f32>()).powf(-0.5)
}

fn cloth(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(128.0);
    canvas.noise(3, 3, 7.0, rng);
    // Folds run across.
    canvas.noise(5, 28, 8.0, rng);
    canvas.noise(11, 70, 5.0, rng);
    canvas.noise(40, 160, 2.5, rng);
    canvas.noise(256, 256, 2.5, rng);
    canvas.noise(512, 340, 4.0, rng);
    canvas.noise(340, 512, 4.0, rng);
    // Seams.
    for at in [0.13, 0.62] {
        let y = at * SIDE as f32;
        canvas.rectangle([SIDE as f32 / 4.0, y], [SIDE as f32 / 4.0, 1.5], 0.0, 95.0);
        canvas.rectangle([0.75 * SIDE as f32, y], [SIDE as f32 / 4.0, 1.5], 0.0, 95.0);
    }
    canvas
}

fn carpet(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(128.0);
    canvas.octaves(4, 16, 4.0, 0.8, rng);
    canvas.octaves(64, 512, 2.4, 1.35, rng);
    for _ in 0..60 {
        let (at, r) = (place(rng), size(3.0, 25.0, rng));
        let half = [r, r * (0.3 + 0.7 * rng.random::<f32>())];
        let (turn, darker) = (PI * rng.random::<f32>(), rng.random_range(-22.0..9.0_f32));
        let (sin, cos) = turn.sin_cos();
        let inside = |dx: f32, dy: f32| {
            let (a, b) = ((cos * dx + sin * dy) / half[0], (cos * dy - sin * dx) / half[1]);
            a * a + b * b <= 1.0
        };
        canvas.shape(at, r, inside, |grey| grey + darker);
    }
    canvas
}

fn clutter(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(110.0);
    for _ in 0..2600 {
        let (at, r) = (place(rng), size(8.0, 190.0, rng));
        let grey = 60.0 + 125.0 * rng.random::<f32>();
        let shape = rng.random::<f32>();
        let slim = 0.15 + 0.85 * rng.random::<f32>();
        // Most things stand upright.
        let turn = if rng.random::<f32>() < 0.7 {
            0.5 * PI * f32::from(rng.random_range(0..2_u8))
        } else {
            TAU * rng.random::<f32>()
        };
        if shape < 0.7 {
            canvas.rectangle(at, [r, r * slim], turn, grey);
        } else {
            canvas.ellipse(at, [r, r * slim], turn, (shape > 0.9).then_some(0.4), grey);
        }
    }
    canvas.octaves(16, 512, 3.0, 1.0, rng);
    canvas
}

fn chips(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(22.0);
    // One chip in most cells of a grid, so that they neither heap up nor leave holes.
    const CELL: f32 = 32.0;
    let cells = (SIDE as f32 / CELL) as usize;
    for row in 0..cells {
        for column in 0..cells {
            let mut jitter = || 0.5 + 0.7 * (rng.random::<f32>() - 0.5);
            let at = [(column as f32 + jitter()) * CELL, (row as f32 + jitter()) * CELL];
            let corners = std::array::from_fn(|_| 3.0 + 9.0 * rng.random::<f32>());
            let (turn, grey) = (TAU * rng.random::<f32>(), rng.random_range(190.0..255.0_f32));
            if rng.random::<f32>() < 0.8 {
                canvas.chip(at, corners, turn, grey);
            }
        }
    }
    canvas.octaves(64, 512, 2.0, 1.0, rng);
    canvas
}

fn blocks(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(103.0);
    let (width, height) = (64.0, 32.0);
    for row in 0..32_u8 {
        for column in 0..16_u8 {
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 * width };
            let at = [(f32::from(column) + 0.5) * width + shift, (f32::from(row) + 0.5) * height];
            let grey = 128.0 + 18.0 * (rng.random::<f32>() - 0.5) * 2.0;
            let mut less = || 1.5 + 1.2 * rng.random::<f32>();
            canvas.rectangle(at, [0.5 * width - less(), 0.5 * height - less()], 0.0, grey);
        }
    }
    canvas.octaves(4, 16, 4.0, 0.8, rng);
    canvas.octaves(64, 512, 3.0, 1.1, rng);
    canvas
}

fn print(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(175.0);
    for _ in 0..34 {
        let (at, r) = (place(rng), rng.random_range(40.0..140.0_f32));
        let half = [r, r * (0.5 + 0.5 * rng.random::<f32>())];
        let turn = PI * rng.random::<f32>();
        canvas.ellipse(at, half, turn, None, rng.random_range(90.0..150.0_f32));
    }
    // Roads, with a line along them.
    for _ in 0..16 {
        let (at, r) = (place(rng), rng.random_range(60.0..200.0_f32));
        let width = rng.random_range(14.0..26.0_f32) / r;
        let (half, turn) = ([r, r * (0.6 + 0.4 * rng.random::<f32>())], PI * rng.random::<f32>());
        canvas.ellipse(at, half, turn, Some(width), 215.0);
        let middle = [half[0] * (1.0 - 0.45 * width), half[1] * (1.0 - 0.45 * width)];
        canvas.ellipse(at, middle, turn, Some(0.1 * width), 90.0);
    }
    // Letters: a few strokes within a small field.
    for _ in 0..420 {
        let [x, y] = place(rng);
        let (r, grey) = (rng.random_range(5.0..12.0_f32), rng.random_range(15.0..60.0_f32));
        for _ in 0..rng.random_range(2..5_u8) {
            let mut off = || r * (rng.random::<f32>() - 0.5) * 1.4;
            let at = [x + off(), y + off()];
            let turn = 0.25 * PI * f32::from(rng.random_range(0..4_u8));
            canvas.rectangle(at, [r * 0.7, 1.2 + 0.1 * r], turn, grey);
        }
    }
    for _ in 0..16 {
        let [x, y] = place(rng);
        let side = rng.random_range(9.0..17.0_f32);
        for row in 0..9_u8 {
            for column in 0..7_u8 {
                let grey = if (row + column) % 2 == 0 { 12.0 } else { 245.0 };
                let at = [x + f32::from(column) * side, y + f32::from(row) * side];
                canvas.rectangle(at, [0.5 * side, 0.5 * side], 0.0, grey);
            }
        }
    }
    canvas.octaves(64, 512, 2.0, 1.0, rng);
    canvas
}

fn grain(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(128.0);
    canvas.noise(2, 9, 8.0, rng);
    canvas.noise(3, 60, 6.0, rng);
    canvas.noise(9, 256, 5.0, rng);
    canvas.octaves(128, 512, 2.0, 1.0, rng);
    for _ in 0..14 {
        let (at, r) = (place(rng), size(6.0, 24.0, rng));
        canvas.ellipse(at, [1.7 * r, r], 0.0, None, rng.random_range(70.0..100.0_f32));
        canvas.ellipse(at, [1.1 * r, 0.6 * r], 0.0, None, rng.random_range(50.0..80.0_f32));
    }
    // Nails, chips, dirt.
    for _ in 0..60 {
        let (at, r) = (place(rng), size(2.0, 7.0, rng));
        canvas.ellipse(at, [r, 0.7 * r], PI * rng.random::<f32>(), None, rng.random_range(30.0..90.0_f32));
    }
    canvas
}

fn net(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(115.0);
    canvas.octaves(4, 32, 9.0, 0.8, rng);
    const CELL: f32 = 32.0;
    let cells = (SIDE as f32 / CELL) as usize;
    for row in 0..cells {
        for column in 0..cells {
            let mut off = || CELL * (0.5 + 0.35 * (rng.random::<f32>() - 0.5));
            let at = [column as f32 * CELL + off(), row as f32 * CELL + off()];
            let turn = 0.25 * PI + 0.3 * (rng.random::<f32>() - 0.5);
            for turn in [turn, turn + 0.5 * PI] {
                canvas.rectangle(at, [0.75 * CELL, 2.0], turn, rng.random_range(185.0..235.0_f32));
            }
        }
    }
    canvas
}

fn grating(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(120.0);
    canvas.octaves(4, 32, 7.0, 0.8, rng);
    const CELL: f32 = 16.0;
    let cells = (SIDE as f32 / CELL) as usize;
    for row in 0..cells {
        for column in 0..cells {
            let at = [(column as f32 + 0.5) * CELL, (row as f32 + 0.5) * CELL];
            canvas.rectangle(at, [0.36 * CELL, 0.28 * CELL], 0.0, rng.random_range(25.0..40.0_f32));
        }
    }
    canvas
}

fn planks(rng: &mut impl Rng) -> Canvas {
    let mut canvas = Canvas::new(128.0);
    canvas.noise(4, 128, 5.0, rng);
    canvas.noise(12, 400, 4.0, rng);
    for row in 0..16_u8 {
        let y = (f32::from(row) + 0.5) * 64.0;
        let grey = rng.random_range(-20.0..20.0_f32);
        let half = SIDE as f32 / 4.0;
        for x in [half, 3.0 * half] {
            canvas.shape([x, y], half, |dx, dy| dx.abs() <= half && dy.abs() <= 32.0, |old| old + grey);
            canvas.rectangle([x, y - 32.0], [half, 1.3], 0.0, 85.0);
        }
        let joint = [rng.random::<f32>() * SIDE as f32, y];
        canvas.rectangle(joint, [1.3, 32.0], 0.0, 85.0);
        for _ in 0..rng.random_range(0..3_u8) {
            let knot = [rng.random::<f32>() * SIDE as f32, y + rng.random_range(-20.0..20.0_f32)];
            let r = rng.random_range(3.0..7.0_f32);
            canvas.ellipse(knot, [1.6 * r, r], 0.0, None, 88.0);
        }
    }
    canvas.octaves(256, 512, 2.5, 1.0, rng);
    canvas
}
