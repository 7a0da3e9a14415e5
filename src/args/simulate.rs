//! `dpn simulate`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// What to simulate.
#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// The kind of data.
    #[command(subcommand)]
    pub(crate) what: SimulateWhat,
}

/// Kinds of simulated data.
#[derive(Debug, Subcommand)]
pub(crate) enum SimulateWhat {
    /// A flight: IMU with exactly known noise, and its ground truth, as an ASL folder.
    Flight(FlightArgs),
}

/// Flags of `dpn simulate flight`.
#[derive(Debug, Args)]
pub(crate) struct FlightArgs {
    /// Name of a flight, or `all`.
    #[arg(required_unless_present = "list")]
    pub(crate) name: Option<String>,
    /// Name the flights and stop.
    #[arg(long)]
    pub(crate) list: bool,
    /// Folder to write to: one ASL sequence a flight.
    #[arg(long, value_name = "DIR", default_value = "runs/flights")]
    pub(crate) out: PathBuf,
    /// Seed of every random part.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Configuration of the noise parts (TOML).
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Print what was written as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
