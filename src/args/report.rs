//! `dpn report`.

use super::{HowArgs, SpanArgs};
use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn report`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Logs of any kind that `dpn check` reads, or folders of them; a section each.
    #[arg(value_name = "LOG", required = true, num_args = 1..)]
    pub(crate) logs: Vec<PathBuf>,
    /// Which part of each.
    #[command(flatten)]
    pub(crate) span: SpanArgs,
    /// How they are read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
    /// The page: one HTML file that needs nothing else.
    #[arg(long, value_name = "FILE", default_value = "runs/report.html")]
    pub(crate) out: ResultPath,
    /// Folder for every figure of the page as SVG, PDF, PNG and CSV; of several logs a folder each in it.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) figures: Option<ResultPath>,
}
