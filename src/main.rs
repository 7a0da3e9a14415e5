//! The command line: parse, run, print the error chain and its hint, exit code. Nothing else.

mod args;
mod cmd;
mod ui;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = args::Cli::parse();
    match cmd::run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<ui::Interrupted>() => {
            ui::errln!("{error}");
            ExitCode::from(130)
        }
        Err(error) if ui::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            ui::errln!("{}", ui::render_error(&error));
            ExitCode::from(2)
        }
    }
}
