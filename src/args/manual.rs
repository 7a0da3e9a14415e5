//! `dpn completions`, `dpn manual`.

use clap::Args;
use dpn_io::ResultPath;

/// Flags of `dpn completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell.
    pub(crate) shell: clap_complete::Shell,
}

/// Flags of `dpn manual`.
#[derive(Debug, Args)]
pub(crate) struct ManualArgs {
    /// Folder for the pages, dpn.1 and one a command.
    #[arg(long, value_name = "DIR", default_value = "man")]
    pub(crate) out: ResultPath,
}
