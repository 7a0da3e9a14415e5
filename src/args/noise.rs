//! `dpn noise`.

use super::{HowArgs, PasteArgs, SpanArgs, examples};
use clap::{Args, Subcommand};
use dpn_io::ResultPath;
use dpn_io::noise_formats::Format;
use std::path::PathBuf;

/// Flags of `dpn noise`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct NoiseArgs {
    /// Work on noise figures instead of a log.
    #[command(subcommand)]
    pub(crate) what: Option<NoiseWhat>,
    /// CSV file, rosbag1, MCAP or rosbag2 (file or folder), or folder of an ASL sequence (EuRoC, TUM-VI); a pipe, or - for stdin. Of several, and of a folder
    /// that holds some, a table with a row each.
    #[arg(value_name = "LOG", required_unless_present_any = ["follow", "learned"], conflicts_with = "follow")]
    pub(crate) logs: Vec<PathBuf>,
    /// Which part of it.
    #[command(flatten)]
    pub(crate) span: SpanArgs,
    /// How the log is read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
    /// Where the noise comes from: dualpronet (the paper's networks), dualpronet(TAG), a simple estimator such as diff2, constants; without it the shipped
    /// networks for raw flights, dualpronet(flight-s0), or diff2 where the log is slower than theirs.
    #[arg(long, value_name = "SPEC")]
    pub(crate) noise: Option<String>,
    /// Samples from one answer to the next.
    #[arg(long, value_name = "SAMPLES", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) every: u32,
    /// Folder with networks of your own, instead of those that come with the program: DIR/accel/NAME.safetensors and DIR/gyro/NAME.safetensors are `--noise 'dualpronet(NAME)'`, at whatever rate they were trained for.
    #[arg(long, value_name = "DIR")]
    pub(crate) weights: Option<PathBuf>,
    /// What these runs of one platform learned (`dpn run --noise self --out RUN`), together; no LOG then.
    #[arg(long, value_name = "RUN", num_args = 1.., conflicts_with_all = ["logs", "follow", "into", "rerun", "check"])]
    pub(crate) learned: Vec<PathBuf>,
    /// Hold the log against this trajectory of the same body: TUM, EuRoC's ground truth, or KITTI with stamps, in metres, of any frame, on the log's clock; noise, biases,
    /// scale, misalignment and delay. A minute or two.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["follow", "into", "rerun", "check", "noise"])]
    pub(crate) against: Option<PathBuf>,
    /// What is pasted.
    #[command(flatten)]
    pub(crate) paste: PasteArgs,
    /// Folder for the track (CSV or JSON lines), the summary (JSON) and the plot (SVG, PDF, PNG, CSV).
    #[arg(long, value_name = "DIR", default_value = "runs/noise")]
    pub(crate) out: ResultPath,
    /// How the track is written.
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = RowFormat::Csv)]
    pub(crate) format: RowFormat,
    /// Write the log again into this MCAP file, its IMU's sensor_msgs/Imu with their covariances filled in; MCAP and rosbag2 of MCAP are copied
    /// message by message, of any other log the samples are written.
    #[arg(long, value_name = "FILE", conflicts_with = "follow")]
    pub(crate) into: Option<PathBuf>,
    /// Write a recording for the viewer of rerun.io, samples and their noise over time; of a dpn built with the feature `rerun`.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "follow")]
    pub(crate) rerun: Option<PathBuf>,
    /// Configuration whose noise figures are held against the log's.
    #[arg(long, value_name = "CONFIG", conflicts_with = "follow")]
    pub(crate) check: Option<PathBuf>,
    /// Whose configuration that is; without it, told from its keys.
    #[arg(long, value_name = "FORMAT", requires = "check")]
    pub(crate) check_as: Option<Format>,
    /// Print the summary as JSON on stdout instead of the page.
    #[arg(long, conflicts_with = "follow")]
    pub(crate) json: bool,
    /// Read CSV lines from stdin and print the deviations as they come; no LOG then.
    #[arg(long)]
    pub(crate) follow: bool,
}

/// Rows of a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum RowFormat {
    /// As `dpn run --noise 'file("PATH")'` reads it.
    Csv,
    /// A JSON object a line.
    Jsonl,
}

/// Kinds of work on noise figures.
#[derive(Debug, Subcommand)]
pub(crate) enum NoiseWhat {
    /// Turn one program's noise figures into another's; the arithmetic goes to stderr, the text to paste to stdout.
    #[command(after_help = examples::CONVERT)]
    Convert(ConvertArgs),
}

/// Flags of `dpn noise convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Configuration to read (YAML or JSON; - for stdin); may be left out where figures are given by flags.
    #[arg(value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
    /// Whose configuration it is; without it, told from its keys: kalibr, openvins, orbslam3, okvis2, basalt, vins, ros, variances, datasheet.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) from: Option<Format>,
    /// Whose configuration to write.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Format,
    /// The IMU's rate; without it, the file's.
    #[arg(long, value_name = "HZ", value_parser = super::rate)]
    pub(crate) rate: Option<dpn_core::SampleRate>,
    /// Rate of the IMU that the output is for, where it is another.
    #[arg(long, value_name = "HZ", value_parser = super::rate)]
    pub(crate) to_rate: Option<dpn_core::SampleRate>,
    /// Accelerometer noise, with its unit: "0.2 mg/sqrt(Hz)", "0.1 m/s/sqrt(h)"; a bare number is a density in SI units.
    #[arg(long, value_name = "FIGURE")]
    pub(crate) accel_noise: Option<String>,
    /// Gyroscope noise, with its unit: "0.005 deg/s/sqrt(Hz)", "0.3 deg/sqrt(h)".
    #[arg(long, value_name = "FIGURE")]
    pub(crate) gyro_noise: Option<String>,
    /// Walk of the accelerometer's bias, with its unit: "3e-3 m/s^3/sqrt(Hz)".
    #[arg(long, value_name = "FIGURE")]
    pub(crate) accel_walk: Option<String>,
    /// Walk of the gyroscope's bias, with its unit: "2e-5 rad/s^2/sqrt(Hz)", "4 deg/h/sqrt(h)".
    #[arg(long, value_name = "FIGURE")]
    pub(crate) gyro_walk: Option<String>,
    /// Print figures, arithmetic, remarks and text as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
