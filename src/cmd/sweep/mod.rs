//! `dpn sweep`.

mod collect;
mod lasting;
mod many;
mod plan;
mod run;
mod status;
mod trainer;

pub(crate) use many::many;

use crate::args::SweepWhat;
use anyhow::Result;

pub(crate) fn run(what: SweepWhat) -> Result<()> {
    match what {
        SweepWhat::Plan(args) => plan::run(&args),
        SweepWhat::Run(args) => run::run(&args),
        SweepWhat::Collect(args) => collect::run(&args),
        SweepWhat::Status(args) => status::run(&args),
    }
}
