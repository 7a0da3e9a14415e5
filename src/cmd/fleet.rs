//! `dpn fleet`.

use super::cores::cores;
use super::{cache, closed_loop, program, shipped, stop, truth};
use crate::args::FleetArgs;
use crate::ui::{Bar, Fault, Interrupted, errln, out, outln};
use anyhow::{Context, Result};
use dpn_eval::closed_loop::{ClosedLoopError, Manifest, Row, Sweep};
use dpn_eval::fleet::{FleetPlan, FleetScore, PlatformPlan};
use dpn_eval::sweeps::LoopPlan;
use dpn_io::{FolderLock, atomic_write};
use dpn_papers::tables;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

pub(crate) fn run(args: &FleetArgs) -> Result<()> {
    let mut plan: FleetPlan = dpn_io::config::load(&args.plan)?;
    select(&mut plan, &args.platforms)?;
    let noises = plan.all_noises();
    let loops: Vec<LoopPlan> = plan
        .platform
        .iter()
        .map(|platform| platform.closed_loop(noises.clone(), &args.data, &truth_of(args, platform)))
        .collect();
    // What cannot be had is said before the first hour.
    for (platform, closed) in plan.platform.iter().zip(&loops) {
        let source = closed.source().with_context(|| platform.name.clone())?;
        source.select(&closed.sequences).with_context(|| platform.name.clone())?;
    }
    let _lock = FolderLock::take(&args.out)?;
    let stop = stop::on_ctrl_c("cells that were finished are kept, and the same command goes on from there")?;
    let mut platforms = Vec::new();
    for (platform, closed) in plan.platform.iter().zip(&loops) {
        errln!("{}", platform.name);
        let rows = one(platform, closed, args, &stop).with_context(|| platform.name.clone())?;
        platforms.push((platform.name.clone(), rows));
    }
    let score = FleetScore::new(&platforms, &plan.constants, &noises)?;
    tell(&score, args)
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

/// Where a platform's reconciled ground truth is.
fn truth_of(args: &FleetArgs, platform: &PlatformPlan) -> PathBuf {
    args.out.join("truth").join(&platform.folder)
}

/// The rows of one platform.
fn one(platform: &PlatformPlan, closed: &LoopPlan, args: &FleetArgs, stop: &AtomicBool) -> Result<Vec<Row>> {
    if platform.reconciled {
        let published = LoopPlan { truth: None, ..closed.clone() }.source()?;
        truth::reconciled(
            &published.recordings(&published.select(&closed.sequences)?),
            &truth_of(args, platform),
        )?;
    }
    let source = closed.source()?;
    let networks = shipped::or_of(args.models.as_deref().or(closed.models.as_deref()))?;
    let cache = cache::open(&args.cache)?;
    let threads = args.threads.unwrap_or_else(cores).max(1);
    let sweep = Sweep { cache: cache.as_ref(), ..closed.sweep(&source, &networks, threads)? };
    let manifest = Manifest::of(&sweep, program())?;
    let folder = args.out.join(&platform.folder);
    let lock = FolderLock::take(&folder)?;
    let rows = match sweep.run(&lock, &manifest, stop, &mut Bar::new()) {
        Err(error @ ClosedLoopError::Stopped { .. }) => {
            return Err(Interrupted(format!("{error}; the same command goes on from there")).into());
        }
        other => other?,
    };
    cache::say(cache.as_ref());
    closed_loop::write(&folder, &rows)?;
    Ok(rows)
}

/// Writes and prints the tables.
fn tell(score: &FleetScore, args: &FleetArgs) -> Result<()> {
    let [answer, platforms] = [tables::fleet(score), tables::fleet_platforms(score)];
    let text = format!("{}\n{}", answer.console(), platforms.console());
    let json = serde_json::to_string(score)? + "\n";
    let write = |name: &str, text: &str| -> Result<()> {
        Ok(atomic_write(&args.out.join(name), |file| file.write_all(text.as_bytes()))?)
    };
    write("fleet.csv", &platforms.csv())?;
    write("fleet.txt", &text)?;
    write("fleet.json", &json)?;
    if args.json {
        out!("{json}")?;
    } else {
        out!("{text}")?;
        outln!("\nall of it: {}", Path::new(&args.out).join("fleet.json").display())?;
    }
    Ok(())
}
