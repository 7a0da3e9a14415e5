//! A figure with a line at its foot that says what made it, and a column of the same in its CSV.

use super::legend;
use super::plot::{Area, Drawn, Painted, Plot};
use super::provenance::Provenance;
use super::sheet::{MARGIN, ROOM};
use plotters_backend::DrawingBackend;

/// A plot and what made it.
#[derive(Debug, Clone)]
pub struct Sourced<P> {
    plot: P,
    made_by: Provenance,
}

impl<P: Plot> Sourced<P> {
    /// Its line stands at the foot, its runs in every row of the CSV.
    pub fn new(plot: P, made_by: Provenance) -> Self {
        Self { plot, made_by }
    }
}

impl<P: Plot> Plot for Sourced<P> {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.plot.size();
        (width, height + legend::print_height(&self.made_by.line(), ROOM) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.plot.draw(area)?;
        legend::print(area, &self.made_by.line(), (MARGIN, self.plot.size().1 as i32 - MARGIN / 2), ROOM)
    }

    fn csv(&self) -> Drawn {
        let Drawn { mut header, mut rows } = self.plot.csv();
        header.push("runs");
        for row in &mut rows {
            row.push(self.made_by.runs.join(" "));
        }
        Drawn { header, rows }
    }
}
