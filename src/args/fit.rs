//! `dpn fit`.

use super::LogArgs;
use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn fit`.
#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// The log and how it is read.
    #[command(flatten)]
    pub(crate) log: LogArgs,
    /// A trajectory of the same body, as `dpn noise --against` takes it: in metres, of any frame and clock.
    #[arg(long, value_name = "FILE")]
    pub(crate) against: PathBuf,
    /// Folder for calibration.json and calibrated.csv, the log's samples under it.
    #[arg(long, value_name = "DIR", default_value = "runs/fit")]
    pub(crate) out: ResultPath,
    /// Print the calibration as JSON on stdout instead of the page.
    #[arg(long)]
    pub(crate) json: bool,
}
