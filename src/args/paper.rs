//! `dpn paper`.

use super::SettingsArgs;
use super::word::word;
use clap::Args;
use dpn_eval::closed_loop::StartAt;
use dpn_io::ResultPath;
use dpn_papers::CameraChoice;
use std::path::PathBuf;

/// Flags of `dpn paper`.
#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// Folder of EuRoC's sequences, or of datasets as unpacked (euroc/, tumvi/); without it the simulated flights.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// A few minutes' worth: fewer noises, one seed.
    #[arg(long, conflicts_with = "plan")]
    pub(crate) quick: bool,
    /// What is run (TOML); without it the whole study, which configs/paper/whole.toml repeats.
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: Option<PathBuf>,
    /// Folder of tables, figures and page.
    #[arg(long, value_name = "DIR", default_value = "runs/paper/out")]
    pub(crate) out: ResultPath,
    /// Folder of the runs; results of other inputs in it are neither used nor touched.
    #[arg(long, value_name = "DIR", default_value = "runs/paper")]
    pub(crate) work: ResultPath,
    /// What the odometry sees: images, rendered (along the ground truth), tracks, or auto: images where every sequence has its own, else
    /// rendered, but tracks with --quick.
    #[arg(long, value_parser = word::<CameraChoice>, default_value = "auto")]
    pub(crate) camera: CameraChoice,
    /// Folder with camera tracks, SEQUENCE.txt each; without it tracks are made along the ground truth from the seed.
    #[arg(long, value_name = "DIR", requires = "data")]
    pub(crate) tracks: Option<PathBuf>,
    /// `all`, or names (MH_01, hover) with commas between.
    #[arg(long, value_name = "NAMES", default_value = "all")]
    pub(crate) sequences: String,
    /// Seconds after the first frame at which runs begin; `table`: 40 in MH_01, 35 in MH_02, 0 elsewhere.
    #[arg(long, value_name = "SECONDS|table", default_value_t)]
    pub(crate) from: StartAt,
    /// Folder of trained networks, instead of those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Folder of the other networks of the study, judged in the open loop beside those that come with the program; where it is.
    #[arg(long, value_name = "DIR", default_value = "papers/networks", conflicts_with = "models")]
    pub(crate) more_models: PathBuf,
    /// Settings of the estimator and of what is simulated.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// Threads; without it as many as there are cores. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Where tracks are kept.
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
    /// Run nothing: make tables, figures and page of the runs of another build of this version, named by the checksum that its tables give.
    #[arg(long, value_name = "CHECKSUM")]
    pub(crate) measured_by: Option<String>,
    /// Print stages, findings and files as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
