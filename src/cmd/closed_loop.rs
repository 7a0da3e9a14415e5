//! `dpn eval --closed-loop`.

use super::{program, settings, shipped, stop};
use crate::args::{CameraArg, EvalArgs};
use crate::ui::{Bar, Fault, Interrupted, errln, out, outln};
use anyhow::Result;
use dpn_core::estimate::parse_list;
use dpn_eval::closed_loop::{
    ClosedLoopError, Consistency, ImageSource, Keep, Manifest, SequenceSet, Sweep, TrackSource, consistency,
};
use dpn_eval::study::{MARGIN, RowSet, Study};
use dpn_io::{FolderLock, atomic_write};
use dpn_papers::tables;
use dpn_pronet::network;
use std::path::PathBuf;

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    let closed = &args.closed;
    let noises = parse_list(&closed.noise)?;
    let estimator = settings::estimator(&closed.settings)?;
    let source = source(args)?;
    if closed.seeds > 1 && !(source.tracks_are_seeded() || source.recordings_are_seeded()) {
        return Err(Fault::new("given tracks have no seed, and --seeds asks for several")
            .hint("leave --tracks away, and tracks are made from the seed")
            .into());
    }
    let networks = match &args.models {
        Some(dir) => network::load_all(dir)?,
        None => shipped::networks()?,
    };
    let sweep = Sweep {
        source: &source,
        places: source.select(&closed.sequences)?,
        noises,
        seeds: (args.seed..args.seed.saturating_add(closed.seeds)).collect(),
        others: (Vec::new(), Vec::new()),
        from: closed.from,
        to: closed.to,
        estimator,
        networks: &networks,
        threads: closed.threads.unwrap_or_else(cores).max(1),
        keep: Keep { trajectories: closed.trajectories, nees: true, states: None },
        injection: match &closed.inject {
            Some(path) => Some(dpn_io::config::load(path)?),
            None => None,
        },
    };
    for warning in sweep.estimator.warnings() {
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
    let reports = consistency(&out, &rows)?;
    let set = RowSet::new(&rows);
    let study = Study::new(&set, MARGIN).map_err(ClosedLoopError::from)?;
    let table = printed(&set, &study, &reports);
    let json = serde_json::json!({ "rows": rows, "study": study, "consistency": reports });
    atomic_write(&out.join("closed_loop.json"), |file| writeln!(file, "{json}"))?;
    atomic_write(&out.join("closed_loop.txt"), |file| file.write_all(table.as_bytes()))?;
    if args.json {
        outln!("{json}")?;
    } else {
        out!("{table}")?;
        outln!("\nrows: {}", out.join("rows.jsonl").display())?;
    }
    Ok(())
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

/// Sequences on disk, or the simulated flights.
fn source(args: &EvalArgs) -> Result<SequenceSet> {
    let made = TrackSource::Simulated(settings::tracks(&args.closed.settings)?);
    let tracks = match (args.closed.camera, &args.closed.tracks) {
        (CameraArg::Tracks, Some(dir)) => TrackSource::File(dir.clone()),
        (CameraArg::Tracks, None) => made,
        (CameraArg::Images, None) => {
            let images = ImageSource::Folder { skip_missing: args.closed.skip_missing };
            TrackSource::Images(images)
        }
        (CameraArg::Rendered, None) => {
            let images = ImageSource::Rendered(Box::new(settings::images(&args.closed.settings)?));
            TrackSource::Images(images)
        }
        (CameraArg::Images | CameraArg::Rendered, Some(_)) => {
            return Err(Fault::new("--tracks and --camera images or rendered ask for two things")
                .hint("leave one of them away")
                .into());
        }
    };
    match &args.data {
        Some(dir) => {
            let set = SequenceSet::recorded(dir, tracks)?;
            Ok(match &args.closed.truth {
                Some(truth) => set.with_reconciled_truth(truth),
                None => set,
            })
        }
        None => Ok(SequenceSet::Flights { config: settings::flights(&args.closed.settings)?, tracks }),
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
