//! `dpn compare`.

use super::{HowArgs, SpanArgs};
use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// The log that is compared with, of any kind that `dpn check` reads.
    #[arg(value_name = "A")]
    pub(crate) first: PathBuf,
    /// The log that may have changed: the same sensor later, mounted otherwise, with other settings.
    #[arg(value_name = "B")]
    pub(crate) second: PathBuf,
    /// Which part of both.
    #[command(flatten)]
    pub(crate) span: SpanArgs,
    /// How both are read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
    /// Folder for the picture of both spectra (SVG, PDF, PNG, CSV) and what has changed (JSON).
    #[arg(long, value_name = "DIR", default_value = "runs/compare")]
    pub(crate) out: ResultPath,
    /// Print what has changed as JSON on stdout instead of the page.
    #[arg(long)]
    pub(crate) json: bool,
}
