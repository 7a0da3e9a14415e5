//! What logs say of their IMU as one page: `dpn report`. One file without anything from elsewhere, for screen, phone and paper, in the style of the paper's page.

use super::page::Picture;
use askama::Template;
use dpn_figures::{FigureError, Plot};

/// A finding, in words.
#[derive(Debug, Clone)]
pub struct FindingWords {
    /// `bad`, `warning` or `note`.
    pub weight: String,
    /// What it is about, one word.
    pub about: String,
    /// What was found.
    pub text: String,
    /// What to do about it.
    pub remedy: Option<String>,
}

/// What is said of one log.
#[derive(Debug, Default)]
pub struct LogSection {
    /// Its name.
    pub name: String,
    /// Samples, length, rate; or why it cannot be read.
    pub facts: String,
    /// The gravest first.
    pub findings: Vec<FindingWords>,
    pub(super) pictures: Vec<Picture>,
    /// Title and text, aligned by blanks.
    pub texts: Vec<(String, String)>,
    /// Programs and the lines that they read.
    pub lines: Vec<(String, String)>,
}

impl LogSection {
    /// Of a log of which nothing is said yet but its name and facts.
    pub fn new(name: String, facts: String) -> Self {
        Self { name, facts, ..Self::default() }
    }

    /// Adds a figure, under a name that tells it from the others.
    ///
    /// # Errors
    /// As [`svg`](dpn_figures::svg).
    pub fn draw(&mut self, name: &'static str, title: &str, plot: &impl Plot) -> Result<(), FigureError> {
        self.pictures.push(Picture::drawn(name, title, plot)?);
        Ok(())
    }
}

/// The page.
#[derive(Debug, Template)]
#[template(path = "report.html")]
pub struct LogReport {
    /// A section a log.
    pub logs: Vec<LogSection>,
    /// The program and its version.
    pub made_by: String,
}

impl LogReport {
    fn title(&self) -> String {
        match &self.logs[..] {
            [only] => format!("What {} says of its IMU", only.name),
            several => format!("What {} logs say of their IMUs", several.len()),
        }
    }

    /// Of the headings in a section: its own, of several logs, is one above them.
    fn level(&self) -> usize {
        if self.logs.len() > 1 { 3 } else { 2 }
    }

    /// The whole file.
    ///
    /// # Errors
    /// None that is known of.
    pub fn html(&self) -> Result<String, askama::Error> {
        self.render()
    }
}
