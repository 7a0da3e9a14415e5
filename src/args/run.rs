//! `dpn run`.

use super::word::word;
use super::{ImageLogArgs, PasteArgs, SettingsArgs};
use clap::Args;
use dpn_eval::closed_loop::{Camera, StartAt};
use dpn_io::ResultPath;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Flags of `dpn run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of an ASL sequence (EuRoC, TUM-VI), a log with images (rosbag1, MCAP, rosbag2, a folder with times.txt), name of a
    /// simulated flight, or a bag as it is recorded: a pipe, or - for stdin, whose poses are printed as they are made.
    #[arg(value_name = "SEQUENCE|LOG|FLIGHT|-")]
    pub(crate) source: String,
    /// What the odometry sees: tracks, images or rendered; without it the folder's images where it holds any, else tracks.
    #[arg(long, value_parser = word::<Camera>)]
    pub(crate) camera: Option<Camera>,
    /// File of camera tracks; without it tracks are made along the ground truth from the seed.
    #[arg(long, value_name = "FILE")]
    pub(crate) tracks: Option<PathBuf>,
    /// Of a sequence, folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one. Of a log with images, file of true
    /// poses of the IMU: a trajectory as evo reads it (TUM), or EuRoC's ground truth.
    #[arg(long, value_name = "DIR|FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Where every sample's noise comes from: self (the odometry estimates it while it runs), x4, const(.3,.02), dualpronet, diff2, file("noise.csv"), ...
    #[arg(long, value_name = "SPEC", default_value = "self")]
    pub(crate) noise: String,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Seconds after the first frame (or image listed) at which the run begins; `table` as for `dpn eval`.
    #[arg(long, value_name = "SECONDS|table", default_value_t)]
    pub(crate) from: StartAt,
    /// Seconds after the first frame (or image listed) at which the run ends.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) to: Option<f64>,
    /// Pass over images that are listed but not there, instead of stopping before the run.
    #[arg(long)]
    pub(crate) skip_missing: bool,
    /// Seconds to add to the camera's stamps (less than zero where they are late), beyond what its calibration says; without it they are found from the turns
    /// of camera and gyroscope, up to a quarter of a second.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) time_offset: Option<f64>,
    /// How a log with images is read.
    #[command(flatten)]
    pub(crate) log: ImageLogArgs,
    /// Seed of simulated flights and tracks.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Settings of the estimator and of what is simulated.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// Folder for trajectory.tum, states.csv and report.json; without it runs/run-NAME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<ResultPath>,
    /// Write poses, truth, noise, biases, levels and, of images, two a second with their tracks also into this MCAP file, which Foxglove shows.
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    /// Write a recording for the viewer of rerun.io, trajectory, truth, camera, tracks, landmarks, noise, biases and levels on one time line; of a dpn built with the feature `rerun`.
    #[arg(long, value_name = "FILE.rrd")]
    pub(crate) rerun: Option<PathBuf>,
    /// Of what is read as it comes: show it while it runs to Foxglove (its WebSocket): image with tracks, path, biases, levels, latency; on this machine alone unless another address is given (0.0.0.0:8765). Of a dpn built with the feature `view`, as a release's is.
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    pub(crate) view: Option<SocketAddr>,
    /// Gone: `dpn rpe`.
    #[arg(long, hide = true, num_args = 0..=1, default_missing_value = "", value_parser = gone_rpe)]
    rpe: Option<String>,
    /// Gone: `dpn ape` and `dpn rpe` read what the run leaves.
    #[arg(long, hide = true, num_args = 0..=1, default_missing_value = "", value_parser = gone_kitti)]
    kitti: Option<String>,
    /// Draw into this folder: the flight from above, tracks, noise, biases and residuals over time, and, of images, frames with tracks.
    #[arg(long, value_name = "DIR")]
    pub(crate) draw: Option<ResultPath>,
    /// A frame is drawn every so many seconds; 0 draws every frame handed over.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, requires = "draw", value_parser = seconds)]
    pub(crate) draw_every: f64,
    /// What is pasted of the noise that is learned.
    #[command(flatten)]
    pub(crate) paste: PasteArgs,
    /// Exit with code 3 where the run is not to be trusted: camera and gyroscope do not turn together, or residuals or levels are no sensor's. A run without any pose always does.
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print the report as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

fn gone_rpe(_: &str) -> Result<String, String> {
    Err("write `dpn rpe TRUTH RUN -d 1 -u m` after the run: --rpe is gone".to_owned())
}

fn gone_kitti(_: &str) -> Result<String, String> {
    Err("--kitti is gone: `dpn ape TRUTH RUN` and `dpn rpe` take the run's trajectory.tum, and so do evo_ape and evo_rpe".to_owned())
}

/// A number of seconds from 0.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(seconds),
        _ => Err(format!("`{text}` is not a number of seconds from 0")),
    }
}
