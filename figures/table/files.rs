//! A table as Markdown, CSV and LaTeX.

use super::{Cell, Column, Line, Table};
use dpn_io::{IoError, ResultPath, write_file};
use std::fmt::Write as _;

impl Table {
    /// As Markdown.
    pub(crate) fn markdown(&self) -> String {
        let escaped = |text: &str| no_html(text).replace('|', "\\|").replace('[', "\\[").replace(']', "\\]");
        let mut out = format!("**{}**\n\n", no_html(&self.title));
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

    /// As CSV: title and notes behind `#`, a header, numbers in full, names without a meaning to a spreadsheet.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let heads: Vec<String> = self.columns.iter().map(|c| no_formula(&c.name)).collect();
        let cell = |(cell, column): (&Cell, &Column)| {
            if column.is_number() { cell.full().to_owned() } else { no_formula(cell.full()) }
        };
        let rows = self.rows().map(|row| row.iter().zip(&self.columns).map(cell).collect());
        for record in std::iter::once(heads).chain(rows) {
            writer.write_record(record).expect("every row has a cell a column, and memory takes it");
        }
        let text = writer.into_inner().expect("memory takes it");
        let title = Some(&self.title).filter(|title| !title.is_empty()).cloned();
        let mut out: String =
            title.into_iter().chain(self.foot()).map(|line| format!("# {}\n", one_line(&line))).collect();
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
    pub fn save(&self, dir: &ResultPath) -> Result<(), IoError> {
        for (extension, text) in [("md", self.markdown()), ("csv", self.csv()), ("tex", self.latex())] {
            write_file(dir.join(format!("{}.{extension}", self.name)), &text)?;
        }
        Ok(())
    }
}

/// Without the ends of lines that a name may hold.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

/// With every `<` escaped that would begin a tag or a comment where Markdown is shown.
fn no_html(text: &str) -> String {
    let text = one_line(text);
    let mut out = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        let next = text[at + c.len_utf8()..].chars().next();
        if c == '<' && next.is_some_and(|next| next.is_ascii_alphabetic() || "/!?".contains(next)) {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

/// With a quote before what a spreadsheet would take for a formula, as OWASP advises; a number is none.
fn no_formula(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    if formula { format!("'{text}") } else { text.to_owned() }
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
    use super::super::Provenance;
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
    fn a_name_is_no_formula_and_no_tag() {
        let mut table = Table::new("t", "Of <b>a</b>", Column::all(&["sequence"], &["m"]));
        for name in [
            "=HYPERLINK(\"u\")",
            "+1+cmd|' /C calc'!A0",
            "-x",
            "@SUM(A1)",
            "\t=1",
            "<script>a</script>",
            "a\nb",
            "-1.5",
            "x<1",
        ] {
            table.row(vec![Cell::text(name), Cell::number(-0.5, 1)]);
        }
        table.note("of\n=1");
        let csv = table.csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines[..4], ["# Of <b>a</b>", "# of =1", "sequence,m", "\"'=HYPERLINK(\"\"u\"\")\",-0.5"]);
        assert_eq!(lines[4..8], ["'+1+cmd|' /C calc'!A0,-0.5", "'-x,-0.5", "'@SUM(A1),-0.5", "'\t=1,-0.5"]);
        assert!(csv.contains("\n-1.5,-0.5\n"), "{csv}");
        let text = table.markdown();
        assert!(text.starts_with("**Of \\<b>a\\</b>**\n"), "{text}");
        assert!(text.contains("| \\<script>a\\</script> |") && text.contains("| a b |"), "{text}");
        assert!(text.contains("| x<1 |") && !text.contains("\n=1"), "{text}");
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
