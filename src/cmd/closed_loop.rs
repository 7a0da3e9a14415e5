//! `dpn eval --closed-loop`.

use super::cores::cores;
use super::{VERSION, cache, program, settings, shipped, stop};
use crate::args::{CacheArgs, EvalArgs};
use crate::ui::{Bar, errln, out, outln, warn};
use anyhow::Result;
use dpn_core::estimate::parse_list;
use dpn_eval::closed_loop::{
    ClosedLoopError, Consistency, Experiment, Manifest, Row, Settings, Sweep, TrackCache, consistency,
};
use dpn_eval::study::{MARGIN, RowSet, Study, StudyFile};
use dpn_figures::{Table, if_any, save};
use dpn_io::{FolderLock, ResultPath, atomic_write, write_file};
use dpn_papers::{LoopPage, loop_curve, tables as table};
use dpn_pronet::network::Network;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    let experiment = experiment(args)?;
    if let Some(given) = &experiment.calibration {
        errln!("calibration: {given}");
    }
    let networks = shipped::or_of(experiment.models.as_deref())?;
    let machine = Machine::new(&args.closed.cache, args.closed.threads)?;
    let done = machine.run(&experiment, &networks, args.out.as_ref())?;
    say(&done, args.json)
}

/// What experiments are run with on this machine.
pub(super) struct Machine {
    threads: usize,
    cache: Option<TrackCache>,
    stop: Arc<AtomicBool>,
}

impl Machine {
    /// To be made once, for it listens for Ctrl-C.
    pub(super) fn new(cache: &CacheArgs, threads: Option<usize>) -> Result<Self> {
        let kept = "cells that were finished are kept, and the same command goes on from there";
        let (cache, stop) = (cache::open(cache)?, stop::on_ctrl_c(kept)?);
        Ok(Self { threads: threads.unwrap_or_else(cores).max(1), cache, stop })
    }

    /// Runs what is left of an experiment in the folder `out`, one named by a checksum without it, and writes the tables there.
    pub(super) fn run(
        &self,
        experiment: &Experiment,
        networks: &[Network],
        out: Option<&ResultPath>,
    ) -> Result<LoopTables> {
        let source = experiment.source()?;
        let (threads, cache) = (self.threads, self.cache.as_ref());
        let sweep = Sweep { threads, cache, ..experiment.sweep(&source, networks)? };
        warn(experiment.warnings()?);
        let manifest = Manifest::of(&sweep, program())?;
        let named = || format!("runs/closed-loop-{}", &manifest.fingerprint()[..8]).into();
        let out = out.map_or_else(named, ResultPath::clone);
        // Until the tables are written: they are of these rows.
        let lock = FolderLock::take(&out)?;
        let rows = stop::outcome(sweep.run(&lock, &manifest, &self.stop, &mut Bar::new()), |error| {
            matches!(error, ClosedLoopError::Stopped { .. })
        })?;
        cache::say(cache);
        tables(out, rows)
    }
}

/// The flags as an experiment.
fn experiment(args: &EvalArgs) -> Result<Experiment> {
    let closed = &args.closed;
    Ok(Experiment {
        data: args.data.clone(),
        models: args.models.clone(),
        camera: closed.camera,
        tracks: closed.tracks.clone(),
        truth: closed.truth.clone(),
        calibration: settings::calibration(&closed.settings)?,
        skip_missing: closed.skip_missing,
        image_topic: closed.image_topic.clone(),
        topic: closed.topic.clone(),
        sequences: closed.sequences.clone(),
        noises: parse_list(&closed.noise)?,
        seed: args.seed,
        seeds: closed.seeds,
        from: closed.from,
        to: closed.to,
        injection: closed.inject.clone().map(Settings::File),
        trajectories: closed.trajectories,
        ..settings::experiment(&closed.settings)?
    })
}

/// The tables of a closed loop, as they were written into its folder.
pub(super) struct LoopTables {
    out: ResultPath,
    pub(super) rows: Vec<Row>,
    text: String,
    json: String,
}

/// Prints the tables.
pub(super) fn say(done: &LoopTables, json: bool) -> Result<()> {
    if json {
        outln!("{}", done.json)?;
    } else {
        out!("{}", done.text)?;
        outln!("\nrows: {}", done.out.join("rows.jsonl").display())?;
        outln!("page: {}", done.out.join("closed_loop.html").display())?;
    }
    Ok(())
}

/// Writes the tables of the rows in `out`.
pub(super) fn tables(out: ResultPath, rows: Vec<Row>) -> Result<LoopTables> {
    let reports = consistency(&out, &rows)?;
    let set = RowSet::new(&rows);
    let study = Study::new(&set, MARGIN).map_err(ClosedLoopError::from)?;
    let all = all_tables(&set, &study, &reports);
    let text = printed(&all, &study);
    let json = serde_json::to_string(&StudyFile { consistency: &reports, rows: &rows, study: &study })?;
    atomic_write(out.join("closed_loop.json"), |file| writeln!(file, "{json}"))?;
    write_file(out.join("closed_loop.txt"), &text)?;
    let curve = if_any(loop_curve(&study))?;
    if let Some(curve) = &curve {
        save(curve, out.join("closed_loop"))?;
    }
    let page = LoopPage::new(&study, &all, curve.as_ref(), VERSION)?;
    write_file(out.join("closed_loop.html"), page.html()?)?;
    Ok(LoopTables { out, rows, text, json })
}

/// Errors by sequence and by noise; comparisons, consistency and doubts, where there are any.
fn all_tables(rows: &RowSet<'_>, study: &Study, reports: &[Consistency]) -> Vec<Table> {
    let optional = [table::comparisons(study), table::consistency(reports), table::doubts(rows)];
    [table::ate(rows), table::summaries(study)].into_iter().chain(optional.into_iter().flatten()).collect()
}

/// The tables, an empty line between two.
fn printed(tables: &[Table], study: &Study) -> String {
    let mut parts: Vec<String> = tables.iter().map(Table::console).collect();
    if study.reference.is_none() && study.noises.len() > 1 {
        let why = "Nothing is compared: x1 was not run, and a constant is chosen only where there are both training and test sequences\n";
        parts.insert(2, why.into());
    }
    parts.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;

    #[test]
    fn flags_that_are_left_out_are_keys_that_are_left_out_of_a_plan() {
        let Command::Eval(args) = Cli::parse_from(["dpn", "eval", "--closed-loop"]).command else {
            panic!("eval was typed")
        };
        assert_eq!(experiment(&args).expect("defaults hold together"), Experiment::default());
    }
}
