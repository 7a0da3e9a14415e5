//! `dpn page`.

use super::LogArgs;
use clap::Args;
use std::path::PathBuf;

/// Flags of `dpn page`.
#[derive(Debug, Args)]
pub(crate) struct PageArgs {
    /// The log and how it is read.
    #[command(flatten)]
    pub(crate) log: LogArgs,
    /// Folder with the page's index.html, as `cargo xtask web` makes it; without it what DPN_WEB names, else the program's own (of a release), else `web` beside it.
    #[arg(long, value_name = "DIR")]
    pub(crate) web: Option<PathBuf>,
}
