//! The page and the folder's README: what their templates (`templates/`) are filled with.
//!
//! The page tells the story in the order in which a reader asks: does it help, what are the data, when does it, how well does it say the noise,
//! what is it. One file without anything from elsewhere; its script sorts tables and enlarges pictures, and nothing is missing without it.

use super::forest::Forest;
use super::injected::Response;
use super::input::Input;
use super::specs;
use super::verdict::Verdict;
use askama::Template;
use dpn_eval::injected::Course;
use dpn_eval::study::Study;
use dpn_figures::{FigureError, Line, Plot, Provenance, Table, svg};
use std::fmt::Write as _;

/// A figure as it is put on the page.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) name: &'static str,
    pub(super) title: String,
    pub(super) runs: Vec<String>,
    pub(super) svg: String,
}

impl Picture {
    /// A plot, where no runs are named.
    pub(super) fn drawn(name: &'static str, title: &str, plot: &impl Plot) -> Result<Self, FigureError> {
        let svg = String::from_utf8_lossy(&svg(plot)?).into_owned();
        Ok(Self { name, title: title.to_owned(), runs: Vec::new(), svg })
    }

    /// The SVG as the address of an image.
    pub(super) fn address(&self) -> String {
        let mut out = String::with_capacity(self.svg.len() + self.svg.len() / 8);
        out.push_str("data:image/svg+xml;charset=utf-8,");
        for c in self.svg.chars() {
            match c {
                '\n' => out.push(' '),
                '"' => out.push('\''),
                '%' | '#' | '<' | '>' | '&' | '\'' => {
                    let _ = write!(out, "%{:02X}", c as u32);
                }
                other => out.push(other),
            }
        }
        out
    }
}

/// The page.
#[derive(Debug, Template)]
#[template(path = "page.html")]
pub(super) struct Page<'a> {
    pub(super) input: &'a Input,
    pub(super) verdict: &'a Verdict,
    /// The study's noises and those given under added noise, against their best constants.
    pub(super) forest: Option<Forest>,
    pub(super) added: Option<Forest>,
    /// What is called otherwise than it is written: name and spec.
    pub(super) names: Vec<(String, String)>,
    pub(super) findings: &'a [String],
    pub(super) tables: &'a [Table],
    pub(super) pictures: &'a [Picture],
    pub(super) made_by: &'a Provenance,
}

impl Page<'_> {
    /// The figure of that name, where it was drawn.
    fn picture(&self, name: &str) -> Option<&Picture> {
        self.pictures.iter().find(|picture| picture.name == name)
    }

    /// The table of that name, where it was made.
    fn table(&self, name: &str) -> Option<&Table> {
        self.tables.iter().find(|table| table.name == name)
    }
}

/// Every noise that is called otherwise than it is written: name and spec.
pub(super) fn called(
    study: &Study,
    courses: &[(Course, Study)],
    responses: &[Response],
) -> Vec<(String, String)> {
    let of_study = study.noises.iter().map(|line| &line.noise);
    let of_courses = courses.iter().flat_map(|(_, of)| &of.noises).map(|line| &line.noise);
    let all = of_study.chain(of_courses).chain(responses.iter().map(|response| &response.noise));
    let mut names: Vec<(String, String)> = Vec::new();
    for noise in all {
        let pair = (specs::name(noise), noise.to_string());
        if pair.0 != pair.1 && !names.contains(&pair) {
            names.push(pair);
        }
    }
    names
}

/// The folder's README: figure, what it shows, runs; the command once.
#[derive(Debug, Template)]
#[template(path = "folder.md", escape = "none")]
pub(super) struct Readme<'a> {
    pub(super) input: &'a Input,
    pub(super) tables: &'a [Table],
    pub(super) pictures: &'a [Picture],
    pub(super) made_by: &'a Provenance,
}

impl Readme<'_> {
    /// Runs between backquotes.
    fn code(runs: &[String]) -> String {
        runs.iter().map(|run| format!("`{run}`")).collect::<Vec<_>>().join(", ")
    }

    /// Without what Markdown takes for a link.
    fn bare(title: &str) -> String {
        title.replace('[', "\\[").replace(']', "\\]")
    }

    fn runs(table: &Table) -> &[String] {
        table.made_by.as_ref().map_or(&[], |made_by| &made_by.runs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_svg_becomes_an_address_without_marks_that_end_it() {
        let svg = "<svg fill=\"#fff\">\n50 % & more</svg>".to_owned();
        let address = Picture { name: "a", title: String::new(), runs: Vec::new(), svg }.address();
        assert!(address.starts_with("data:image/svg+xml"));
        let body = &address["data:image/svg+xml;charset=utf-8,".len()..];
        assert!(!body.contains(['<', '>', '"', '#', '\n', '&']), "{body}");
        assert!(body.contains("fill='%23fff'") && body.contains("50 %25 %26"), "{body}");
    }
}
