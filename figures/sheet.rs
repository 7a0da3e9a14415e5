//! What stands around the panels of a figure: a title, the legend above, small print below.

use super::legend::{self, Entry};
use super::plot::{Area, Painted};
use super::style::{self, Anchor};
use plotters_backend::DrawingBackend;

/// White around everything.
pub(super) const MARGIN: i32 = 20;
/// Room for legends and small print.
pub(super) const ROOM: i32 = style::WIDTH as i32 - 2 * MARGIN;

/// What surrounds the panels.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    /// Over everything, where `head` has room for it.
    pub(super) title: String,
    /// Room for the title.
    pub(super) head: i32,
    pub(super) legend: Vec<Entry>,
    /// Height of the panels, with what stands around each.
    pub(super) body: i32,
    /// From the body to the small print.
    pub(super) gap: i32,
    pub(super) caption: String,
}

impl Sheet {
    /// Around panels of the height `body`, without a title.
    pub(super) fn new(legend: Vec<Entry>, body: i32, caption: String) -> Self {
        Self { title: String::new(), head: 0, legend, body, gap: 8, caption }
    }

    /// Width and height of the whole.
    pub(super) fn size(&self) -> (u32, u32) {
        let around = legend::height(&self.legend, ROOM) + legend::print_height(&self.caption, ROOM);
        (style::WIDTH, (2 * MARGIN + self.head + around + self.body) as u32)
    }

    /// Draws title, legend and small print; between them `body` draws the panels, told their upper edge.
    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        area: &Area<DB>,
        body: impl FnOnce(i32) -> Painted<DB>,
    ) -> Painted<DB> {
        if self.head > 0 {
            let title = style::text(style::TITLE, style::INK, Anchor::West);
            area.draw_text(&self.title, &title, (MARGIN, MARGIN + 18))?;
        }
        let top = MARGIN + self.head;
        legend::draw(area, &self.legend, (MARGIN, top), ROOM)?;
        let top = top + legend::height(&self.legend, ROOM);
        body(top)?;
        legend::print(area, &self.caption, (MARGIN, top + self.body + self.gap), ROOM)
    }
}
