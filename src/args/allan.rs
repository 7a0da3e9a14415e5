//! `dpn allan`.

use super::LogArgs;
use clap::Args;
use dpn_io::ResultPath;
use dpn_io::noise_formats::Format;
use std::path::PathBuf;

/// Flags of `dpn allan`.
#[derive(Debug, Args)]
pub(crate) struct AllanArgs {
    /// The log and how it is read.
    #[command(flatten)]
    pub(crate) log: LogArgs,
    /// Use the whole log, moving parts too.
    #[arg(long)]
    pub(crate) all: bool,
    /// Configuration whose noise figures are held against the log's.
    #[arg(long, value_name = "CONFIG")]
    pub(crate) check: Option<PathBuf>,
    /// Whose configuration that is; without it, told from its keys.
    #[arg(long, value_name = "FORMAT", requires = "check")]
    pub(crate) check_as: Option<Format>,
    /// Folder for the plot (SVG, PDF, PNG), its points (CSV) and the figures (JSON).
    #[arg(long, value_name = "DIR", default_value = "runs/allan")]
    pub(crate) out: ResultPath,
    /// Print the figures as JSON on stdout instead of the page.
    #[arg(long)]
    pub(crate) json: bool,
}
