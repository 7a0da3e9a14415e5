//! Sweeps beyond one process: planned once, worked off in shards wherever there is a processor, put together into what one process would have left.
//!
//! A sweep is a list of *jobs*, each a list of independent *cells* named by the checksum of all that their results are a function of: the runs of a closed
//! loop, or trainings. A paper is several closed loops. Whoever runs shards (a cluster's queue, `parallel`, a shell) is told nothing but a number.
//!
//! * [`Experiment`](crate::closed_loop::Experiment): a closed loop as it is asked for, by a plan's TOML or by flags, [`TrainPlan`]: trainings; [`JobSpec`] is a job with
//!   everything resolved.
//! * [`plan`]: cells, their predicted costs and their shards ([`balance`]) become a folder with one file, [`SweepManifest`].
//! * [`run_shard`] works one off, in a folder of its own; [`collect`] checks all and puts them together; [`status`] looks on.
//!
//! The runs themselves are those of [`crate::closed_loop`]: a shard is a [`Sweep`](crate::closed_loop::Sweep) of fewer cells in another folder.

mod balance;
mod beat;
mod collect;
mod costs;
mod error;
mod manifest;
mod planning;
mod record;
mod shard;
mod shard_files;
mod spec;
mod status;
mod train_plan;

pub use balance::{Balance, Group, Member, balance, shards_within};
pub use beat::Beat;
pub use collect::{Collected, collect};
pub use error::{MissingShard, MixedShard, SweepError};
pub use manifest::{Job, PlannedCell, SweepFolder, SweepManifest};
pub use planning::{JobToPlan, LoopJob, PlanKind, Planned, Size, plan};
pub use shard::{FailedLine, Node, ShardOutcome, TrainFault, Trainer, by_itself, run_shard};
pub use shard_files::TRUTH;
pub use spec::{JobSpec, TrainSpec};
pub use status::{ShardState, ShardStatus, SweepStatus, status};
pub use train_plan::TrainPlan;
