//! `dpn eval`.

use super::SensorArg;
use clap::Args;
use std::path::PathBuf;

/// Flags of `dpn eval`.
#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// Estimators on windows with known injected noise, beside the Cramer-Rao bound and the paper's rows.
    #[arg(long, required = true)]
    pub(crate) open_loop: bool,
    /// Folder of ASL sequences, or of datasets as unpacked (euroc/, tumvi/); without it the simulated flights.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// One sensor only.
    #[arg(long, value_enum)]
    pub(crate) sensor: Option<SensorArg>,
    /// Bases, separated by spaces or semicolons; without it the five of the study and raw TUM-VI where there is one.
    #[arg(long, value_name = "BASES")]
    pub(crate) bases: Option<String>,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Folder for tables (CSV) and plots (SVG, PNG).
    #[arg(long, value_name = "DIR", default_value = "runs/open-loop")]
    pub(crate) out: PathBuf,
    /// Seed of the injected noise.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print the rows as JSON on stdout instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
