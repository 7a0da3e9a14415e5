//! `dpn eval --closed-loop`.

use super::cores::cores;
use super::{cache, program, settings, shipped, stop};
use crate::args::EvalArgs;
use crate::ui::{Bar, Interrupted, errln, out, outln};
use anyhow::Result;
use dpn_core::estimate::parse_list;
use dpn_eval::closed_loop::{ClosedLoopError, Consistency, Manifest, Row, Sweep, consistency};
use dpn_eval::study::{MARGIN, RowSet, Study, StudyFile};
use dpn_eval::sweeps::LoopPlan;
use dpn_io::{FolderLock, atomic_write};
use dpn_papers::tables;
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    let plan = plan(args)?;
    if let Some(given) = &plan.calibration {
        errln!("calibration: {given}");
    }
    let source = plan.source()?;
    let networks = shipped::or_of(plan.models.as_deref())?;
    let cache = cache::open(&args.closed.cache)?;
    let threads = args.closed.threads.unwrap_or_else(cores).max(1);
    let sweep = Sweep { cache: cache.as_ref(), ..plan.sweep(&source, &networks, threads)? };
    for warning in sweep.warnings() {
        errln!("warning: {warning}");
    }
    let manifest = Manifest::of(&sweep, program())?;
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("runs/closed-loop-{}", &manifest.fingerprint()[..8])));
    let stop = stop::on_ctrl_c("cells that were finished are kept, and the same command goes on from there")?;
    // Until the tables are written: they are of these rows.
    let lock = FolderLock::take(&out)?;
    let rows = match sweep.run(&lock, &manifest, &stop, &mut Bar::new()) {
        Err(error @ ClosedLoopError::Stopped { .. }) => {
            return Err(Interrupted(format!("{error}; the same command goes on from there")).into());
        }
        other => other?,
    };
    cache::say(cache.as_ref());
    tell(&out, &rows, args.json)
}

/// The flags as a plan.
fn plan(args: &EvalArgs) -> Result<LoopPlan> {
    let closed = &args.closed;
    let calibration = settings::calibration(&closed.settings)?;
    Ok(LoopPlan {
        data: args.data.clone(),
        models: args.models.clone(),
        camera: closed.camera.into(),
        tracks: closed.tracks.clone(),
        truth: closed.truth.clone(),
        skip_missing: closed.skip_missing,
        image_topic: closed.image_topic.clone(),
        topic: closed.topic.clone(),
        sequences: closed.sequences.clone(),
        noises: parse_list(&closed.noise)?,
        seed: args.seed,
        seeds: closed.seeds,
        from: closed.from,
        to: closed.to,
        estimator: settings::estimator(&closed.settings)?.into(),
        simulated_tracks: settings::tracks(&closed.settings, calibration.as_ref())?.into(),
        images: settings::images(&closed.settings, calibration.as_ref())?.into(),
        flights: settings::flights(&closed.settings)?.into(),
        injection: match &closed.inject {
            Some(path) => Some(dpn_io::config::load::<dpn_eval::injected::Injection>(path)?.into()),
            None => None,
        },
        trajectories: closed.trajectories,
        calibration,
        ..LoopPlan::default()
    })
}

/// Makes the tables of the rows in `out`, writes and prints them.
pub(crate) fn tell(out: &Path, rows: &[Row], json: bool) -> Result<()> {
    let (table, results) = write(out, rows)?;
    if json {
        outln!("{results}")?;
    } else {
        out!("{table}")?;
        outln!("\nrows: {}", out.join("rows.jsonl").display())?;
    }
    Ok(())
}

/// Writes the tables of the rows in `out`; what stands in them, as text and as JSON.
pub(super) fn write(out: &Path, rows: &[Row]) -> Result<(String, String)> {
    let reports = consistency(out, rows)?;
    let set = RowSet::new(rows);
    let study = Study::new(&set, MARGIN).map_err(ClosedLoopError::from)?;
    let table = printed(&set, &study, &reports);
    let results = serde_json::to_string(&StudyFile { consistency: &reports, rows, study: &study })?;
    atomic_write(&out.join("closed_loop.json"), |file| writeln!(file, "{results}"))?;
    atomic_write(&out.join("closed_loop.txt"), |file| file.write_all(table.as_bytes()))?;
    Ok((table, results))
}

/// The tables, an empty line between two.
fn printed(rows: &RowSet<'_>, study: &Study, reports: &[Consistency]) -> String {
    let mut parts = vec![tables::ate(rows).console(), tables::summaries(study).console()];
    match tables::comparisons(study) {
        Some(table) => parts.push(table.console()),
        None if study.reference.is_none() && study.noises.len() > 1 => parts.push(
            "Nothing is compared: x1 was not run, and a constant is chosen only where there are both training and test sequences\n".into(),
        ),
        None => {}
    }
    parts.extend(tables::consistency(reports).map(|table| table.console()));
    parts.join("\n")
}
