//! `dpn simulate`.

use super::examples;
use clap::{Args, Subcommand};
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Kinds of simulated data.
#[derive(Debug, Subcommand)]
pub(crate) enum SimulateWhat {
    /// A flight: IMU with exactly known noise, and its ground truth, as an ASL folder.
    #[command(after_help = examples::FLIGHT)]
    Flight(FlightArgs),
    /// Camera tracks along the ground truth of a sequence or along a simulated flight, as a text file.
    #[command(after_help = examples::TRACKS)]
    Tracks(TracksArgs),
    /// Images of a rendered world along the ground truth of a sequence or along a simulated flight, as an ASL folder.
    #[command(after_help = examples::IMAGES)]
    Images(ImagesArgs),
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
    pub(crate) out: ResultPath,
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

/// What tracks and images are made along, and how.
#[derive(Debug, Args)]
pub(crate) struct AlongArgs {
    /// Folder of an ASL sequence with ground truth (EuRoC, TUM-VI), or name of a flight, flown with seed 0.
    #[arg(value_name = "SEQUENCE|FLIGHT")]
    pub(crate) source: String,
    /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one.
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Seed of the world, the light and all noise.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Configuration (TOML); without it the built-in default, which configs/tracks/euroc.toml and configs/images/euroc.toml repeat.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One key of the configuration, over the file: --set world=hall. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = super::closed_loop::key_value)]
    pub(crate) sets: Vec<(String, String)>,
    /// Print what was written as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `dpn simulate tracks`.
#[derive(Debug, Args)]
pub(crate) struct TracksArgs {
    /// What they are made along, and how.
    #[command(flatten)]
    pub(crate) along: AlongArgs,
    /// File to write; without it runs/tracks/NAME.txt.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Flags of `dpn simulate images`.
#[derive(Debug, Args)]
pub(crate) struct ImagesArgs {
    /// What they are made along, and how.
    #[command(flatten)]
    pub(crate) along: AlongArgs,
    /// Folder to write to, one ASL sequence; without it runs/images/NAME. It must not hold a sequence yet.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<ResultPath>,
    /// Seconds after the camera's first frame at which images begin.
    #[arg(long, value_name = "SECONDS")]
    pub(crate) from: Option<f64>,
    /// Seconds after the camera's first frame at which images end.
    #[arg(long, value_name = "SECONDS")]
    pub(crate) to: Option<f64>,
    /// Threads; without it as many as there are cores. The images do not depend on it.
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}
