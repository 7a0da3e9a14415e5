//! `dpn check`.

use super::{HowArgs, SpanArgs};
use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// What a check is not to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FailOn {
    /// What throws an estimator off; a log that cannot be read.
    Bad,
    /// What is worth a look, too.
    Warning,
}

/// Flags of `dpn check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Logs: each a CSV file, rosbag1, MCAP, rosbag2, ULog or ArduPilot log, packed or not, folder of an ASL sequence, of a rosbag2, of images with an IMU's file or
    /// of a phone's two files, or its zip; a pipe, or - for stdin. Of several, and of a folder that holds some, a table with a row each.
    #[arg(value_name = "LOG", required = true, num_args = 1..)]
    pub(crate) logs: Vec<PathBuf>,
    /// Which part of it.
    #[command(flatten)]
    pub(crate) span: SpanArgs,
    /// How it is read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
    /// Exit with code 3 where something as grave is found: bad, or warning.
    #[arg(long, value_name = "WEIGHT", value_enum)]
    pub(crate) fail_on: Option<FailOn>,
    /// Folder for the spectra (SVG, PDF, PNG, CSV) and the findings (JSON).
    #[arg(long, value_name = "DIR", default_value = "runs/check")]
    pub(crate) out: ResultPath,
    /// Print the findings as JSON on stdout instead of the page.
    #[arg(long)]
    pub(crate) json: bool,
}
