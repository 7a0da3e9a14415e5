//! `dpn run`.

use super::SettingsArgs;
use clap::Args;
use dpn_eval::closed_loop::StartAt;
use std::path::PathBuf;

/// Flags of `dpn run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of an ASL sequence (EuRoC, TUM-VI), or name of a simulated flight.
    #[arg(value_name = "SEQUENCE|FLIGHT")]
    pub(crate) source: String,
    /// File of camera tracks; without it tracks are made along the ground truth from the seed.
    #[arg(long, value_name = "FILE")]
    pub(crate) tracks: Option<PathBuf>,
    /// Where every sample's noise comes from: x4, const(.3,.02), dualpronet, diff2, file("noise.csv"), ...
    #[arg(long, value_name = "SPEC", default_value = "dualpronet")]
    pub(crate) noise: String,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Seconds after the first frame at which the run begins; `table` as for `dpn eval`.
    #[arg(long, value_name = "SECONDS|table", default_value = "0")]
    pub(crate) from: StartAt,
    /// Seed of simulated flights and tracks.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Settings of the estimator and of what is simulated.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// Folder for trajectory.tum, states.csv and report.json; without it runs/run-NAME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the report as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
