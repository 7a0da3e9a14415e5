//! Boxes and arrows: a drawing of how parts are put together, its places given, its words from the caller.

use super::error::FigureError;
use super::legend;
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::{MARGIN, ROOM};
use super::style::{self, Anchor};
use plotters::element::{DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::style::{Color, RGBColor};
use plotters_backend::DrawingBackend;

/// What a box stands for; each kind has its colour and its rim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// A sensor or a file.
    Data,
    /// A step of the odometry.
    Step,
    /// What the paper adds, or a network.
    Network,
    /// A state of the window.
    State,
    /// What ties states together.
    Factor,
}

/// A box.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Left and upper edge \[pixels\].
    pub at: (i32, i32),
    /// Width and height \[pixels\].
    pub size: (i32, i32),
    /// What it stands for.
    pub kind: BlockKind,
    /// Its words: the first line large, the others small.
    pub lines: Vec<String>,
}

/// An arrow along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrow {
    /// Corners \[pixels\]; the head is at the last one.
    pub path: Vec<(i32, i32)>,
    /// Words beside the middle of its longest part.
    pub words: String,
    /// Whether it has a head.
    pub head: bool,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// Boxes and arrows.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    blocks: Vec<Block>,
    arrows: Vec<Arrow>,
    caption: String,
    height: i32,
}

impl BlockKind {
    fn paper(self) -> RGBColor {
        match self {
            Self::Data => RGBColor(0xF2, 0xF2, 0xF2),
            Self::Step => RGBColor(0xE3, 0xEE, 0xF7),
            Self::Network => RGBColor(0xDD, 0xF1, 0xE8),
            Self::State => RGBColor(0xFF, 0xFF, 0xFF),
            Self::Factor => RGBColor(0xFB, 0xEA, 0xDC),
        }
    }

    fn rim(self) -> RGBColor {
        match self {
            Self::Data => style::MUTED,
            Self::Step => style::PALETTE[0],
            Self::Network => style::PALETTE[2],
            Self::State => style::INK,
            Self::Factor => style::PALETTE[1],
        }
    }
}

impl Block {
    /// Middle of the right edge.
    pub fn east(&self) -> (i32, i32) {
        (self.at.0 + self.size.0, self.at.1 + self.size.1 / 2)
    }

    /// Middle of the left edge.
    pub fn west(&self) -> (i32, i32) {
        (self.at.0, self.at.1 + self.size.1 / 2)
    }

    /// Middle of the lower edge.
    pub fn south(&self) -> (i32, i32) {
        (self.at.0 + self.size.0 / 2, self.at.1 + self.size.1)
    }
}

/// Height of a line of small words.
const SMALL: i32 = 29;

impl Diagram {
    /// Boxes and arrows on a sheet as high as they need, `caption` below.
    ///
    /// # Errors
    /// No box; one that does not fit the sheet's width, or whose words do not fit it.
    pub fn new(blocks: Vec<Block>, arrows: Vec<Arrow>, caption: &str) -> Result<Self, FigureError> {
        let Some(bottom) = blocks.iter().map(|b| b.at.1 + b.size.1).max() else {
            return Err(FigureError::Empty { figure: "diagram", what: "box".into() });
        };
        let low = arrows.iter().flat_map(|a| &a.path).map(|p| p.1).max().unwrap_or(0);
        for block in &blocks {
            let high = LARGE + SMALL * (block.lines.len() as i32 - 1);
            let inside = block.at.0 >= 0 && block.at.0 + block.size.0 <= style::WIDTH as i32;
            let readable = (0..).zip(&block.lines).all(|(i, line)| fitted(block, i, line) >= SMALLEST);
            if !inside || !readable || high > block.size.1 {
                return Err(FigureError::Draw {
                    reason: format!(
                        "the box `{}` does not fit its place or its words",
                        block.lines.join("; ")
                    ),
                });
            }
        }
        Ok(Self { blocks, arrows, caption: caption.to_owned(), height: bottom.max(low) + MARGIN })
    }
}

/// Height of the first line.
const LARGE: i32 = 36;

/// Size of letters below which nobody reads.
const SMALLEST: f64 = 14.0;

/// Size of the letters of a line: smaller where its words are too wide for the box.
fn fitted(block: &Block, line: i32, words: &str) -> f64 {
    let em = if line == 0 { style::TICK } else { style::CAPTION };
    let (room, width) = (f64::from(block.size.0 - 14), f64::from(style::width(words, em)));
    if width > room { em * room / width } else { em }
}

