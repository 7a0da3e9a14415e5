//! One table, three ways of writing it.
//!
//! Markdown and LaTeX show rounded numbers, CSV has them in full; the notes, among them what made the table, stand below the first two and
//! above the third, behind `#`.

use super::command::Provenance;
use dpn_io::{IoError, atomic_write};
use std::fmt::Write as _;
use std::path::Path;

/// One column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its head, unit included.
    pub name: String,
    /// Whether it holds numbers, which stand to the right.
    pub number: bool,
}

/// One cell: as people read it, and in full.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    shown: String,
    full: String,
}

impl Cell {
    /// A word.
    pub fn text(text: impl Into<String>) -> Self {
        let shown = text.into();
        Self { full: shown.clone(), shown }
    }

    /// A count.
    pub fn count(count: usize) -> Self {
        Self::text(count.to_string())
    }

    /// A number, shown with so many decimals; a dash where there is none.
    pub fn number(value: impl Into<Option<f64>>, decimals: usize) -> Self {
        match value.into() {
            Some(value) if value.is_finite() => {
                Self { shown: format!("{value:.decimals$}"), full: value.to_string() }
            }
            _ => Self { shown: "-".into(), full: String::new() },
        }
    }

    /// A length in metres: three decimals below 1 m, fewer above.
    pub fn metres(value: impl Into<Option<f64>>) -> Self {
        let value = value.into();
        let decimals = match value {
            Some(v) if v.abs() >= 10.0 => 1,
            Some(v) if v.abs() >= 1.0 => 2,
            _ => 3,
        };
        Self::number(value, decimals)
    }

    /// A number with the ends of its interval.
    pub fn interval(value: Option<f64>, ends: Option<[f64; 2]>, decimals: usize) -> Self {
        let mut cell = Self::number(value, decimals);
        if let (Some(_), Some([low, high])) = (value, ends) {
            let _ = write!(cell.shown, " ({low:.decimals$} to {high:.decimals$})");
            let _ = write!(cell.full, " ({low} to {high})");
        }
        cell
    }

    /// A probability: three decimals, or the bound below which it lies.
    pub fn p(value: impl Into<Option<f64>>) -> Self {
        match value.into() {
            Some(p) if p < 0.001 => Self { shown: "<.001".into(), full: p.to_string() },
            other => Self::number(other, 3),
        }
    }

    /// The same with a mark behind what is shown.
    #[must_use]
    pub fn marked(mut self, mark: &str) -> Self {
        self.shown.push_str(mark);
        self
    }

    /// As people read it.
    pub fn shown(&self) -> &str {
        &self.shown
    }
}

/// One table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Name of its files.
    pub name: &'static str,
    /// What it shows, in a sentence.
    pub title: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each as long as `columns`; an empty one is a rule.
    pub rows: Vec<Vec<Cell>>,
    /// What a reader must know: how it is computed, what is missing and why.
    pub notes: Vec<String>,
    /// What made it.
    pub made_by: Provenance,
}

impl Table {
    /// A table without rows; heads that begin with `=` are of columns of numbers.
    pub fn new(name: &'static str, title: impl Into<String>, heads: &[&str], made_by: Provenance) -> Self {
        let column = |head: &&str| match head.strip_prefix('=') {
            Some(name) => Column { name: name.to_owned(), number: true },
            None => Column { name: (*head).to_owned(), number: false },
        };
        let columns = heads.iter().map(column).collect();
        Self { name, title: title.into(), columns, rows: Vec::new(), notes: Vec::new(), made_by }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(cells);
    }

    /// Adds a rule.
    pub fn rule(&mut self) {
        self.rows.push(Vec::new());
    }

