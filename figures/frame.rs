//! A panel: its rectangle, axes, grid, and the way from values to pixels.

use super::axis::{Axis, Scale};
use super::plot::{Area, Painted};
use super::style::{self, Anchor};
use plotters::element::{DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::style::{Color, RGBColor, ShapeStyle};
use plotters_backend::DrawingBackend;

/// A rectangle in pixels of the drawing; y grows downwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rect {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) right: i32,
    pub(super) bottom: i32,
}

/// Room to the left of a panel for its ticks and label.
pub(super) const LEFT: i32 = 168;
/// Room below a panel for its ticks and label.
pub(super) const BELOW: i32 = 95;
/// Room above a panel for its title.
pub(super) const ABOVE: i32 = 50;
/// Room to the right of a panel.
pub(super) const RIGHT: i32 = 30;

/// A panel being drawn.
pub(super) struct Frame<'a, DB: DrawingBackend> {
    area: &'a Area<DB>,
    pub(super) rect: Rect,
    x: &'a Axis,
    y: &'a Axis,
}

impl<'a, DB: DrawingBackend> Frame<'a, DB> {
    /// A panel whose data lie in `rect`.
    pub(super) fn new(area: &'a Area<DB>, rect: Rect, x: &'a Axis, y: &'a Axis) -> Self {
        Self { area, rect, x, y }
    }

    /// Pixel of a value, held inside the panel.
    pub(super) fn at(&self, x: f64, y: f64) -> (i32, i32) {
        (self.x_at(x), self.y_at(y))
    }

    /// Pixel column of a value.
    pub(super) fn x_at(&self, x: f64) -> i32 {
        self.rect.left + (self.x.fraction(x) * f64::from(self.rect.right - self.rect.left)).round() as i32
    }

    /// Pixel row of a value.
    pub(super) fn y_at(&self, y: f64) -> i32 {
        self.rect.bottom - (self.y.fraction(y) * f64::from(self.rect.bottom - self.rect.top)).round() as i32
    }

    /// Grid lines, below all data.
    pub(super) fn grid(&self) -> Painted<DB> {
        let style = style::stroke(style::GRID, style::THIN);
        for (value, _) in &self.x.ticks {
            let x = self.x_at(*value);
            self.path(vec![(x, self.rect.top), (x, self.rect.bottom)], style)?;
        }
        for (value, _) in &self.y.ticks {
            let y = self.y_at(*value);
            self.path(vec![(self.rect.left, y), (self.rect.right, y)], style)?;
        }
        Ok(())
    }

    /// Left and lower axis with ticks; `words` of the lower one are left out where the panel below has them.
    pub(super) fn axes(&self, words: bool) -> Painted<DB> {
        let Rect { left, top, right, bottom } = self.rect;
        let line = style::stroke(style::INK, style::THIN);
        self.path(vec![(left, top), (left, bottom), (right, bottom)], line)?;
        for value in fine_ticks(self.x) {
            self.path(vec![(self.x_at(value), bottom), (self.x_at(value), bottom + 5)], line)?;
        }
        for value in fine_ticks(self.y) {
            self.path(vec![(left - 5, self.y_at(value)), (left, self.y_at(value))], line)?;
        }
        for (value, tick) in &self.x.ticks {
            let x = self.x_at(*value);
            self.path(vec![(x, bottom), (x, bottom + 9)], line)?;
            if words {
                self.words(tick, style::TICK, style::INK, Anchor::North, (x, bottom + 14))?;
            }
        }
        for (value, tick) in &self.y.ticks {
            let y = self.y_at(*value);
            self.path(vec![(left - 9, y), (left, y)], line)?;
            self.words(tick, style::TICK, style::INK, Anchor::East, (left - 15, y))?;
        }
        if words {
            let middle = (left + right) / 2;
            self.words(&self.x.label, style::LABEL, style::INK, Anchor::North, (middle, bottom + 54))?;
        }
        let style = style::text_upwards(style::LABEL, style::INK);
        self.area.draw_text(&self.y.label, &style, (left - LEFT + 24, (top + bottom) / 2))
    }

    /// As [`axes`](Self::axes) for a small panel: small words, the labels at the ends of the axes.
    pub(super) fn small_axes(&self) -> Painted<DB> {
        let Rect { left, top, right, bottom } = self.rect;
        let line = style::stroke(style::INK, style::THIN);
        self.path(vec![(left, top), (left, bottom), (right, bottom)], line)?;
        let label = style::width(&self.x.label, style::CAPTION) + 14;
        for (value, tick) in &self.x.ticks {
            let x = self.x_at(*value);
            self.path(vec![(x, bottom), (x, bottom + 7)], line)?;
            if x + style::width(tick, style::CAPTION) / 2 < right - label {
                self.words(tick, style::CAPTION, style::INK, Anchor::North, (x, bottom + 10))?;
            }
        }
        for (value, tick) in &self.y.ticks {
            let y = self.y_at(*value);
            self.path(vec![(left - 7, y), (left, y)], line)?;
            if y > top + 34 {
                self.words(tick, style::CAPTION, style::INK, Anchor::East, (left - 12, y))?;
            }
        }
        let at = (right, bottom + 22);
        self.words(&self.x.label, style::CAPTION, style::INK, Anchor::East, at)?;
        self.words(&self.y.label, style::CAPTION, style::INK, Anchor::East, (left - 12, top + 12))
    }

    /// A word anywhere.
    pub(super) fn words(
        &self,
        words: &str,
        em: f64,
        colour: RGBColor,
        anchor: Anchor,
        at: (i32, i32),
    ) -> Painted<DB> {
        self.area.draw_text(words, &style::text(em, colour, anchor), at)
    }

    /// A line through pixels.
    pub(super) fn path(&self, points: Vec<(i32, i32)>, style: ShapeStyle) -> Painted<DB> {
        self.area.draw(&PathElement::new(points, style))
    }

    /// A dashed line through pixels.
    pub(super) fn dashed(&self, points: Vec<(i32, i32)>, style: ShapeStyle) -> Painted<DB> {
        self.area.draw(&DashedPathElement::new(points, 14, 9, style))
    }

    /// A filled polygon.
    pub(super) fn polygon(&self, points: Vec<(i32, i32)>, colour: impl Color) -> Painted<DB> {
        self.area.draw(&Polygon::new(points, colour.filled()))
    }

    /// A filled rectangle between two corners.
    pub(super) fn block(&self, a: (i32, i32), b: (i32, i32), colour: impl Color) -> Painted<DB> {
        let low = (a.0.min(b.0), a.1.min(b.1));
        let high = (a.0.max(b.0), a.1.max(b.1));
        self.area.draw(&Rectangle::new([low, high], colour.filled()))
    }
}

/// Unlabelled ticks: the digits 1 to 9 of each decade, on logarithmic axes.
fn fine_ticks(axis: &Axis) -> Vec<f64> {
    if axis.scale == Scale::Linear {
        return Vec::new();
    }
    (axis.low().log10().floor() as i32..=axis.high().log10().ceil() as i32)
        .flat_map(|power| (1..=9).map(move |digit| f64::from(digit) * 10f64.powi(power)))
        .filter(|value| (axis.low()..=axis.high()).contains(value))
        .collect()
}
