//! A chart: panels under one legend, each a list of layers that are drawn in their order. Most figures are one; what a figure decides is which
//! layers, where.

use super::axis::Axis;
use super::frame::{ABOVE, BELOW, Frame, LEFT, RIGHT, Rect};
use super::legend;
use super::plot::{Area, Drawn, Painted, Plot};
use super::provenance::Provenance;
use super::sheet::{MARGIN, ROOM, Sheet};
use super::style::{self, Anchor};
use super::summary::{Column, unbroken};
use plotters::style::{Color, RGBAColor, RGBColor, ShapeStyle};
use plotters_backend::DrawingBackend;

/// Height of panels side by side.
const PANEL: i32 = 620;
/// Width of the data of two panels beside each other.
pub(super) const HALF: i32 = style::WIDTH as i32 / 2 - LEFT - RIGHT;

/// A figure of panels.
#[derive(Debug, Clone)]
pub struct Chart {
    pub(super) panels: Vec<Panel>,
    sheet: Sheet,
    drawn: Drawn,
    /// What made it, at the foot.
    made_by: Option<String>,
}

/// One panel. Its place is that below the legend.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub(super) place: Rect,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) layers: Vec<Layer>,
}

/// Points of a panel, in its axes' units.
type Points = Vec<(f64, f64)>;

/// What is drawn on a panel.
#[derive(Debug, Clone)]
pub(super) enum Layer {
    /// Lines at the ticks.
    Grid,
    /// A line.
    Line(Points, ShapeStyle),
    /// A dashed line.
    Dashed(Points, ShapeStyle),
    /// What a line encloses.
    Area(Points, RGBAColor),
    /// From the smallest to the largest sample of columns, at least two pixels high.
    Envelope(Vec<Column>, RGBAColor),
    /// The panel's whole height, between two times.
    Stripe([f64; 2], RGBColor),
    /// So many pixels over the lower axis, between two times; a span may be narrower than a pixel, and is there all the same.
    Foot([f64; 2], i32, RGBColor),
    /// What lies between two values of either axis.
    Block([f64; 2], [f64; 2], RGBColor),
    /// The marker of a series with an interval, so many pixels beside its place.
    Error { series: usize, at: (f64, f64), shift: i32, ends: Option<[f64; 2]>, colour: RGBColor },
    /// The marker of a series.
    Mark(usize, (f64, f64), RGBColor),
    /// Words of a size, anchored so many pixels from the panel's upper left corner.
    Words(String, f64, RGBColor, Anchor, (i32, i32)),
    /// The axes; whether with the words of the lower one.
    Axes(bool),
    /// The axes of a small panel.
    SmallAxes,
}

impl Layer {
    /// A title over the panel.
    pub(super) fn title(words: impl Into<String>) -> Self {
        Self::Words(words.into(), style::TITLE, style::INK, Anchor::West, (0, -ABOVE / 2))
    }

    /// The band between two lines with the same places, `upper` first.
    pub(super) fn band(upper: Points, lower: Points, colour: RGBAColor) -> Self {
        Self::Area(upper.into_iter().chain(lower.into_iter().rev()).collect(), colour)
    }

    /// A line through the medians of columns, broken where there are none.
    pub(super) fn medians(columns: &[Column], colour: RGBColor) -> impl Iterator<Item = Self> {
        unbroken(columns, |c| c.t).map(move |part| {
            let points = part.iter().map(|c| (c.t, c.middle)).collect();
            Self::Line(points, style::stroke(colour, style::LINE - 1))
        })
    }
}

