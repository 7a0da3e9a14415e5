//! `dpn simulate`.

use super::set::set;
use super::world::WorldArg;
use super::{ImagesArgs, examples};
use clap::{Args, Subcommand};
use dpn_sim::tracks::{TracksConfig, World};
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
    pub(crate) out: PathBuf,
    /// Seed of every random part.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Configuration of the noise parts (TOML).
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Write a recording for the viewer of rerun.io, the way, samples and their noise; of a dpn built with the feature `rerun`.
    #[arg(long, value_name = "FILE.rrd")]
    pub(crate) rerun: Option<PathBuf>,
    /// Print what was written as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `dpn simulate tracks`. A flag overrides the configuration's key of the same meaning.
#[derive(Debug, Args)]
pub(crate) struct TracksArgs {
    /// Folder of an ASL sequence with ground truth (EuRoC, TUM-VI), or name of a flight.
    #[arg(value_name = "SEQUENCE|FLIGHT")]
    pub(crate) source: String,
    /// File to write; without it runs/tracks/NAME.txt.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one.
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Seed of the world and of the tracker's errors.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Seed that the flight is flown with, as in `dpn simulate flight --seed`.
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub(crate) flight_seed: u64,
    /// Configuration (TOML); without it the built-in default, which configs/tracks/euroc.toml repeats.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Kind of world.
    #[arg(long, value_enum)]
    world: Option<WorldArg>,
    /// Most points followed at a time.
    #[arg(long, value_name = "N")]
    max_tracks: Option<usize>,
    /// Frames handed over a second.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Standard deviation of the white noise, each axis, in pixels.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pixel_noise: Option<f64>,
    /// Drift added at every camera frame, each axis, in pixels.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    drift: Option<f64>,
    /// Share of the tracks that turn into outliers at a camera frame.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    outliers: Option<f64>,
    /// Mean time after which a track ends for no reason, in seconds.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    life_time: Option<f64>,
    /// Tracks of time t are made from the pose at t + this, in seconds, as if the ground truth were late.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    ground_truth_delay: Option<f64>,
    /// Print what was written as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

impl TracksArgs {
    /// Puts what was typed over `config`.
    pub(crate) fn over(&self, config: &mut TracksConfig) {
        set(self.world.map(World::from), &mut config.world);
        set(self.max_tracks, &mut config.max_tracks);
        set(self.rate, &mut config.rate_hz);
        set(self.pixel_noise, &mut config.pixel_noise_px);
        set(self.drift, &mut config.drift_px);
        set(self.outliers, &mut config.outlier_share);
        set(self.life_time, &mut config.life_time_s);
        set(self.ground_truth_delay, &mut config.ground_truth_delay_s);
    }
}
