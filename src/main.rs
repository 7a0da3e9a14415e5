//! The command line: [`dpn_program::main_with`] and its exit code. Nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(dpn_program::main_with(std::env::args_os()))
}