impl Panel {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, top: i32) -> Painted<DB> {
        let place = self.place;
        let rect = Rect { top: place.top + top, bottom: place.bottom + top, ..place };
        let frame = Frame::new(area, rect, &self.x, &self.y);
        let at = |points: &Points| points.iter().map(|(x, y)| frame.at(*x, *y)).collect::<Vec<_>>();
        for layer in &self.layers {
            match layer {
                Layer::Grid => frame.grid()?,
                Layer::Line(points, style) => frame.path(at(points), *style)?,
                Layer::Dashed(points, style) => frame.dashed(at(points), *style)?,
                Layer::Area(points, colour) => frame.polygon(at(points), *colour)?,
                Layer::Envelope(columns, colour) => {
                    for part in unbroken(columns, |c| c.t) {
                        let upper = part.iter().map(|c| (frame.x_at(c.t), frame.y_at(c.high) - 1));
                        let lower = part.iter().rev().map(|c| (frame.x_at(c.t), frame.y_at(c.low) + 1));
                        frame.polygon(upper.chain(lower).collect(), *colour)?;
                    }
                }
                Layer::Stripe([from, to], colour) => {
                    frame.block((frame.x_at(*from), rect.top), (frame.x_at(*to), rect.bottom), *colour)?;
                }
                Layer::Foot([from, to], height, colour) => {
                    let (left, right) = (frame.x_at(*from), frame.x_at(*to).max(frame.x_at(*from) + 1));
                    frame.block((left, rect.bottom - height), (right, rect.bottom), *colour)?;
                }
                Layer::Block([left, right], [low, high], colour) => {
                    // A pixel over its neighbours, which hides the seams between them.
                    let (x, y) = frame.at(*right, *low);
                    frame.block(frame.at(*left, *high), (x + 1, y + 1), *colour)?;
                }
                Layer::Error { series, at: (x, y), shift, ends, colour } => {
                    let at = |y: f64| (frame.x_at(*x) + shift, frame.y_at(y));
                    if let Some([low, high]) = *ends {
                        frame.path(vec![at(low), at(high)], style::stroke(*colour, style::THIN))?;
                    }
                    legend::marker(area, *series, at(*y), *colour)?;
                }
                Layer::Mark(series, (x, y), colour) => {
                    legend::marker(area, *series, frame.at(*x, *y), *colour)?;
                }
                Layer::Words(words, em, colour, anchor, (x, y)) => {
                    frame.words(words, *em, *colour, *anchor, (rect.left + x, rect.top + y))?;
                }
                Layer::Axes(words) => frame.axes(*words)?,
                Layer::SmallAxes => frame.small_axes()?,
            }
        }
        Ok(())
    }
}

impl Chart {
    pub(super) fn new(sheet: Sheet, panels: Vec<Panel>, drawn: Drawn) -> Self {
        Self { panels, sheet, drawn, made_by: None }
    }

    /// Panels of equal size beside each other, each of its axes and the layers between grid and axes, with a title.
    pub(super) fn side_by_side(
        legend: Vec<legend::Entry>,
        caption: String,
        panels: Vec<(String, Axis, Axis, Vec<Layer>)>,
        drawn: Drawn,
    ) -> Self {
        let width = style::WIDTH as i32 / panels.len().max(1) as i32;
        let place = |i: i32| Rect {
            left: i * width + LEFT,
            top: ABOVE,
            right: (i + 1) * width - RIGHT,
            bottom: ABOVE + PANEL,
        };
        let panel = |(i, (title, x, y, layers)): (i32, (String, Axis, Axis, Vec<Layer>))| {
            let around = [Layer::Axes(true), Layer::title(title)];
            let layers = std::iter::once(Layer::Grid).chain(layers).chain(around).collect();
            Panel { place: place(i), x, y, layers }
        };
        let panels = (0..).zip(panels).map(panel).collect();
        Self::new(Sheet::new(legend, ABOVE + PANEL + BELOW, caption), panels, drawn)
    }
}

impl Chart {
    /// The same with what made it in a line at the foot, and its runs in every row of the CSV.
    #[must_use]
    pub fn made_by(mut self, made_by: &Provenance) -> Self {
        self.made_by = Some(made_by.line());
        self.drawn.header.push("runs");
        self.drawn.rows.iter_mut().for_each(|row| row.push(made_by.runs.join(" ")));
        self
    }
}

impl Plot for Chart {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.sheet.size();
        let foot = self.made_by.as_ref().map_or(0, |line| legend::print_height(line, ROOM));
        (width, height + foot as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.draw(area, |top| self.panels.iter().try_for_each(|panel| panel.draw(area, top)))?;
        let foot = (MARGIN, self.sheet.size().1 as i32 - MARGIN / 2);
        self.made_by.as_ref().map_or(Ok(()), |line| legend::print(area, line, foot, ROOM))
    }

    fn csv(&self) -> Drawn {
        self.drawn.clone()
    }
}

/// A colour at some strength.
pub(super) fn pale(colour: RGBColor, share: f64) -> RGBAColor {
    colour.mix(share)
}
