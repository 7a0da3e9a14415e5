//! A kind of simulated world.

use clap::ValueEnum;
use dpn_sim::tracks::World;

/// Kind of world as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum WorldArg {
    /// By the flight's size.
    Auto,
    /// Walls near.
    Room,
    /// Walls far.
    Hall,
}

impl From<WorldArg> for World {
    fn from(arg: WorldArg) -> Self {
        match arg {
            WorldArg::Auto => Self::Auto,
            WorldArg::Room => Self::Room,
            WorldArg::Hall => Self::Hall,
        }
    }
}
