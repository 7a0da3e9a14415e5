//! The sheet of a figure with panels side by side: legend above, small print below.

use super::frame::{ABOVE, BELOW, LEFT, RIGHT, Rect};
use super::legend::{self, Entry};
use super::plot::{Area, Painted};
use super::style;
use plotters_backend::DrawingBackend;

/// Height of the panels.
const PANEL: i32 = 620;
/// White around everything.
pub(super) const MARGIN: i32 = 20;
/// Room for legends and small print.
pub(super) const ROOM: i32 = style::WIDTH as i32 - 2 * MARGIN;

/// What surrounds the panels.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub(super) legend: Vec<Entry>,
    pub(super) caption: String,
}

impl Sheet {
    /// Width and height of the whole.
    pub(super) fn size(&self) -> (u32, u32) {
        let around = legend::height(&self.legend, ROOM) + legend::print_height(&self.caption, ROOM);
        (style::WIDTH, (2 * MARGIN + around + ABOVE + PANEL + BELOW) as u32)
    }

    /// Draws legend and small print, and each panel into its rectangle.
    pub(super) fn draw<DB: DrawingBackend, P>(
        &self,
        area: &Area<DB>,
        panels: &[P],
        draw: impl Fn(&P, Rect) -> Painted<DB>,
    ) -> Painted<DB> {
        legend::draw(area, &self.legend, (MARGIN, MARGIN), ROOM)?;
        let top = MARGIN + legend::height(&self.legend, ROOM) + ABOVE;
        let width = style::WIDTH as i32 / panels.len().max(1) as i32;
        for (i, panel) in (0..).zip(panels) {
            let rect =
                Rect { left: i * width + LEFT, top, right: (i + 1) * width - RIGHT, bottom: top + PANEL };
            draw(panel, rect)?;
        }
        legend::print(area, &self.caption, (MARGIN, top + PANEL + BELOW + 8), ROOM)
    }
}
