//! Why a sweep cannot be planned, run or put together.

use crate::closed_loop::ClosedLoopError;
use dpn_io::config::ConfigError;
use dpn_io::{IoError, LockError};
use std::path::PathBuf;
use thiserror::Error;

/// A shard that is not whole, and the command that makes it so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingShard {
    /// Its number.
    pub shard: usize,
    /// How many of its cells are there.
    pub done: usize,
    /// How many it has.
    pub cells: usize,
    /// The command.
    pub command: String,
}

/// Why a sweep cannot be planned, run or put together.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A closed loop.
    #[error(transparent)]
    ClosedLoop(#[from] ClosedLoopError),
    /// A configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A file.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A folder that another process writes to.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// A plan without cells.
    #[error("the plan has no cell")]
    NoCells,
    /// One cell alone takes longer than a shard may.
    #[error("a shard of {minutes} minutes is shorter than a single cell, which takes {cell_minutes:.1}")]
    TooShort {
        /// What was asked for \[min\].
        minutes: f64,
        /// The longest cell with what it needs \[min\].
        cell_minutes: f64,
    },
    /// Another sweep lies where this one is to be written.
    #[error("{} holds another sweep", dir.display())]
    OtherSweep {
        /// The folder.
        dir: PathBuf,
    },
    /// A path in a plan that cannot be written down for another machine.
    #[error(
        "a file or folder that the plan names is not called by text (UTF-8), so that the sweep's file cannot name it"
    )]
    NotText,
    /// No sweep lies there.
    #[error("{}: no sweep, for there is no sweep.json", dir.display())]
    NoSweep {
        /// The folder.
        dir: PathBuf,
    },
    /// A file of this program's that does not read.
    #[error("{}:{line}: {message}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
        /// What makes it again.
        command: String,
    },
    /// A number that no shard has.
    #[error("there is no shard {shard}: they are 0 to {}", shards - 1)]
    NoShard {
        /// What was asked for.
        shard: usize,
        /// How many there are.
        shards: usize,
    },
    /// Program, processor or input here are not those of the sweep.
    #[error("the sweep was planned with another {key}: {planned} there, {here} here")]
    Differs {
        /// What differs.
        key: String,
        /// In the sweep.
        planned: String,
        /// On this machine.
        here: String,
    },
    /// A shard that was made by or from something else.
    #[error(transparent)]
    Mixed(Box<MixedShard>),
    /// Two results of one cell that are not the same.
    #[error("{label}: {} and {} have two different results of it", first.display(), second.display())]
    Contradiction {
        /// The cell.
        label: String,
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// Shards that are not there or not at their end.
    #[error("{} missing: {}", counted(shards.len(), "shard is", "shards are"), listed(shards))]
    Missing {
        /// Each with its command.
        shards: Vec<MissingShard>,
    },
    /// Cells that could not be run.
    #[error("{}: {label}: {reason}", counted(*count, "cell failed", "cells failed"))]
    Failed {
        /// How many.
        count: usize,
        /// The first.
        label: String,
        /// Why that one.
        reason: String,
        /// Where the others are named.
        path: PathBuf,
        /// What tries them again.
        command: String,
    },
    /// A training that could not be begun or ended.
    #[error("{0}")]
    Train(String),
    /// Stopped from outside; what is finished is kept.
    #[error("stopped after {done} of {total} cells")]
    Stopped {
        /// Cells whose results are on disk.
        done: usize,
        /// Cells in all.
        total: usize,
    },
}

/// A shard that was made by or from something else.
#[derive(Debug, Error)]
#[error("shard {shard} ({label}) was made with another {key}: {there} there, {planned} in the sweep")]
pub struct MixedShard {
    /// The shard.
    pub shard: usize,
    /// Its first cell.
    pub label: String,
    /// What differs.
    pub key: String,
    /// In the shard.
    pub there: String,
    /// In the sweep.
    pub planned: String,
    /// What makes the shard again.
    pub command: String,
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn listed(shards: &[MissingShard]) -> String {
    const SHOWN: usize = 5;
    let of = |m: &MissingShard| format!("shard {} ({} of {} cells)", m.shard, m.done, m.cells);
    let shown: Vec<String> = shards.iter().take(SHOWN).map(of).collect();
    let more = if shards.len() > SHOWN { ", ..." } else { "" };
    format!("{}{more}", shown.join(", "))
}

impl SweepError {
    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::ClosedLoop(error) => return error.hint(),
            Self::Config(error) => return error.hint(),
            Self::Io(error) => return error.hint(),
            Self::Locked(error) => return error.hint(),
            Self::TooShort { .. } => "give more minutes, or run shorter parts with `from` and `to`".into(),
            Self::OtherSweep { .. } => "give another folder with --out, or remove this one".into(),
            Self::NotText => "rename it, or give it by a link with another name".into(),
            Self::NoSweep { .. } => "dpn sweep plan PLAN.toml --shards N --out DIR makes one".into(),
            Self::Damaged { command, .. } => format!("`{command}` makes it again"),
            Self::Differs { .. } => {
                "run it with the program, data and kind of processor it was planned with, or plan it anew"
                    .into()
            }
            Self::Mixed(mixed) => format!("remove the shard's folder; `{}` makes it again", mixed.command),
            Self::Contradiction { .. } => {
                "remove one of the two shards' folders and run that shard again".into()
            }
            Self::Missing { shards } => {
                shards.iter().map(|m| m.command.as_str()).collect::<Vec<_>>().join("\n      ")
            }
            Self::Failed { path, command, .. } => {
                format!("all of them are named in {}; `{command}` tries them again", path.display())
            }
            Self::Stopped { .. } => "the same command goes on where it stopped".into(),
            Self::NoCells | Self::NoShard { .. } | Self::Train(_) => return None,
        })
    }

    /// Whether it is no fault but a stop that was asked for.
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Stopped { .. } | Self::ClosedLoop(ClosedLoopError::Stopped { .. }))
    }

    /// Whether another process works there.
    pub fn is_held(&self) -> bool {
        matches!(self, Self::Locked(LockError::Held { .. }))
    }
}
