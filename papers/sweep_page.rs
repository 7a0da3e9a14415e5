//! How far a sweep is, as a page: one file without scripts and without anything from elsewhere.

use askama::Template;
use dpn_eval::sweeps::{ShardState, SweepStatus};
use std::path::Path;

#[derive(Debug, Template)]
#[template(path = "sweep.html")]
struct SweepPage<'a> {
    name: String,
    status: &'a SweepStatus,
}

impl SweepPage<'_> {
    fn share(done: &usize, of: &usize) -> usize {
        100 * done / (*of).max(1)
    }

    fn state(state: &ShardState) -> &'static str {
        match state {
            ShardState::Waiting => "waiting",
            ShardState::Running => "running",
            ShardState::BrokenOff => "broken off",
            ShardState::Failed => "failed cells",
            ShardState::Done => "done",
        }
    }

    fn minutes(seconds: &f64) -> String {
        format!("{:.1}", seconds / 60.0)
    }
}

/// The page of a sweep in `dir`.
///
/// # Panics
/// Never: a template that compiled writes to a string.
pub fn sweep_page(dir: &Path, status: &SweepStatus) -> String {
    let page = SweepPage { name: dir.display().to_string(), status };
    page.render().expect("a template that compiled writes to a string")
}
