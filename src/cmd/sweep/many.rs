//! `dpn train --many`: a plan's trainings on this machine, several at a time. A sweep of one training a shard, planned, run and collected at once.

use super::trainer::CorpusTrainer;
use crate::args::TrainArgs;
use crate::cmd::cores::cores;
use crate::cmd::device::CPU;
use crate::cmd::{program, stop};
use crate::ui::{Bar, Interrupted, errln, outln, refuse};
use anyhow::Result;
use dpn_core::progress::{Progress, Silent};
use dpn_eval::sweeps::{
    JobToPlan, Node, PlanKind, Size, SweepError, SweepFolder, SweepManifest, TrainPlan, by_itself, collect,
    plan, run_shard,
};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Folder of the sweep, below the results'.
const SWEEP: &str = "sweep";
/// Trainings at a time that go to a card together.
const ON_CARD: usize = 16;

pub(crate) fn many(file: &Path, args: &TrainArgs) -> Result<()> {
    if PlanKind::read(file)? != PlanKind::Train {
        return refuse(
            format!("{}: this plan trains nothing", file.display()),
            "its kind must be \"train\", as in configs/sweep/train.toml",
        );
    }
    let mut asked: TrainPlan = dpn_io::config::load(file)?;
    asked.data = args.data.clone().or(asked.data);
    asked.device = args.device.clone().unwrap_or(asked.device);
    // All workers' too: the corpus is read once a process.
    let trainer = CorpusTrainer::new(asked.data.clone());
    let trainings = trainer.clone().trainings(&asked)?;
    let (count, device) = (trainings.len(), asked.device.clone());
    let manifest = SweepManifest::new(program(), dpn_pronet::processor(), asked.data, false);
    let jobs = [JobToPlan::Train(trainings)];
    let manifest = plan(manifest, &jobs, Size::Shards(count))?.manifest;
    let out = args.out.clone().unwrap_or_else(|| "runs/train-many".into());
    SweepFolder::may_take(&out.join(SWEEP), &manifest)?;
    let folder = SweepFolder::create(&out.join(SWEEP), manifest)?;
    let stop =
        stop::on_ctrl_c("epochs that were finished are kept, and the same command goes on from there")?;
    let clock = Instant::now();
    let usual = if device == CPU { cores() } else { ON_CARD };
    let workers = args.jobs.map_or(usual, |jobs| jobs as usize).min(count);
    let made = work_off(&folder, &trainer, workers, &stop)?;
    let done = collect(&folder, &out, false)?;
    let hours = clock.elapsed().as_secs_f64() / 3600.0;
    match made {
        0 => errln!("{count} networks, all of them trained before"),
        made => {
            errln!(
                "{made} networks trained on {device}, {workers} at a time: {:.0} an hour",
                made as f64 / hours
            );
        }
    }
    if args.json {
        let words = serde_json::json!({
            "networks": done.rows, "trained": made, "at_a_time": workers, "device": device, "hours": hours,
        });
        outln!("{words}")?;
    } else {
        outln!("{}", out.display())?;
    }
    Ok(())
}

/// Works off every shard, `workers` at a time; how many were not there before.
fn work_off(
    folder: &SweepFolder,
    trainer: &CorpusTrainer,
    workers: usize,
    stop: &AtomicBool,
) -> Result<usize> {
    let (program, processor) = (program(), dpn_pronet::processor());
    let (next, made, total) = (AtomicUsize::new(0), AtomicUsize::new(0), folder.shards());
    let bar = Mutex::new((0, Bar::new()));
    let told = || bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    told().1.start("networks", total as u64);
    let worker = || -> Result<(), SweepError> {
        let here = Node {
            program: program.clone(),
            processor: processor.clone(),
            data: folder.manifest.data.as_deref(),
            tracks: None,
            truth: None,
            networks: &[],
            threads: 1,
            cache: None,
        };
        if workers >= cores() {
            by_itself();
        }
        let mut trainer = trainer.clone();
        loop {
            let shard = next.fetch_add(1, Ordering::Relaxed);
            if shard >= total {
                return Ok(());
            }
            let ended = run_shard(folder, shard, &here, &mut trainer, stop, &mut Silent)?;
            made.fetch_add(usize::from(!ended.was_there), Ordering::Relaxed);
            let (done, bar) = &mut *told();
            *done += 1;
            bar.step(*done, "");
        }
    };
    let ends: Vec<Result<(), SweepError>> = std::thread::scope(|scope| {
        let all: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        all.into_iter()
            .map(|one| one.join().expect("a training that panics is a fault of the program"))
            .collect()
    });
    let (done, mut bar) = bar.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    bar.finish(&format!("{done} of {total}"));
    for end in ends {
        match end {
            Ok(()) => {}
            Err(error) if error.is_stop() => {
                let words =
                    format!("stopped after {done} of {total} networks; the same command goes on from there");
                return Err(Interrupted(words).into());
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(made.into_inner())
}
