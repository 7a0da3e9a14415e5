//! `dpn check`.

use super::LogArgs;
use clap::Args;
use std::path::PathBuf;

/// Flags of `dpn check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The log and how it is read.
    #[command(flatten)]
    pub(crate) log: LogArgs,
    /// Folder for the spectra (SVG, PNG, CSV) and the findings (JSON).
    #[arg(long, value_name = "DIR", default_value = "runs/check")]
    pub(crate) out: PathBuf,
    /// Print the findings as JSON on stdout instead of the page.
    #[arg(long)]
    pub(crate) json: bool,
}
