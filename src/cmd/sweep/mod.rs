//! `dpn sweep`.

mod collect;
mod many;
mod plan;
mod run;
mod status;
mod trainer;

pub(crate) use many::many;

use crate::args::{SweepArgs, SweepWhat};
use anyhow::Result;

pub(crate) fn run(args: SweepArgs) -> Result<()> {
    match args.what {
        SweepWhat::Plan(args) => plan::run(&args),
        SweepWhat::Run(args) => run::run(&args),
        SweepWhat::Collect(args) => collect::run(&args),
        SweepWhat::Status(args) => status::run(&args),
    }
}

/// Folder of a sweep's own networks.
const MODELS: &str = "models";

/// Minutes or hours, as people say them.
fn lasting(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
