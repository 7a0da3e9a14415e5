//! Colours for a quantity: pale is little, dark is much, told apart by lightness too.

use super::axis::Axis;
use super::chart::{Layer, Panel};
use super::frame::{LEFT, RIGHT, Rect};
use super::style::{self, Anchor};
use plotters::style::RGBColor;

/// Colours from the least to the most.
pub(super) const STEPS: usize = 24;
/// Height of a scale with its ticks.
pub(super) const SCALE: i32 = 62;
/// Height of its colours.
const BAR: i32 = 22;
const COLOURS: [RGBColor; 5] = [
    RGBColor(0x8C, 0xC6, 0xEC),
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x6E, 0x00, 0x1E),
];

/// The step of a value at this fraction of its axis.
pub(super) fn step(fraction: f64) -> usize {
    ((fraction * STEPS as f64) as usize).min(STEPS - 1)
}

/// The colour of one of [`STEPS`].
pub(super) fn colour(step: usize) -> RGBColor {
    let at = step as f64 / (STEPS - 1) as f64 * (COLOURS.len() - 1) as f64;
    let below = (at as usize).min(COLOURS.len() - 2);
    let share = at - below as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    let (RGBColor(r, g, b), RGBColor(u, v, w)) = (COLOURS[below], COLOURS[below + 1]);
    RGBColor(mix(r, u), mix(g, v), mix(b, w))
}

/// What value a colour is: a bar over `axis`, its upper edge at `top`, its words, the axis' label, above it.
pub(super) fn scale(top: i32, axis: Axis) -> Panel {
    let place = Rect { left: LEFT, top, right: style::WIDTH as i32 - RIGHT, bottom: top + BAR };
    let at = |step: usize| {
        let share = step as f64 / STEPS as f64;
        axis.at(share)
    };
    let mut layers: Vec<Layer> = (0..STEPS).map(|i| Layer::Stripe([at(i), at(i + 1)], colour(i))).collect();
    layers.push(Layer::SmallAxes);
    let words = format!("colour: {}", axis.label);
    layers.push(Layer::Words(words, style::CAPTION, style::INK, Anchor::West, (0, -18)));
    let mut y = Axis::linear(String::new(), 0.0, 1.0, 1);
    y.ticks.clear();
    let mut x = axis;
    x.label = String::new();
    Panel { place, x, y, layers }
}
