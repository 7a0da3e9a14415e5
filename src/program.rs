//! The command line as a library: parse, run, print the error chain and its hint, exit code. The binary `dpn` and the wheel's command call
//! [`main_with`]; [`shipped`] are the networks that both carry.

mod args;
mod cmd;
mod ui;

use clap::Parser;
use dpn_pronet::network::{Network, NetworkError};
use std::ffi::OsString;
use std::path::PathBuf;

/// Runs one command; `args` has the program's name first. Returns the process's exit code: 0, 2 for bad input, 3 for a run that
/// made no pose, or is not to be trusted where `--strict` asks, 130 when interrupted.
///
/// Flags that cannot be parsed, `--help` and `--version` end with clap's own text and code, which is returned too: nothing here exits.
pub fn main_with(args: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match args::Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => {
            // A reader that has gone wants no help either.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    match cmd::run(cli) {
        Ok(()) => 0,
        Err(error) if error.is::<ui::Interrupted>() => {
            ui::errln!("{error}");
            130
        }
        Err(error) if error.is::<ui::Untrusted>() => {
            ui::errln!("{error}");
            3
        }
        Err(error) if ui::is_closed_pipe(&error) => 0,
        Err(error) => {
            ui::errln!("{}", ui::render_error(&error));
            2
        }
    }
}

/// Says in which file this code stands, where the process is another's: results are named by its checksum.
pub fn code_is_in(file: PathBuf) {
    cmd::code_is_in(file);
}

/// Version and checksum of this build, as reports have it.
pub fn program() -> String {
    cmd::program()
}

/// The networks that come with the program.
///
/// # Errors
/// A file of `models/` that was damaged before it was compiled in.
pub fn shipped() -> Result<Vec<Network>, NetworkError> {
    cmd::shipped()
}
