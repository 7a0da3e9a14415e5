//! `dpn completions` and `dpn manual`: made from the flags themselves.

use crate::args::{Cli, CompletionsArgs, ManualArgs};
use crate::ui::{OutputError, out, outln};
use anyhow::Result;
use clap::CommandFactory;
use dpn_io::atomic_write;

pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), OutputError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "dpn", &mut script);
    out!("{}", String::from_utf8_lossy(&script))
}

pub(crate) fn manual(args: &ManualArgs) -> Result<()> {
    let mut root = Cli::command();
    root.build();
    page(&root, args)
}

/// The page of a command and those of the commands in it.
fn page(command: &clap::Command, args: &ManualArgs) -> Result<()> {
    let man = clap_mangen::Man::new(command.clone());
    let file = args.out.join(man.get_filename());
    atomic_write(&file, |out| man.render(out))?;
    outln!("{}", file.display())?;
    command.get_subcommands().filter(|sub| sub.get_name() != "help").try_for_each(|sub| page(sub, args))
}
