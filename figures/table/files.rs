//! A table as Markdown, CSV and LaTeX.

use super::{Cell, Line, Table};
use dpn_io::{IoError, atomic_write};
use std::fmt::Write as _;
use std::path::Path;

impl Table {
    /// As Markdown.
    pub(crate) fn markdown(&self) -> String {
        let escaped = |text: &str| text.replace('|', "\\|").replace('[', "\\[").replace(']', "\\]");
        let mut out = format!("**{}**\n\n", self.title);
        let line = |out: &mut String, cells: Vec<String>| {
            let _ = writeln!(out, "| {} |", cells.join(" | "));
        };
        line(&mut out, self.columns.iter().map(|c| escaped(&c.name)).collect());
        let rule = |number: bool| if number { "--:" } else { "---" }.to_owned();
        line(&mut out, self.columns.iter().map(|c| rule(c.is_number())).collect());
        for row in self.rows() {
            line(&mut out, row.iter().map(|cell| escaped(cell.shown())).collect());
        }
        out.push('\n');
        for note in self.foot() {
            let _ = writeln!(out, "* {}", escaped(&note));
        }
        out
    }

    /// As CSV: title and notes behind `#`, a header, numbers in full.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let heads = self.columns.iter().map(|c| c.name.as_str()).collect();
        for record in
            std::iter::once(heads).chain(self.rows().map(|row| row.iter().map(Cell::full).collect()))
        {
            let record: Vec<&str> = record;
            writer.write_record(record).expect("every row has a cell a column, and memory takes it");
        }
        let text = writer.into_inner().expect("memory takes it");
        let title = Some(&self.title).filter(|title| !title.is_empty()).cloned();
        let mut out: String =
            title.into_iter().chain(self.foot()).map(|line| format!("# {line}\n")).collect();
        out.push_str(&String::from_utf8(text).expect("strings went in"));
        out
    }

    /// As LaTeX: a `table` environment that needs no package but `graphicx`, for wide tables.
    pub(crate) fn latex(&self) -> String {
        let ends: String = self.columns.iter().map(|c| if c.is_number() { 'r' } else { 'l' }).collect();
        let mut out = format!(
            "\\begin{{table*}}\n\\centering\n\\caption{{{}}}\n\\label{{table:{}}}\n\\resizebox{{\\textwidth}}{{!}}{{%\n\\begin{{tabular}}{{{ends}}}\n\\hline\n",
            latex(&self.title),
            self.name
        );
        let line = |out: &mut String, cells: Vec<String>| {
            let _ = writeln!(out, "{} \\\\", cells.join(" & "));
        };
        line(&mut out, self.columns.iter().map(|c| latex(&c.name)).collect());
        out.push_str("\\hline\n");
        for table_line in &self.lines {
            match table_line {
                Line::Row { cells, .. } => {
                    line(&mut out, cells.iter().map(|cell| latex(cell.shown())).collect());
                }
                Line::Rule => out.push_str("\\hline\n"),
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
    use super::super::{Column, Provenance};
    use super::*;

    fn table() -> Table {
        let made_by = Provenance {
            command: "dpn paper".into(),
            program: "dpn 1 (ab)".into(),
            runs: vec!["a-1".into()],
        };
        let columns = Column::all(&["noise"], &["ATE [m]", "p"]);
        let mut table = Table::new("t", "A table", columns).made_by(made_by);
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
}
