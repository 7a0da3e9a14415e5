//! `dpn sweep plan`.

use super::lasting::lasting;
use super::trainer::{CorpusTrainer, MODELS};
use crate::args::SweepPlanArgs;
use crate::cmd::{fleet, program, shipped};
use crate::ui::{Fault, outln, refuse, warn};
use anyhow::Result;
use dpn_eval::closed_loop::{Experiment, SequenceSet, Sequences};
use dpn_eval::fleet::FleetPlan;
use dpn_eval::sweeps::{
    Balance, Group, JobToPlan, LoopJob, PlanKind, Planned, Size, SweepFolder, SweepManifest, TrainPlan,
    balance, plan,
};
use dpn_io::config::load;
use dpn_io::write_file;
use dpn_papers::{Paper, PaperPlan};
use dpn_pronet::network::Network;
use std::path::{Path, PathBuf};

/// Workers for whom the printed table says what they would take.
const WORKERS: [usize; 6] = [1, 2, 8, 64, 512, 4096];

pub(crate) fn run(args: &SweepPlanArgs) -> Result<()> {
    let planned = match PlanKind::read(&args.plan)? {
        PlanKind::ClosedLoop => of_loop(args)?,
        PlanKind::Fleet => of_fleet(args)?,
        PlanKind::Paper => of_paper(args)?,
        PlanKind::Train => of_trainings(args)?,
    };
    // Before anything is said: who reads it may have gone (`| head -1`), and the sweep is to stand all the same.
    let folder = SweepFolder::create(&args.out, planned.manifest)?;
    tell(args, &folder, &planned.groups, &planned.balance)
}

fn of_loop(args: &SweepPlanArgs) -> Result<Planned> {
    let mut asked: Experiment = load(&args.plan)?;
    asked.data = args.data.clone().or(asked.data);
    let (data, models) = (asked.data.clone(), asked.models.clone());
    of_experiments(args, data, models.as_deref(), vec![(PathBuf::new(), asked)])
}

fn of_fleet(args: &SweepPlanArgs) -> Result<Planned> {
    let fleet: FleetPlan = load(&args.plan)?;
    let data = args.data.clone().unwrap_or_else(|| PathBuf::from("data"));
    let experiments = fleet::experiments(&fleet, &data, &args.out)?;
    let models = experiments.first().and_then(|first| first.models.clone());
    if experiments.iter().any(|experiment| experiment.models != models) {
        return Err(Fault::new("the platforms name several folders of networks, and a sweep has one").into());
    }
    for (platform, experiment) in fleet.platform.iter().zip(&experiments) {
        fleet::reconcile(platform, experiment, &args.out)?;
    }
    let folders = fleet.platform.iter().map(|platform| PathBuf::from(&platform.folder));
    of_experiments(args, Some(data), models.as_deref(), folders.zip(experiments).collect())
}

/// A job an experiment, each in its folder.
fn of_experiments(
    args: &SweepPlanArgs,
    data: Option<PathBuf>,
    models: Option<&Path>,
    experiments: Vec<(PathBuf, Experiment)>,
) -> Result<Planned> {
    let sources: Vec<SequenceSet> =
        experiments.iter().map(|(_, experiment)| experiment.source()).collect::<Result<_, _>>()?;
    if sources.iter().any(|source| matches!(source.of, Sequences::Logged(_))) {
        return refuse(
            "a log with images is one sequence, and no sweep is cut of it",
            "run it with `dpn eval --closed-loop --camera images --data LOG`",
        );
    }
    let networks = shipped::or_of(models)?;
    let mut jobs = Vec::new();
    for ((folder, experiment), source) in experiments.into_iter().zip(&sources) {
        warn(experiment.warnings()?);
        let job = LoopJob::new(folder, experiment, source, &networks, program())?;
        jobs.push(JobToPlan::ClosedLoop(Box::new(job)));
    }
    cut(args, data, models.is_some().then_some(&networks), &jobs)
}

