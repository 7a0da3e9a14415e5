//! One file a command: files and flags become library types, one library call, files again.

mod against;
mod allan;
mod along;
mod apart;
mod cache;
mod check;
mod closed_loop;
mod compare;
mod convert;
mod cores;
mod corpus;
mod device;
mod eval;
mod export;
mod fit;
mod fleet;
mod follow;
mod foxglove;
mod http;
mod images;
mod inertial;
mod into;
mod latency;
mod learned;
mod live;
mod log;
mod manual;
mod many;
mod noise;
mod page;
mod paper;
mod program;
mod report;
mod rerun;
mod resample;
#[cfg(feature = "ros2")]
mod ros2;
mod run;
mod settings;
mod shipped;
mod simulate;
mod stop;
mod sweep;
mod tracks;
mod train;
mod training_curve;
mod trajectories;
mod truth;

use crate::args::{Cli, Command};
pub(crate) use program::code_is_in;
pub(crate) use program::program;
use program::{VERSION, program_of};
pub(crate) use shipped::networks as shipped;

/// Runs what was typed.
pub(crate) fn run(cli: Cli) -> anyhow::Result<()> {
    match cli.command {
        Command::Train(args) if args.model.is_some() => inertial::train(&args),
        Command::Train(args) => train::run(args),
        Command::Eval(args) => eval::run(&args),
        Command::Run(args) if live::is_live(&args.source) => live::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Paper(args) => paper::run(&args),
        Command::Fleet(args) => fleet::run(&args),
        Command::Sweep(args) => sweep::run(args),
        Command::Noise(args) => noise::run(&args),
        Command::Allan(args) => allan::run(&args),
        Command::Convert(args) => resample::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Page(args) => page::run(&args),
        #[cfg(feature = "ros2")]
        Command::Ros2(args) => ros2::run(args),
        Command::Truth(args) => truth::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Ape(args) => trajectories::ape(&args),
        Command::Rpe(args) => trajectories::rpe(&args),
        Command::Export(args) => export::run(&args),
        Command::Simulate(args) => simulate::run(args),
        Command::Completions(args) => Ok(manual::completions(&args)?),
        Command::Manual(args) => manual::manual(&args),
    }
}
