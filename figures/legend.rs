//! The legend, a row of keys over the panels, and the small print under them. Neither covers data.

use super::plot::{Area, Painted};
use super::style::{self, Anchor};
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::style::{Color, RGBColor};
use plotters_backend::DrawingBackend;

/// What a key shows beside its words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    /// A line.
    Line,
    /// A thin dashed line.
    Dashed,
    /// A line with the marker of the series of this number.
    Marked(usize),
    /// A patch.
    Patch,
    /// A patch of a colour as pale as paper, with a rim.
    Tint,
}

/// One entry of a legend.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) key: Key,
    pub(super) colour: RGBColor,
    pub(super) words: String,
}

/// An entry of `key` for each of `words`, in the palette's order.
pub(super) fn entries<'a>(key: Key, words: impl IntoIterator<Item = &'a str>) -> Vec<Entry> {
    let entry = |(words, colour): (&str, RGBColor)| Entry { key, colour, words: words.to_owned() };
    words.into_iter().zip(style::PALETTE).map(entry).collect()
}

/// As [`entries`], each key a line with the marker of its number.
pub(super) fn marked<'a>(words: impl IntoIterator<Item = &'a str>) -> Vec<Entry> {
    let mut entries = entries(Key::Line, words);
    (0..).zip(&mut entries).for_each(|(i, entry)| entry.key = Key::Marked(i));
    entries
}

const KEY: i32 = 54;
const GAP: i32 = 12;
const BETWEEN: i32 = 42;
/// Height of one row of a legend.
const ROW: i32 = 44;
/// Height of one row of small print.
const PRINT: i32 = 32;

/// Entries broken into rows of at most `room` pixels.
fn rows(entries: &[Entry], room: i32) -> Vec<Vec<(i32, &Entry)>> {
    let mut rows: Vec<Vec<(i32, &Entry)>> = Vec::new();
    let mut next = 0;
    for entry in entries {
        let width = KEY + GAP + style::width(&entry.words, style::LABEL);
        match rows.last_mut() {
            Some(row) if next + width <= room => row.push((next, entry)),
            _ => {
                next = 0;
                rows.push(vec![(0, entry)]);
            }
        }
        next += width + BETWEEN;
    }
    rows
}

/// Height of the legend in a drawing with `room` pixels from its left edge.
pub(super) fn height(entries: &[Entry], room: i32) -> i32 {
    rows(entries, room).len() as i32 * ROW
}

/// Draws the legend with its upper left corner at `at`.
pub(super) fn draw<DB: DrawingBackend>(
    area: &Area<DB>,
    entries: &[Entry],
    at: (i32, i32),
    room: i32,
) -> Painted<DB> {
    for (row, entries) in rows(entries, room).into_iter().enumerate() {
        let y = at.1 + row as i32 * ROW + ROW / 2;
        for (x, entry) in entries {
            let x = at.0 + x;
            let line = vec![(x, y), (x + KEY, y)];
            match entry.key {
                Key::Line => area.draw(&PathElement::new(line, style::stroke(entry.colour, style::LINE)))?,
                Key::Dashed => area.draw(&DashedPathElement::new(
                    line,
                    14,
                    6,
                    style::stroke(entry.colour, style::LINE - 1),
                ))?,
                Key::Marked(series) => {
                    area.draw(&PathElement::new(line, style::stroke(entry.colour, style::LINE)))?;
                    marker(area, series, (x + KEY / 2, y), entry.colour)?;
                }
                Key::Patch | Key::Tint => {
                    let (right, top, bottom) = (x + KEY, y - 12, y + 12);
                    area.draw(&Rectangle::new([(x, top), (right, bottom)], entry.colour.filled()))?;
                    if entry.key == Key::Tint {
                        let rim = vec![(x, top), (right, top), (right, bottom), (x, bottom), (x, top)];
                        area.draw(&PathElement::new(rim, style::stroke(style::MUTED.mix(0.6), 1)))?;
                    }
                }
            }
            let words = style::text(style::LABEL, style::INK, Anchor::West);
            area.draw_text(&entry.words, &words, (x + KEY + GAP, y))?;
        }
    }
    Ok(())
}

/// The marker of a series: shapes differ, so that lines can be told apart without colour.
pub(super) fn marker<DB: DrawingBackend>(
    area: &Area<DB>,
    series: usize,
    (x, y): (i32, i32),
    colour: RGBColor,
) -> Painted<DB> {
    const R: i32 = 9;
    let polygon = |points: Vec<(i32, i32)>| area.draw(&Polygon::new(points, colour.filled()));
    match series % 6 {
        0 => area.draw(&Circle::new((x, y), R, colour.filled())),
        1 => polygon(vec![
            (x - R + 1, y - R + 1),
            (x + R - 1, y - R + 1),
            (x + R - 1, y + R - 1),
            (x - R + 1, y + R - 1),
        ]),
        2 => polygon(vec![(x, y - R - 2), (x + R + 1, y + R - 2), (x - R - 1, y + R - 2)]),
        3 => polygon(vec![(x, y - R - 2), (x + R + 2, y), (x, y + R + 2), (x - R - 2, y)]),
        4 => polygon(vec![(x, y + R + 2), (x + R + 1, y - R + 2), (x - R - 1, y - R + 2)]),
        _ => {
            let arms =
                [(-1, -1), (-1, 1)].map(|(dx, dy)| vec![(x + 8 * dx, y + 8 * dy), (x - 8 * dx, y - 8 * dy)]);
            for arm in arms {
                area.draw(&PathElement::new(arm, style::stroke(colour, 5)))?;
            }
            Ok(())
        }
    }
}

/// Words broken into rows of at most `room` pixels.
fn broken(words: &str, room: i32) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        match rows.last_mut() {
            Some(row) if style::width(&format!("{row} {word}"), style::CAPTION) <= room => {
                row.push(' ');
                row.push_str(word);
            }
            _ => rows.push(word.to_owned()),
        }
    }
    rows
}

/// Height of the small print.
pub(super) fn print_height(words: &str, room: i32) -> i32 {
    broken(words, room).len() as i32 * PRINT + 14
}

/// Draws the small print with its upper left corner at `at`.
pub(super) fn print<DB: DrawingBackend>(
    area: &Area<DB>,
    words: &str,
    at: (i32, i32),
    room: i32,
) -> Painted<DB> {
    let style = style::text(style::CAPTION, style::MUTED, Anchor::West);
    for (row, words) in broken(words, room).iter().enumerate() {
        area.draw_text(words, &style, (at.0, at.1 + row as i32 * PRINT + PRINT / 2))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_wrap_and_none_is_lost() {
        let entries: Vec<Entry> = (0..7)
            .map(|i| Entry {
                key: Key::Marked(i),
                colour: style::INK,
                words: format!("a rather long estimator {i}"),
            })
            .collect();
        let broken = rows(&entries, 1000);
        assert!(broken.len() > 1);
        assert_eq!(broken.iter().map(Vec::len).sum::<usize>(), 7);
        for row in &broken {
            let (x, last) = row.last().unwrap();
            assert!(x + KEY + GAP + style::width(&last.words, style::LABEL) <= 1000);
        }
    }

    #[test]
    fn small_print_keeps_its_words() {
        let words = "one two three four five six seven eight nine ten";
        let rows = broken(words, 200);
        assert!(rows.len() > 2);
        assert_eq!(rows.join(" "), words);
    }
}
