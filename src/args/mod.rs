//! What the user may type, one file a command.

mod closed_loop;
mod eval;
mod run;
mod simulate;
mod train;

pub(crate) use closed_loop::{CameraArg, ClosedLoopArgs, SettingsArgs};
pub(crate) use eval::EvalArgs;
pub(crate) use run::RunArgs;
pub(crate) use simulate::{FlightArgs, SimulateArgs, SimulateWhat, TracksArgs};
pub(crate) use train::{SensorArg, TrainArgs};

use clap::{Parser, Subcommand};

/// How noisy is this IMU right now, and does my estimator get better when it is told?
#[derive(Debug, Parser)]
#[command(name = "dpn", version, propagate_version = true, max_term_width = 110)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Train a network that reads a sensor's noise off one second of one axis.
    Train(TrainArgs),
    /// Judge noise estimators: open loop against the injected truth, closed loop by the odometry they drive.
    Eval(EvalArgs),
    /// Run the odometry over one recording: trajectory, states, report.
    Run(RunArgs),
    /// Make data whose truth is known.
    Simulate(SimulateArgs),
}
