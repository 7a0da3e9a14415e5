//! `dpn truth`.

use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn truth`.
#[derive(Debug, Args)]
pub(crate) struct TruthArgs {
    /// Folder of an ASL sequence with ground truth (EuRoC, TUM-VI), or one with several.
    #[arg(value_name = "SEQUENCE|DIR")]
    pub(crate) source: PathBuf,
    /// Folder for NAME.csv, the reconciled ground truth (17 columns), and NAME.json, the report.
    #[arg(long, value_name = "DIR", default_value = "runs/truth")]
    pub(crate) out: ResultPath,
    /// Configuration (TOML); without it the built-in default.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Keep out the published poses beside each second block of so many keys, and say how well they are predicted.
    #[arg(long, value_name = "KEYS")]
    pub(crate) hold_out: Option<usize>,
    /// Print the reports as JSON on stdout, a line a sequence.
    #[arg(long)]
    pub(crate) json: bool,
}
