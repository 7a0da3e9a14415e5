//! `dpn export`.

use super::examples;
use clap::{Args, Subcommand};
use dpn_io::ResultPath;
use std::path::PathBuf;

/// What networks can be written as.
#[derive(Debug, Subcommand)]
pub(crate) enum ExportWhat {
    /// ONNX models: windows in SI units in, deviations out; ONNX Runtime and others run them.
    #[command(after_help = examples::ONNX)]
    Onnx(OnnxArgs),
}

/// Flags of `dpn export onnx`.
#[derive(Debug, Args)]
pub(crate) struct OnnxArgs {
    /// Names of networks, as files of weights and noise specs call them (`sg11-s0`), of either sensor; without any all of them.
    #[arg(long = "network", value_name = "NAME", value_delimiter = ',')]
    pub(crate) networks: Vec<String>,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// A network of `dpn train --model inertial` (runs/.../network.safetensors) instead: a gyroscope's bias, inertial/NAME-sSEED.onnx.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["networks", "models"])]
    pub(crate) inertial: Option<PathBuf>,
    /// Folder for the models, SENSOR/NAME.onnx each.
    #[arg(long, value_name = "DIR", default_value = "onnx")]
    pub(crate) out: ResultPath,
    /// Print what was written as JSON on stdout, a line a model.
    #[arg(long)]
    pub(crate) json: bool,
}
