//! What the user may type, one file a command.

mod allan;
mod cache;
mod check;
mod closed_loop;
mod compare;
mod eval;
mod examples;
mod export;
mod fit;
mod fleet;
mod image_log;
mod log;
mod manual;
mod noise;
mod page;
mod paper;
mod paste;
mod report;
mod resample;
#[cfg(feature = "ros2")]
mod ros2;
mod run;
mod simulate;
mod sweep;
mod train;
mod trajectories;
mod truth;
mod word;

pub(crate) use allan::AllanArgs;
pub(crate) use cache::CacheArgs;
pub(crate) use check::{CheckArgs, FailOn};
pub(crate) use closed_loop::{ClosedLoopArgs, SettingsArgs};
pub(crate) use compare::CompareArgs;
pub(crate) use eval::EvalArgs;
pub(crate) use export::{ExportWhat, OnnxArgs};
pub(crate) use fit::FitArgs;
pub(crate) use fleet::FleetArgs;
pub(crate) use image_log::ImageLogArgs;
pub(crate) use log::{HowArgs, LogArgs, SpanArgs, rate};
pub(crate) use manual::{CompletionsArgs, ManualArgs};
pub(crate) use noise::{ConvertArgs, NoiseArgs, NoiseWhat, RowFormat};
pub(crate) use page::PageArgs;
pub(crate) use paper::PaperArgs;
pub(crate) use paste::PasteArgs;
pub(crate) use report::ReportArgs;
pub(crate) use resample::ResampleArgs;
#[cfg(feature = "ros2")]
pub(crate) use ros2::{NodeArgs, Ros2Args, Ros2NoiseArgs, Ros2What};
pub(crate) use run::RunArgs;
pub(crate) use simulate::{AlongArgs, FlightArgs, ImagesArgs, SimulateWhat, TracksArgs};
pub(crate) use sweep::{Shards, SweepCollectArgs, SweepPlanArgs, SweepRunArgs, SweepStatusArgs, SweepWhat};
pub(crate) use train::TrainArgs;
pub(crate) use trajectories::{ApeArgs, DeltaUnit, MAX_DIFF_S, RpeArgs, TrajectoryArgs};
pub(crate) use truth::TruthArgs;

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
    #[command(after_help = examples::TRAIN)]
    Train(TrainArgs),
    /// Judge noise estimators: open loop against the injected truth, closed loop by the odometry they drive.
    #[command(after_help = examples::EVAL)]
    Eval(EvalArgs),
    /// Run the odometry over one recording: trajectory, states, report.
    #[command(after_help = examples::RUN)]
    Run(Box<RunArgs>),
    /// The paper again, from data: every table and figure, with the controls and statistics that decide its question, on one page.
    #[command(after_help = examples::PAPER)]
    Paper(PaperArgs),
    /// Noises on many platforms, each held against that platform's best constant: one table.
    #[command(after_help = examples::FLEET)]
    Fleet(FleetArgs),
    /// A closed loop, a paper or trainings in shards, on as many machines as there are: plan, run, collect, status.
    #[command(subcommand)]
    Sweep(SweepWhat),
    /// How noisy an IMU is along a log, sample by sample; and noise figures as other programs write them (convert).
    #[command(after_help = examples::NOISE)]
    Noise(NoiseArgs),
    /// What a log at rest says of its sensor's noise: Allan plot, five coefficients an axis, configurations to paste.
    #[command(after_help = examples::ALLAN)]
    Allan(AllanArgs),
    /// A log as a plain CSV file, at a lower rate where one is asked for.
    #[command(after_help = examples::RESAMPLE)]
    Convert(ResampleArgs),
    /// A log's doctor: rate, gaps, units, gravity, clipping, vibration, rest and motion; findings by weight.
    #[command(after_help = examples::CHECK)]
    Check(CheckArgs),
    /// What changed between two logs of one sensor: noise with intervals, bias, vibration, losses, with both spectra in a picture.
    #[command(after_help = examples::COMPARE)]
    Compare(CompareArgs),
    /// What logs say of their IMU as one HTML page that needs nothing else: findings, signal, spectra, noise, lines to paste; to send or to print.
    #[command(after_help = examples::REPORT)]
    Report(ReportArgs),
    /// A log in the browser: findings, noise over time, Allan plot and figures to paste on one page, served on this machine alone.
    #[command(after_help = examples::PAGE)]
    Page(PageArgs),
    /// The odometry as a node of ROS 2, without ROS 2; or the noise of its IMU alone (noise).
    #[cfg(feature = "ros2")]
    #[command(after_help = examples::ROS2)]
    Ros2(Ros2Args),
    /// A published ground truth reconciled with its IMU: clock, frames, noise of both, and where it can be trusted.
    #[command(after_help = examples::TRUTH)]
    Truth(TruthArgs),
    /// An IMU's scale, misalignment and bias against a trajectory, with intervals, and the log's samples under that calibration.
    #[command(after_help = examples::FIT)]
    Fit(FitArgs),
    /// Absolute errors of trajectories against the truth, with evo_ape's options; of several over several sequences what may be said of them.
    #[command(after_help = examples::APE)]
    Ape(ApeArgs),
    /// Relative errors of trajectories over stretches, with evo_rpe's options.
    #[command(after_help = examples::RPE)]
    Rpe(RpeArgs),
    /// Trained networks for other programs (onnx).
    #[command(subcommand)]
    Export(ExportWhat),
    /// Make data whose truth is known.
    #[command(subcommand)]
    Simulate(SimulateWhat),
    /// Completions of a shell, to standard output.
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Manual pages, one a command.
    #[command(after_help = examples::MANUAL)]
    Manual(ManualArgs),
}
