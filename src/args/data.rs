//! `dpn data`.

use super::examples;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// What to do with a data set.
#[derive(Debug, Args)]
pub(crate) struct DataArgs {
    /// The step.
    #[command(subcommand)]
    pub(crate) what: DataWhat,
}

/// Steps with data packs.
#[derive(Debug, Subcommand)]
pub(crate) enum DataWhat {
    /// Put a folder of sequences into one file: samples, ground truth, calibration and stamps; images stay where they are. Every --data takes it.
    #[command(after_help = examples::DATA_PACK)]
    Pack(DataPackArgs),
    /// List what a data pack holds; nothing but its header is read.
    #[command(after_help = examples::DATA_LIST)]
    List(DataFileArgs),
    /// Read a data pack whole and hold every part to its checksum: what is damaged, by its part (exit code 2).
    #[command(after_help = examples::DATA_CHECK)]
    Check(DataFileArgs),
}

/// Flags of `dpn data pack`.
#[derive(Debug, Args)]
pub(crate) struct DataPackArgs {
    /// Folder of ASL sequences, or of datasets as unpacked (euroc/, tumvi/).
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// The file.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// Flags of `dpn data list` and `dpn data check`.
#[derive(Debug, Args)]
pub(crate) struct DataFileArgs {
    /// The pack.
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Print JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