fn of_paper(args: &SweepPlanArgs) -> Result<Planned> {
    let mut asked: PaperPlan = load(&args.plan)?;
    asked.run.data = args.data.clone().or(asked.run.data);
    let opened = asked.open()?;
    let networks = shipped::or_of(asked.run.models.as_deref())?;
    let paper = Paper::new(&opened, &networks, program());
    warn(paper.warnings()?);
    let jobs: Vec<JobToPlan<'_>> =
        paper.loops()?.into_iter().map(|job| JobToPlan::ClosedLoop(Box::new(job))).collect();
    cut(args, asked.run.data, asked.run.models.is_some().then_some(&networks), &jobs)
}

fn of_trainings(args: &SweepPlanArgs) -> Result<Planned> {
    let mut asked: TrainPlan = load(&args.plan)?;
    asked.data = args.data.clone().or(asked.data);
    let mut trainer = CorpusTrainer::new(asked.data.clone());
    let trainings = trainer.trainings(&asked)?;
    cut(args, asked.data, None, &[JobToPlan::Train(trainings)])
}

/// Cuts jobs into shards; networks that are none of the program's own go with the sweep.
fn cut(
    args: &SweepPlanArgs,
    data: Option<PathBuf>,
    networks: Option<&Vec<Network>>,
    jobs: &[JobToPlan<'_>],
) -> Result<Planned> {
    let size = match (args.shards, args.minutes) {
        (_, Some(minutes)) => Size::Minutes(minutes),
        (shards, None) => Size::Shards(shards.map_or(1, |shards| shards as usize)),
    };
    let processor = args.processor.clone().unwrap_or_else(dpn_pronet::processor);
    let manifest = SweepManifest::new(program(), processor, data, networks.is_some());
    let planned = plan(manifest, jobs, size)?;
    SweepFolder::may_take(&args.out, &planned.manifest)?;
    for (number, network) in networks.into_iter().flatten().enumerate() {
        // One folder each: two sensors' networks may have one name.
        let name = network.path.file_name().expect("it was read from a file");
        let path = args.out.join(MODELS).join(format!("{number:04}")).join(name);
        let bytes = network.weights.to_bytes()?;
        write_file(&path, &bytes)?;
    }
    Ok(planned)
}

fn tell(args: &SweepPlanArgs, folder: &SweepFolder, groups: &[Group], chosen: &Balance) -> Result<()> {
    let cells = folder.manifest.cells.len();
    let predicted = |shards: usize, of: &Balance| {
        serde_json::json!({
            "shards": shards, "longest_s": of.longest_s(), "idle_share": of.idle_share(),
            "cpu_s": of.cpu_s,
        })
    };
    let shards = folder.shards();
    let others: Vec<_> = WORKERS
        .into_iter()
        .filter(|workers| *workers <= cells)
        .map(|workers| (workers, balance(groups, workers)))
        .collect();
    if args.json {
        let others: Vec<_> = others.iter().map(|(workers, of)| predicted(*workers, of)).collect();
        let row =
            serde_json::json!({ "cells": cells, "planned": predicted(shards, chosen), "others": others });
        outln!("{row}")?;
        return Ok(());
    }
    outln!("{cells} cells in {shards} shards: {}", words(chosen))?;
    for (workers, of) in &others {
        outln!("  as {workers:4} shards: {}", words(of))?;
    }
    let out = args.out.display();
    outln!("\nwork off: dpn sweep run {out} --shard K, K from 0 to {}", shards - 1)?;
    outln!("look on:  dpn sweep status {out}")?;
    outln!("then:     dpn sweep collect {out}")?;
    Ok(())
}

fn words(of: &Balance) -> String {
    format!(
        "{} at most each, {:.1} % idle, {} of CPU in all",
        lasting(of.longest_s()),
        100.0 * of.idle_share(),
        lasting(of.cpu_s)
    )
}
