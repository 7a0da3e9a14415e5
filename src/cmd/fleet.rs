//! `dpn fleet`.

use super::closed_loop::Machine;
use super::{shipped, truth};
use crate::args::FleetArgs;
use crate::ui::{Fault, errln, out, results};
use anyhow::{Context, Result};
use dpn_eval::closed_loop::{Experiment, Row};
use dpn_eval::fleet::{FleetPlan, FleetScore, Platform};
use dpn_eval::sweeps::TRUTH;
use dpn_io::{FolderLock, ResultPath, write_file};
use dpn_papers::tables;
use std::path::Path;

pub(crate) fn run(args: &FleetArgs) -> Result<()> {
    let mut plan: FleetPlan = dpn_io::config::load(&args.plan)?;
    select(&mut plan, &args.platforms)?;
    let noises = plan.all_noises();
    let experiments = experiments(&plan, &args.data, &args.out)?;
    let _lock = FolderLock::take(&args.out)?;
    let machine = Machine::new(&args.cache, args.threads)?;
    let mut platforms = Vec::new();
    for (platform, experiment) in plan.platform.iter().zip(&experiments) {
        errln!("{}", platform.name);
        let run = || -> Result<Vec<Row>> {
            reconcile(platform, experiment, &args.out)?;
            let networks = shipped::or_of(args.models.as_deref().or(experiment.models.as_deref()))?;
            Ok(machine.run(experiment, &networks, Some(&args.out.join(&platform.folder)))?.rows)
        };
        platforms.push((platform.name.clone(), run().with_context(|| platform.name.clone())?));
    }
    let score = FleetScore::new(&platforms, &plan.constants, &noises)?;
    tell(&score, args)
}

/// What is run on every platform; `out` is where reconciled ground truth is put. What cannot be had is said before the first hour.
pub(super) fn experiments(plan: &FleetPlan, data: &Path, out: &ResultPath) -> Result<Vec<Experiment>> {
    let noises = plan.all_noises();
    let of = |platform: &Platform| {
        let truth = out.join(TRUTH).join(&platform.folder);
        let experiment = platform.experiment(noises.clone(), data, truth.path());
        let check = || experiment.source()?.select(&experiment.sequences);
        check().with_context(|| platform.name.clone())?;
        Ok(experiment)
    };
    plan.platform.iter().map(of).collect()
}

/// Makes the ground truth that a platform's experiment wants.
pub(super) fn reconcile(platform: &Platform, experiment: &Experiment, out: &ResultPath) -> Result<()> {
    if experiment.truth.is_none() || !platform.reconciled {
        return Ok(());
    }
    let truth = out.join(TRUTH).join(&platform.folder);
    let published = Experiment { truth: None, ..experiment.clone() }.source()?;
    truth::reconciled(&published.recordings(&published.select(&experiment.sequences)?), &truth)
}

/// Leaves the platforms named.
fn select(plan: &mut FleetPlan, folders: &[String]) -> Result<(), Fault> {
    if let Some(unknown) = folders.iter().find(|name| plan.platform.iter().all(|p| p.folder != **name)) {
        let known: Vec<&str> = plan.platform.iter().map(|platform| platform.folder.as_str()).collect();
        return Err(Fault::new(format!("the plan has no platform `{unknown}`"))
            .hint(format!("it has {}", known.join(", "))));
    }
    plan.platform.retain(|platform| folders.is_empty() || folders.contains(&platform.folder));
    Ok(())
}

/// Writes and prints the tables.
fn tell(score: &FleetScore, args: &FleetArgs) -> Result<()> {
    let [answer, platforms] = [tables::fleet(score), tables::fleet_platforms(score)];
    let text = format!("{}\n{}", answer.console(), platforms.console());
    write_file(args.out.join("fleet.csv"), platforms.csv())?;
    write_file(args.out.join("fleet.txt"), &text)?;
    let file = args.out.join("fleet.json");
    if !results(file.clone(), score, args.json)? {
        out!("{text}\nall of it: {}\n", file.display())?;
    }
    Ok(())
}
