//! `dpn fleet`.

use super::CacheArgs;
use clap::Args;
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn fleet`.
#[derive(Debug, Args)]
pub(crate) struct FleetArgs {
    /// Platforms and noises (TOML), as configs/fleet/fleet.toml.
    #[arg(value_name = "FLEET.toml")]
    pub(crate) plan: PathBuf,
    /// Folder of the datasets as unpacked (euroc/, tumvi/, motion/), which the platforms' `data` are looked for in.
    #[arg(long, value_name = "DIR", default_value = "data")]
    pub(crate) data: PathBuf,
    /// Folder of the results: a folder a platform, fleet.csv, fleet.json and fleet.txt. A fleet goes on where it stopped.
    #[arg(long, value_name = "DIR", default_value = "runs/fleet")]
    pub(crate) out: ResultPath,
    /// Only these platforms, by their folders, with commas between.
    #[arg(long, value_name = "FOLDERS", value_delimiter = ',')]
    pub(crate) platforms: Vec<String>,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Threads; without it as many as there are cores. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) cache: CacheArgs,
    /// Print fleet.json on stdout instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}