impl Plot for Diagram {
    fn size(&self) -> (u32, u32) {
        (style::WIDTH, (self.height + legend::print_height(&self.caption, ROOM) + MARGIN) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        for arrow in &self.arrows {
            draw_arrow(area, arrow)?;
        }
        for block in &self.blocks {
            let ((left, top), (width, height)) = (block.at, block.size);
            let (right, bottom) = (left + width, top + height);
            area.draw(&Rectangle::new([(left, top), (right, bottom)], block.kind.paper().filled()))?;
            let rim = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            area.draw(&PathElement::new(rim, style::stroke(block.kind.rim(), style::THIN + 1)))?;
            let words = LARGE + SMALL * (block.lines.len() as i32 - 1);
            let mut y = top + (height - words) / 2 + LARGE / 2;
            for (i, line) in (0..).zip(&block.lines) {
                let colour = if i == 0 { style::INK } else { style::MUTED };
                area.draw_text(
                    line,
                    &style::text(fitted(block, i, line), colour, Anchor::Centre),
                    (left + width / 2, y),
                )?;
                y += if i == 0 { (LARGE + SMALL) / 2 } else { SMALL };
            }
        }
        for arrow in self.arrows.iter().filter(|arrow| !arrow.words.is_empty()) {
            draw_words(area, arrow)?;
        }
        legend::print(area, &self.caption, (MARGIN, self.height), ROOM)
    }

    fn csv(&self) -> Drawn {
        let block = |b: &Block| row!["box", b.lines.join("; "), b.at.0, b.at.1, b.size.0, b.size.1];
        let arrow = |a: &Arrow| {
            let ends = [a.path.first(), a.path.last()].map(|p| p.copied().unwrap_or((0, 0)));
            row!["arrow", a.words, ends[0].0, ends[0].1, ends[1].0, ends[1].1]
        };
        let rows = self.blocks.iter().map(block).chain(self.arrows.iter().map(arrow)).collect();
        Drawn { header: vec!["what", "words", "a", "b", "c", "d"], rows }
    }
}

fn draw_arrow<DB: DrawingBackend>(area: &Area<DB>, arrow: &Arrow) -> Painted<DB> {
    let line = style::stroke(style::INK, style::THIN + 1);
    if arrow.dashed {
        area.draw(&DashedPathElement::new(arrow.path.clone(), 12, 8, line))?;
    } else {
        area.draw(&PathElement::new(arrow.path.clone(), line))?;
    }
    let [.., (x0, y0), (x, y)] = arrow.path[..] else { return Ok(()) };
    if !arrow.head {
        return Ok(());
    }
    let (dx, dy) = (f64::from(x - x0), f64::from(y - y0));
    let length = dx.hypot(dy).max(1.0);
    let (ux, uy) = (dx / length, dy / length);
    let at = |along: f64, across: f64| {
        let px = f64::from(x) - along * ux + across * uy;
        let py = f64::from(y) - along * uy - across * ux;
        (px.round() as i32, py.round() as i32)
    };
    area.draw(&Polygon::new(vec![(x, y), at(17.0, 7.0), at(17.0, -7.0)], style::INK.filled()))
}

/// Words over the middle of the longest part, on white.
fn draw_words<DB: DrawingBackend>(area: &Area<DB>, arrow: &Arrow) -> Painted<DB> {
    let square = |w: &[(i32, i32)]| (w[1].0 - w[0].0).pow(2) + (w[1].1 - w[0].1).pow(2);
    let Some(part) = arrow.path.windows(2).max_by_key(|w| square(w)) else { return Ok(()) };
    let middle = ((part[0].0 + part[1].0) / 2, (part[0].1 + part[1].1) / 2);
    let level = part[0].1 == part[1].1;
    let width = style::width(&arrow.words, style::CAPTION);
    let at = if level { (middle.0, middle.1 - 18) } else { (middle.0 + width / 2 + 12, middle.1) };
    area.draw_text(&arrow.words, &style::text(style::CAPTION, style::MUTED, Anchor::Centre), at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    fn block(words: &str, width: i32) -> Block {
        Block {
            at: (20, 20),
            size: (width, 90),
            kind: BlockKind::Step,
            lines: vec![words.into(), "small".into()],
        }
    }

    #[test]
    fn words_stand_in_the_drawing_and_in_its_csv() {
        let arrow =
            Arrow { path: vec![(220, 65), (400, 65)], words: "tracks".into(), head: true, dashed: false };
        let diagram = Diagram::new(vec![block("window", 200)], vec![arrow], "What it is.").unwrap();
        let text = String::from_utf8(svg(&diagram).unwrap()).unwrap();
        for words in ["window", "small", "tracks", "What it is."] {
            assert!(text.contains(words), "{words}");
        }
        assert_eq!(diagram.csv().rows[0][1], "window; small");
    }

    #[test]
    fn words_that_do_not_fit_are_an_error() {
        let error =
            Diagram::new(vec![block("a window with very many words in it", 100)], vec![], "").unwrap_err();
        assert!(error.to_string().contains("does not fit"), "{error}");
        assert!(matches!(Diagram::new(vec![], vec![], ""), Err(FigureError::Empty { .. })));
    }
}
