//! From jobs to a sweep: every cell with its cost and its shard.

use super::balance::{Balance, Group, Member, balance, shards_within};
use super::costs::CellTime;
use super::error::SweepError;
use super::manifest::{Job, PlannedCell, SweepManifest};
use super::spec::{JobSpec, TrainSpec};
use crate::closed_loop::{ClosedLoopError, Experiment, Manifest, SequenceSet, Sweep};
use dpn_core::config::{ConfigFault, Validate};
use dpn_io::config::ConfigError;
use dpn_pronet::network::Network;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a plan is of: its key `kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlanKind {
    /// A closed loop: [`Experiment`].
    ClosedLoop,
    /// A closed loop a platform: [`FleetPlan`](crate::fleet::FleetPlan).
    Fleet,
    /// The closed loops of a paper.
    Paper,
    /// Trainings: [`TrainPlan`](super::TrainPlan).
    Train,
}

impl PlanKind {
    /// What the plan at `path` is of; its other keys are not looked at.
    ///
    /// # Errors
    /// A file that cannot be read, is no TOML, or does not say it.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        #[derive(Deserialize)]
        struct OfKind {
            kind: PlanKind,
        }
        impl Validate for OfKind {
            fn faults(&self) -> Vec<ConfigFault> {
                Vec::new()
            }
        }
        dpn_io::config::load::<OfKind>(path).map(|plan| plan.kind)
    }
}

/// How a sweep is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// Into so many shards.
    Shards(usize),
    /// Into shards of so many minutes at most.
    Minutes(f64),
}

/// A job whose cells are to be planned.
#[derive(Debug)]
pub enum JobToPlan<'a> {
    /// A closed loop.
    ClosedLoop(Box<LoopJob<'a>>),
    /// Trainings, each with its checksum and how many updates it makes.
    Train(Vec<(TrainSpec, String, f64)>),
}

/// A closed loop whose cells are to be planned.
#[derive(Debug)]
pub struct LoopJob<'a> {
    /// Its folder below the results'.
    pub folder: PathBuf,
    /// What is run.
    pub experiment: Experiment,
    /// The same with its sequences.
    pub sweep: Sweep<'a>,
    /// What that is made from.
    pub made_from: Manifest,
}

impl<'a> LoopJob<'a> {
    /// The runs of `experiment` over its sequences by `program`, one thread and no cache.
    ///
    /// # Errors
    /// Files of settings or of data that cannot be read; sequences that are not there.
    pub fn new(
        folder: PathBuf,
        experiment: Experiment,
        source: &'a SequenceSet,
        networks: &'a [Network],
        program: String,
    ) -> Result<Self, ClosedLoopError> {
        let sweep = experiment.sweep(source, networks)?;
        let made_from = Manifest::of(&sweep, program)?;
        Ok(Self { folder, experiment, sweep, made_from })
    }
}

/// A plan that may be looked at before it is written.
#[derive(Debug)]
pub struct Planned {
    /// The sweep.
    pub manifest: SweepManifest,
    /// What shares what.
    pub groups: Vec<Group>,
    /// Its shards.
    pub balance: Balance,
}

/// Lists the cells of `jobs` in `manifest`, with what they cost and in which shard each is.
///
/// # Errors
/// Data that cannot be read; no cell at all; a shard shorter than a cell.
pub fn plan(mut manifest: SweepManifest, jobs: &[JobToPlan<'_>], size: Size) -> Result<Planned, SweepError> {
    let mut groups: Vec<Group> = Vec::new();
    for job in jobs {
        match job {
            JobToPlan::ClosedLoop(job) => closed_loop(&mut manifest, &mut groups, job)?,
            JobToPlan::Train(trainings) => train(&mut manifest, &mut groups, trainings),
        }
    }
    if manifest.cells.is_empty() {
        return Err(SweepError::NoCells);
    }
    let shards = match size {
        Size::Shards(shards) => shards.clamp(1, manifest.cells.len()),
        Size::Minutes(minutes) => shards_within(&groups, 60.0 * minutes).ok_or_else(|| {
            let longest = |g: &Group| g.shared_s + g.cells.iter().map(|cell| cell.own_s).fold(0.0, f64::max);
            let cell_minutes = groups.iter().map(longest).fold(0.0, f64::max) / 60.0;
            SweepError::TooShort { minutes, cell_minutes }
        })?,
    };
    let balance = balance(&groups, shards);
    for (cell, shard) in manifest.cells.iter_mut().zip(&balance.shard_of) {
        cell.shard = *shard;
    }
    manifest.shard_s.clone_from(&balance.seconds);
    Ok(Planned { manifest, groups, balance })
}

fn closed_loop(
    planned: &mut SweepManifest,
    groups: &mut Vec<Group>,
    LoopJob { folder, experiment, sweep, made_from }: &LoopJob<'_>,
) -> Result<(), SweepError> {
    let job = planned.jobs.len();
    let names = sweep.source.names();
    let mut seconds = BTreeMap::new();
    for &place in &sweep.places {
        // A sweep without seeds has no cells to be weighed.
        let Some(seed) = sweep.training_seed() else { break };
        let name = &names[place].0;
        let whole = sweep.source.recording(place, seed)?.imu.duration();
        let run = sweep.to.unwrap_or(whole).min(whole) - sweep.from.seconds(name);
        seconds.insert(name.clone(), run.max(1.0));
    }
    let seeded = sweep.source.tracks_are_seeded();
    let sources: BTreeMap<String, String> =
        sweep.every_noise().map(|noise| (noise.to_string(), noise.source().to_string())).collect();
    let mut ranks: BTreeMap<&str, usize> = BTreeMap::new();
    let (begin, mut last) = (groups.len(), None);
    for (key, cell) in sweep.named_cells(made_from)? {
        let amount = seconds[&key.sequence];
        let time = CellTime::predicted(sweep.source.camera(), amount);
        let group = (key.sequence.clone(), if seeded { key.seed } else { 0 });
        if last.as_ref() != Some(&group) {
            groups.push(Group { shared_s: time.shared_s, cells: Vec::new() });
            last = Some(group);
        }
        let of = groups.last_mut().expect("one was just pushed, or is the last cell's");
        let ranked = ranks.len();
        let noise = *ranks.entry(sources[&key.noise].as_str()).or_insert(ranked);
        of.cells.push(Member { place: planned.cells.len(), own_s: time.own_s, noise });
        let of_job =
            if folder.as_os_str().is_empty() { String::new() } else { format!("{}: ", folder.display()) };
        let label = format!("{of_job}{} {} seed {}", key.sequence, key.noise, key.seed);
        planned.cells.push(PlannedCell { job, cell, label, amount, cost_s: time.own_s, shard: 0 });
    }
    for group in &mut groups[begin..] {
        group.cells.sort_by_key(|cell| cell.noise);
    }
    let spec = JobSpec::ClosedLoop(Box::new(experiment.resolved(sweep.source)?));
    let made_from = serde_json::to_value(made_from).expect("texts and JSON values");
    planned.jobs.push(Job { folder: folder.clone(), spec, made_from });
    Ok(())
}

fn train(planned: &mut SweepManifest, groups: &mut Vec<Group>, trainings: &[(TrainSpec, String, f64)]) {
    let job = planned.jobs.len();
    for (spec, cell, amount) in trainings {
        let time = CellTime::predicted("train", *amount);
        let cells = vec![Member { place: planned.cells.len(), own_s: time.own_s, noise: 0 }];
        groups.push(Group { shared_s: time.shared_s, cells });
        let (cell, label) = (cell.clone(), spec.folder.clone());
        planned.cells.push(PlannedCell { job, cell, label, amount: *amount, cost_s: time.own_s, shard: 0 });
    }
    let spec = JobSpec::Train(trainings.iter().map(|(spec, ..)| spec.clone()).collect());
    planned.jobs.push(Job { folder: PathBuf::new(), spec, made_from: serde_json::Value::Null });
}
