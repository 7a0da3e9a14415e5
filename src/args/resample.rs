//! `dpn convert`.

use super::LogArgs;
use clap::Args;
use dpn_core::SampleRate;
use dpn_io::ResultPath;

/// Flags of `dpn convert`.
#[derive(Debug, Args)]
pub(crate) struct ResampleArgs {
    /// The log and how it is read.
    #[command(flatten)]
    pub(crate) log: LogArgs,
    /// The rate it gets, lower than its own, behind a low pass; without it, its own samples.
    #[arg(long, value_name = "HZ", value_parser = super::rate)]
    pub(crate) to_rate: Option<SampleRate>,
    /// CSV file for the samples: stamps in ns, rad/s, m/s^2, as in an ASL folder.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: ResultPath,
}
