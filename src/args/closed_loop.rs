//! What is said of a closed loop: sequences, tracks, noises, seeds, the estimator.

use super::word::word;
use clap::Args;
use dpn_eval::closed_loop::{Camera, StartAt};
use std::path::PathBuf;

/// Flags of `dpn eval --closed-loop`.
#[derive(Debug, Args)]
pub(crate) struct ClosedLoopArgs {
    /// What the odometry sees: tracks (given, or made along the ground truth), images (the sequence's own), or rendered (along the ground truth, while it runs).
    #[arg(long, value_parser = word::<Camera>, default_value = "tracks", conflicts_with = "open_loop")]
    pub(crate) camera: Camera,
    /// Folder with camera tracks, SEQUENCE.txt each; without it tracks are made along the ground truth from the seed.
    #[arg(long, value_name = "DIR", requires = "data")]
    pub(crate) tracks: Option<PathBuf>,
    /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one. Of a log with images, also a file of true poses.
    #[arg(long, value_name = "DIR", requires = "data", conflicts_with = "open_loop")]
    pub(crate) truth: Option<PathBuf>,
    /// Pass over images that are listed but not there, instead of stopping before the first run.
    #[arg(long, conflicts_with = "open_loop")]
    pub(crate) skip_missing: bool,
    /// Where --data is a bag: its topic of images; without it, the only one.
    #[arg(long, value_name = "TOPIC", requires = "data", conflicts_with = "open_loop")]
    pub(crate) image_topic: Option<String>,
    /// Where --data is a bag: its IMU's topic; without it, the only one.
    #[arg(long, value_name = "TOPIC", requires = "data", conflicts_with = "open_loop")]
    pub(crate) topic: Option<String>,
    /// `all`, or names (MH_01, hover) with commas between.
    #[arg(long, value_name = "NAMES", default_value = "all", conflicts_with = "open_loop")]
    pub(crate) sequences: String,
    /// Noise specs with commas between; with semicolons or blanks between where a spec holds a comma: 'x1; x4,x1; mean(x4,x1)'.
    #[arg(
        long,
        value_name = "SPECS",
        default_value = "x0.5,x1,x2,x4,x8,self,dualpronet",
        conflicts_with = "open_loop"
    )]
    pub(crate) noise: String,
    /// How many seeds of tracks (and flights), from --seed on.
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "open_loop", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) seeds: u64,
    /// Seconds after the first frame at which runs begin; `table`: 40 in MH_01, 35 in MH_02, 0 elsewhere, as VINS-Mono's runs of the table.
    #[arg(long, value_name = "SECONDS|table", default_value_t, conflicts_with = "open_loop")]
    pub(crate) from: StartAt,
    /// Seconds after the first frame (or image listed) at which runs end.
    #[arg(long, value_name = "SECONDS", conflicts_with = "open_loop", value_parser = super::run::seconds)]
    pub(crate) to: Option<f64>,
    /// Add noise of a known course to every recording (TOML, as configs/injected/step.toml); `oracle` then says the noise added.
    #[arg(long, value_name = "FILE", conflicts_with = "open_loop")]
    pub(crate) inject: Option<PathBuf>,
    /// Settings of the estimator and of what is simulated.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// Threads; without it as many as there are cores. Results do not depend on it.
    #[arg(long, value_name = "N", conflicts_with = "open_loop")]
    pub(crate) threads: Option<usize>,
    /// Where tracks are kept.
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
    /// Write every run's trajectory (TUM format) into the folder.
    #[arg(long, conflicts_with = "open_loop")]
    pub(crate) trajectories: bool,
}

/// Settings of the estimator and of what is simulated.
#[derive(Debug, Clone, Args)]
pub(crate) struct SettingsArgs {
    /// Configuration of the estimator (TOML); without it the built-in default, which configs/run/vio.toml repeats.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One key of the estimator's configuration, over the file: --set imu.imu_cov=vins. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) sets: Vec<(String, String)>,
    /// Calibration of the camera, instead of the sensor.yaml that lies with it (and of simulated cameras): Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS2, ASL.
    #[arg(long, value_name = "FILE")]
    pub(crate) calib: Option<PathBuf>,
    /// Configuration of simulated tracks (TOML), as for `dpn simulate tracks`.
    #[arg(long, value_name = "FILE")]
    pub(crate) tracks_config: Option<PathBuf>,
    /// Configuration of the rendered camera (TOML), as for `dpn simulate images`.
    #[arg(long, value_name = "FILE")]
    pub(crate) images_config: Option<PathBuf>,
    /// Configuration of simulated flights (TOML), as for `dpn simulate flight`.
    #[arg(long, value_name = "FILE")]
    pub(crate) flight_config: Option<PathBuf>,
    /// Simulated flights without rotor vibration.
    #[arg(long)]
    pub(crate) no_vibration: bool,
}

/// `KEY=VALUE` in two.
pub(super) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err(format!("`{text}` is not KEY=VALUE, for example window.key_frames=8")),
    }
}
