//! `dpn eval`.

use super::ClosedLoopArgs;
use super::word::word;
use clap::{ArgGroup, Args};
use dpn_core::Sensor;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn eval`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("judged").required(true).args(["open_loop", "closed_loop", "inertial"])))]
pub(crate) struct EvalArgs {
    /// Estimators on windows with known injected noise, beside the Cramer-Rao bound and the paper's rows.
    #[arg(long)]
    pub(crate) open_loop: bool,
    /// The odometry, told its noise by each of several sources, beside the paper's rows and VINS-Mono's.
    #[arg(long)]
    pub(crate) closed_loop: bool,
    /// Corrections of a gyroscope against trajectories, by the figures of the papers that learn them; FILE says the sequences, as configs/inertial/euroc.toml,
    /// --models where networks of `dpn train --model inertial` lie.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["sensor", "bases", "more_models"])]
    pub(crate) inertial: Option<PathBuf>,
    /// Folder of ASL sequences, or of datasets as unpacked (euroc/, tumvi/); without it the simulated flights.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// One sensor only: accel or gyro.
    #[arg(long, value_parser = word::<Sensor>, conflicts_with = "closed_loop")]
    pub(crate) sensor: Option<Sensor>,
    /// Bases, separated by spaces or semicolons; without it the five of the study and raw TUM-VI where there is one.
    #[arg(long, value_name = "BASES", conflicts_with = "closed_loop")]
    pub(crate) bases: Option<String>,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Folder of the other networks of the study, judged in the open loop beside those that come with the program; where it is.
    #[arg(long, value_name = "DIR", default_value = "papers/networks", conflicts_with_all = ["models", "closed_loop"])]
    pub(crate) more_models: PathBuf,
    /// Folder of the results: runs/open-loop, or runs/closed-loop- and a checksum of settings and input; a closed loop goes on where
    /// it stopped.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<ResultPath>,
    /// Seed of the injected noise; in a closed loop the first seed of tracks and flights.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print the rows as JSON on stdout instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// Flags of the closed loop.
    #[command(flatten, next_help_heading = "Closed loop")]
    pub(crate) closed: ClosedLoopArgs,
}
