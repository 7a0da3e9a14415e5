//! A table aligned by blanks, for terminals.

use super::{Cell, ColumnKind, Line, Table};
use std::fmt::Write as _;

impl Table {
    /// The title where there is one, heads, a rule, rows, notes; every line ends where its text does.
    pub fn console(&self) -> String {
        let heads: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let shown =
            |cells: &[Cell]| -> Vec<String> { cells.iter().map(|cell| cell.shown().to_owned()).collect() };
        let mut widths: Vec<usize> = heads.iter().map(|head| head.chars().count()).collect();
        for row in self.rows() {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = cell.shown().chars().count().max(*width);
            }
        }
        let aligned = |cells: &[String]| -> String {
            let padded = cells.iter().zip(&widths).zip(&self.columns);
            let padded = padded.map(|((text, &width), column)| match column.kind {
                ColumnKind::Text => format!("{text:<width$}"),
                ColumnKind::Number => format!("{text:>width$}"),
            });
            padded.collect::<Vec<_>>().join("  ")
        };
        let rule = aligned(&widths.iter().map(|width| "-".repeat(*width)).collect::<Vec<_>>());
        let heads: Vec<String> = heads.into_iter().map(str::to_owned).collect();
        let mut out = String::new();
        let title = Some(self.title.clone()).filter(|title| !title.is_empty());
        let lines = self.lines.iter().map(|line| match line {
            Line::Row { cells, .. } => aligned(&shown(cells)),
            Line::Rule => rule.clone(),
        });
        for line in title.into_iter().chain([aligned(&heads), rule.clone()]).chain(lines).chain(self.foot()) {
            let _ = writeln!(out, "{}", line.trim_end());
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::Column;
    use super::*;

    #[test]
    fn words_stand_to_the_left_and_numbers_to_the_right() {
        let mut table = Table::new("t", "", Column::all(&["noise"], &["ATE [m]", "p"]));
        table.row(vec![Cell::text("dualpronet"), Cell::metres(0.1 + 0.2), Cell::p(0.0004)]);
        table.rule();
        table.row(vec![Cell::text("x1"), Cell::metres(None), Cell::none()]);
        let expected = "\
noise       ATE [m]      p
----------  -------  -----
dualpronet    0.300  <.001
----------  -------  -----
x1                -      -
";
        assert_eq!(table.console(), expected);
        table.title = "A table".into();
        table.note("a note");
        let text = table.console();
        assert!(text.starts_with("A table\nnoise") && text.ends_with("      -\na note\n"), "{text}");
    }
}
