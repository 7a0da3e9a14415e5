//! `dpn noise`.

use clap::{Args, Subcommand};
use dpn_core::noise::formats::Format;
use std::path::PathBuf;

/// What to do with noise figures.
#[derive(Debug, Args)]
pub(crate) struct NoiseArgs {
    /// The work.
    #[command(subcommand)]
    pub(crate) what: NoiseWhat,
}

/// Kinds of work on noise figures.
#[derive(Debug, Subcommand)]
pub(crate) enum NoiseWhat {
    /// Turn one program's noise figures into another's; the arithmetic goes to stderr, the text to paste to stdout.
    Convert(ConvertArgs),
}

/// Flags of `dpn noise convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Configuration to read (YAML or JSON); may be left out where figures are given by flags.
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
