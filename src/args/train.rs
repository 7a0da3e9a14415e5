//! `dpn train`.

use super::closed_loop::key_value;
use super::word::word;
use clap::Args;
use dpn_core::{SampleRate, Sensor};
use dpn_io::ResultPath;
use std::path::PathBuf;

/// Flags of `dpn train`. A flag overrides the configuration's key of the same name.
#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Which sensor's network to train: accel or gyro.
    #[arg(long, value_parser = word::<Sensor>, required_unless_present_any = ["many", "model"])]
    pub(crate) sensor: Option<Sensor>,
    /// What else may be trained: inertial, a slow correction of a gyroscope against trajectories; --config says its sequences below --data, as configs/inertial/euroc.toml.
    #[arg(long, value_name = "MODEL", value_parser = ["inertial"], requires = "config", conflicts_with_all = ["sensor", "many", "epochs", "base", "rate", "device"])]
    pub(crate) model: Option<String>,
    /// Train many networks at once, as a plan asks for them (TOML, as configs/sweep/train.toml): sensors x configurations x seeds.
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["sensor", "config", "sets", "resume", "seed", "epochs", "base", "rate"])]
    pub(crate) many: Option<PathBuf>,
    /// Trainings at a time; without it as many as there are cores, on a GPU 16.
    #[arg(long, value_name = "N", requires = "many", value_parser = clap::value_parser!(u64).range(1..=4096))]
    pub(crate) jobs: Option<u64>,
    /// Configuration (TOML); without it the built-in default, which configs/train/{accel,gyro}.toml repeat.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One key of the configuration, over the file: --set network.block_order=conv-act-norm. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) sets: Vec<(String, String)>,
    /// Folder of ASL sequences (EuRoC, TUM-VI); without it the simulated flights.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Folder of the run; without it runs/train-SENSOR-BASE-SEED.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<ResultPath>,
    /// Go on with the run in the folder, to the same bits as if it had never stopped. With --epochs a run of a constant learning rate, finished or
    /// not, becomes longer, to the bits of one as long from the start.
    #[arg(long)]
    pub(crate) resume: bool,
    /// Seed of every draw and of the initial weights.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Epochs; one epoch shows every training window `draws_per_window` times.
    #[arg(long)]
    pub(crate) epochs: Option<u64>,
    /// Base that noise is injected into: `raw`, `gaussian` or `sg(WINDOW,ORDER)`.
    #[arg(long, value_name = "BASE")]
    pub(crate) base: Option<dpn_train::base::Base>,
    /// Rate of the samples that the network is for, in Hz: faster recordings are brought to it, as means over blocks where the ratio is whole. Windows of one second,
    /// where the configuration has none of its own.
    #[arg(long, value_name = "HZ", value_parser = super::rate)]
    pub(crate) rate: Option<SampleRate>,
    /// Where to compute: cpu, or ndarray (of burn), wgpu (a GPU), where built with that feature. Without it cpu, or the plan's.
    #[arg(long)]
    pub(crate) device: Option<String>,
    /// Print the training summary as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}
