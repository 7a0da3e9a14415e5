//! One table, five ways of writing it: Markdown, CSV, LaTeX, aligned for a console, and, cell by cell, whatever a template makes of it.
//!
//! People read rounded numbers, CSV has them in full. Notes, among them what made the table, stand below; in CSV above, behind `#`.

mod cell;
mod console;
mod files;

pub use cell::Cell;

use super::Provenance;

/// What a column holds, which decides the side on which its cells stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Words: to the left.
    Text,
    /// Numbers: to the right.
    Number,
}

/// One column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its head, unit included.
    pub name: String,
    /// What it holds.
    pub kind: ColumnKind,
}

impl Column {
    /// A column of words.
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), kind: ColumnKind::Text }
    }

    /// A column of numbers.
    pub fn number(name: impl Into<String>) -> Self {
        Self { name: name.into(), kind: ColumnKind::Number }
    }

    /// So many columns of words, then columns of numbers.
    pub fn all(words: &[&str], numbers: &[&str]) -> Vec<Self> {
        words
            .iter()
            .map(|name| Self::text(*name))
            .chain(numbers.iter().map(|name| Self::number(*name)))
            .collect()
    }

    /// Whether it holds numbers.
    pub fn is_number(&self) -> bool {
        self.kind == ColumnKind::Number
    }
}

/// One line of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A row, as long as there are columns.
    Row {
        /// Its cells.
        cells: Vec<Cell>,
        /// Whether the other rows are compared with it.
        is_reference: bool,
    },
    /// A rule between rows.
    Rule,
}

/// One table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Name of its files.
    pub name: &'static str,
    /// What it shows, in a sentence; may be empty on a console.
    pub title: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// Rows and rules.
    pub lines: Vec<Line>,
    /// What a reader must know: how it is computed, what is missing and why.
    pub notes: Vec<String>,
    /// What made it, where it is kept.
    pub made_by: Option<Provenance>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &'static str, title: impl Into<String>, columns: Vec<Column>) -> Self {
        Self { name, title: title.into(), columns, lines: Vec::new(), notes: Vec::new(), made_by: None }
    }

    /// The same with what made it.
    #[must_use]
    pub fn made_by(self, made_by: Provenance) -> Self {
        Self { made_by: Some(made_by), ..self }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<Cell>) {
        self.lines.push(Line::Row { cells, is_reference: false });
    }

    /// Adds a row that the others are compared with, where `is_reference`.
    pub fn reference_row(&mut self, cells: Vec<Cell>, is_reference: bool) {
        self.lines.push(Line::Row { cells, is_reference });
    }

    /// Adds a rule.
    pub fn rule(&mut self) {
        self.lines.push(Line::Rule);
    }

    /// Adds a note.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Adds notes.
    pub fn notes(&mut self, notes: impl IntoIterator<Item = String>) {
        self.notes.extend(notes);
    }

    /// The cells of every row.
    fn rows(&self) -> impl Iterator<Item = &[Cell]> {
        self.lines.iter().filter_map(|line| match line {
            Line::Row { cells, .. } => Some(cells.as_slice()),
            Line::Rule => None,
        })
    }

    /// Notes, and what made the table.
    fn foot(&self) -> impl Iterator<Item = String> {
        let made_by = self.made_by.iter().map(|made_by| format!("Made by: {}", made_by.line()));
        self.notes.iter().cloned().chain(made_by)
    }
}
