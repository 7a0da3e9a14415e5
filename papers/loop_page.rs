//! A closed loop as a page and a figure: what `dpn eval --closed-loop` leaves beside its rows. One file without anything from elsewhere, in the style of the paper's page.

use super::forest::Forest;
use super::page::Picture;
use askama::Template;
use dpn_eval::study::Study;
use dpn_figures::{Chart, FigureError, Line, Table};

/// The page.
#[derive(Debug, Template)]
#[template(path = "loop.html")]
pub struct LoopPage<'a> {
    title: String,
    forest: Option<Forest>,
    tables: &'a [Table],
    picture: Option<Picture>,
    made_by: &'a str,
}

impl<'a> LoopPage<'a> {
    /// Of the noises of `study`, with its `tables` and, where there is one, its [`curve`](super::loop_curve); `made_by` is the program and its version.
    ///
    /// # Errors
    /// As [`svg`](dpn_figures::svg).
    pub fn new(
        study: &Study,
        tables: &'a [Table],
        curve: Option<&Chart>,
        made_by: &'a str,
    ) -> Result<Self, FigureError> {
        let picture = |curve: &Chart| {
            Picture::drawn(
                "closed_loop",
                "Errors by what a noise says: constants as a curve, other noises as marks",
                curve,
            )
        };
        let title = match &study.noises[..] {
            [only] => format!("The odometry with the noise {}", only.noise),
            several => format!("The odometry with each of {} noises", several.len()),
        };
        Ok(Self {
            title,
            forest: Forest::of_course(study),
            tables,
            picture: curve.map(picture).transpose()?,
            made_by,
        })
    }

    /// The whole file.
    ///
    /// # Errors
    /// None that is known of.
    pub fn html(&self) -> Result<String, askama::Error> {
        self.render()
    }
}
