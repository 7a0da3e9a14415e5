//! `dpn train`.

use clap::{Args, ValueEnum};
use dpn_core::Sensor;
use std::path::PathBuf;

/// Sensor as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SensorArg {
    /// Accelerometer.
    Accel,
    /// Gyroscope.
    Gyro,
}

impl From<SensorArg> for Sensor {
    fn from(arg: SensorArg) -> Self {
        match arg {
            SensorArg::Accel => Self::Accel,
            SensorArg::Gyro => Self::Gyro,
        }
    }
}

/// Flags of `dpn train`. A flag overrides the configuration's key of the same name.
#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Which sensor's network to train.
    #[arg(long, value_enum)]
    pub(crate) sensor: SensorArg,
    /// Configuration (TOML); without it the built-in default, which configs/train/{accel,gyro}.toml repeat.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Folder of ASL sequences (EuRoC, TUM-VI); without it the simulated flights.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Folder of the run; without it runs/train-SENSOR-BASE-SEED.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run in the folder, to the same bits as if it had never stopped.
    #[arg(long)]
    pub(crate) resume: bool,
    /// Seed of every draw and of the initial weights.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Epochs; one epoch shows every training window `draws_per_window` times.
    #[arg(long)]
    pub(crate) epochs: Option<u64>,
    /// Base that noise is injected into: `raw` or `sg(WINDOW,ORDER)`.
    #[arg(long, value_name = "BASE")]
    pub(crate) base: Option<dpn_train::base::Base>,
    /// Where to compute: flex (CPU), or ndarray, wgpu, cuda where built with that feature.
    #[arg(long, default_value = "flex")]
    pub(crate) device: String,
    /// Print the training summary as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