    /// Adds a note.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    fn foot(&self) -> impl Iterator<Item = String> + '_ {
        self.notes.iter().cloned().chain(std::iter::once(format!("Made by: {}", self.made_by.line())))
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let escaped = |text: &str| text.replace('|', "\\|").replace('[', "\\[").replace(']', "\\]");
        let mut out = format!("**{}**\n\n", self.title);
        let line = |out: &mut String, cells: &mut dyn Iterator<Item = String>| {
            let _ = writeln!(out, "| {} |", cells.collect::<Vec<_>>().join(" | "));
        };
        line(&mut out, &mut self.columns.iter().map(|c| escaped(&c.name)));
        let rule = |c: &Column| if c.number { "--:".to_owned() } else { "---".to_owned() };
        line(&mut out, &mut self.columns.iter().map(rule));
        for row in self.rows.iter().filter(|row| !row.is_empty()) {
            line(&mut out, &mut row.iter().map(|cell| escaped(&cell.shown)));
        }
        out.push('\n');
        for note in self.foot() {
            let _ = writeln!(out, "* {}", escaped(&note));
        }
        out
    }

    /// As CSV: notes behind `#`, a header, numbers in full.
    pub fn csv(&self) -> String {
        let field = |text: &str| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text.to_owned()
            }
        };
        let mut out = format!("# {}\n", self.title);
        for note in self.foot() {
            let _ = writeln!(out, "# {note}");
        }
        let line = |out: &mut String, cells: &mut dyn Iterator<Item = String>| {
            let _ = writeln!(out, "{}", cells.collect::<Vec<_>>().join(","));
        };
        line(&mut out, &mut self.columns.iter().map(|c| field(&c.name)));
        for row in self.rows.iter().filter(|row| !row.is_empty()) {
            line(&mut out, &mut row.iter().map(|cell| field(&cell.full)));
        }
        out
    }

    /// As LaTeX: a `table` environment that needs no package but `graphicx`, for wide tables.
    pub fn latex(&self) -> String {
        let ends: String = self.columns.iter().map(|c| if c.number { 'r' } else { 'l' }).collect();
        let mut out = format!(
            "\\begin{{table*}}\n\\centering\n\\caption{{{}}}\n\\label{{table:{}}}\n\\resizebox{{\\textwidth}}{{!}}{{%\n\\begin{{tabular}}{{{ends}}}\n\\hline\n",
            latex(&self.title),
            self.name
        );
        let line = |out: &mut String, cells: &mut dyn Iterator<Item = String>| {
            let _ = writeln!(out, "{} \\\\", cells.collect::<Vec<_>>().join(" & "));
        };
        line(&mut out, &mut self.columns.iter().map(|c| latex(&c.name)));
        out.push_str("\\hline\n");
        for row in &self.rows {
            if row.is_empty() {
                out.push_str("\\hline\n");
            } else {
                line(&mut out, &mut row.iter().map(|cell| latex(&cell.shown)));
            }
        }
        out.push_str("\\hline\n\\end{tabular}}\n\n\\footnotesize\n");
        for note in self.foot() {
            let _ = writeln!(out, "{}\\\\", latex(&note));
        }
        out.push_str("\\end{table*}\n");
        out
    }

    /// Writes `NAME.md`, `NAME.csv` and `NAME.tex` into `dir`.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn save(&self, dir: &Path) -> Result<(), IoError> {
        for (extension, text) in [("md", self.markdown()), ("csv", self.csv()), ("tex", self.latex())] {
            atomic_write(&dir.join(format!("{}.{extension}", self.name)), |out| {
                out.write_all(text.as_bytes())
            })?;
        }
        Ok(())
    }
}

/// With LaTeX's own characters escaped.
fn latex(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '\\' => out.push_str("\\textbackslash{}"),
            '<' => out.push_str("$<$"),
            '>' => out.push_str("$>$"),
            '±' => out.push_str("$\\pm$"),
            'σ' => out.push_str("$\\sigma$"),
            '²' => out.push_str("$^2$"),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let made_by = Provenance {
            command: "dpn paper".into(),
            program: "dpn 1 (ab)".into(),
            runs: vec!["a-1".into()],
        };
        let mut table = Table::new("t", "A table", &["noise", "=ATE [m]", "=p"], made_by);
        table.row(vec![Cell::text("const(0.1,0.2)"), Cell::metres(0.1 + 0.2), Cell::p(0.0004)]);
        table.rule();
        table.row(vec![Cell::text("a|b_c"), Cell::metres(None), Cell::number(f64::NAN, 2)]);
        table.note("50 % are missing");
        table
    }

    #[test]
    fn markdown_has_a_bar_more_than_columns_and_the_run_below() {
        let expected = "**A table**\n\n| noise | ATE \\[m\\] | p |\n| --- | --: | --: |\n| const(0.1,0.2) | 0.300 | <.001 |\n\
                        | a\\|b_c | - | - |\n\n* 50 % are missing\n* Made by: dpn paper (dpn 1 (ab)); runs: a-1.\n";
        assert_eq!(table().markdown(), expected);
    }

    #[test]
    fn csv_has_numbers_in_full_and_quotes_what_holds_commas() {
        let text = table().csv();
        assert!(
            text.ends_with("noise,ATE [m],p\n\"const(0.1,0.2)\",0.30000000000000004,0.0004\na|b_c,,\n"),
            "{text}"
        );
        assert!(text.starts_with("# A table\n# 50 % are missing\n# Made by: dpn paper"));
    }

    #[test]
    fn latex_escapes_its_own_characters() {
        let text = table().latex();
        assert!(text.contains("a|b\\_c & - & - \\\\\n") && text.contains("50 \\% are"), "{text}");
        assert!(text.contains("{lrr}") && text.contains("0.300 & $<$.001"), "{text}");
        let ends = |what: &str| text.matches(&format!("\\{what}{{table*}}")).count();
        assert_eq!((ends("begin"), ends("end")), (1, 1));
    }

    #[test]
    fn intervals_stand_behind_their_number() {
        assert_eq!(Cell::interval(Some(0.5), Some([0.4, 0.61]), 2).shown(), "0.50 (0.40 to 0.61)");
        assert_eq!(Cell::interval(None, Some([0.4, 0.61]), 2).shown(), "-");
        assert_eq!(Cell::metres(12.34).marked("*").shown(), "12.3*");
    }
}
