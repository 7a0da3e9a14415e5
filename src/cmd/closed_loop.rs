//! `dpn eval --closed-loop`.

use super::{program, settings, shipped, stop};
use crate::args::{CameraArg, EvalArgs};
use crate::ui::{Bar, Fault, Interrupted};
use anyhow::Result;
use dpn_core::io::atomic_write;
use dpn_eval::closed_loop::{
    ClosedLoopError, Images, Manifest, Source, Sweep, Tracks, Vision, compare, consistency, render,
    render_comparisons, render_consistency,
};
use dpn_eval::noise::parse_list;
use dpn_eval::open_loop::networks;
use dpn_vio::EstimatorConfig;
use std::collections::BTreeMap;
use std::path::PathBuf;

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    let closed = &args.closed;
    let noises = parse_list(&closed.noise)?;
    let estimator = settings::estimator(&closed.settings)?;
    let source = source(args, &estimator)?;
    if closed.seeds > 1 && !(source.tracks_are_seeded() || source.recordings_are_seeded()) {
        return Err(Fault::new("given tracks have no seed, and --seeds asks for several")
            .hint("leave --tracks away, and tracks are made from the seed")
            .into());
    }
    let networks = match &args.models {
        Some(dir) => networks::load_all(dir)?,
        None => shipped::networks()?,
    };
    let sweep = Sweep {
        source: &source,
        places: source.select(&closed.sequences)?,
        noises,
        seeds: (args.seed..args.seed.saturating_add(closed.seeds)).collect(),
        from: closed.from,
        estimator,
        networks: &networks,
        threads: closed.threads.unwrap_or_else(cores).max(1),
        trajectories: closed.trajectories,
    };
    for warning in sweep.estimator.warnings() {
        eprintln!("warning: {warning}");
    }
    let manifest = manifest(args, &sweep)?;
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("runs/closed-loop-{}", &manifest.fingerprint()[..8])));
    let stop = stop::on_ctrl_c()?;
    let rows = match sweep.run(&out, &manifest, &stop, &mut Bar::new()) {
        Err(error @ ClosedLoopError::Stopped { .. }) => {
            return Err(Interrupted(format!("{error}; the same command goes on from there")).into());
        }
        other => other?,
    };
    let reports = consistency(&out, &rows)?;
    let comparisons = compare(&rows).map_err(ClosedLoopError::from)?;
    let parts = [render(&rows)?, render_comparisons(&comparisons), render_consistency(&reports)];
    let table = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n");
    let json = serde_json::json!({ "rows": rows, "comparisons": comparisons, "consistency": reports });
    atomic_write(&out.join("closed_loop.json"), |file| writeln!(file, "{json}"))?;
    atomic_write(&out.join("closed_loop.txt"), |file| file.write_all(table.as_bytes()))?;
    if args.json {
        println!("{json}");
    } else {
        print!("{table}");
        println!("\nrows: {}", out.join("rows.jsonl").display());
    }
    Ok(())
}

/// Sequences on disk, or the simulated flights.
fn source(args: &EvalArgs, estimator: &EstimatorConfig) -> Result<Source> {
    let made = Tracks::Made(settings::tracks(&args.closed.settings)?);
    let tracks = match (args.closed.camera, &args.closed.tracks) {
        (CameraArg::Tracks, Some(dir)) => Tracks::Given(dir.clone()),
        (CameraArg::Tracks, None) => made,
        (CameraArg::Images, None) => {
            let images = Images::Folder { skip_missing: args.closed.skip_missing };
            Tracks::Seen(Vision { images, front_end: estimator.front_end })
        }
        (CameraArg::Rendered, None) => {
            let images = Images::Rendered(Box::new(settings::images(&args.closed.settings)?));
            Tracks::Seen(Vision { images, front_end: estimator.front_end })
        }
        (CameraArg::Images | CameraArg::Rendered, Some(_)) => {
            return Err(Fault::new("--tracks and --camera images or rendered ask for two things")
                .hint("leave one of them away")
                .into());
        }
    };
    match &args.data {
        Some(dir) => Ok(Source::recorded(dir, tracks)?),
        None => Ok(Source::Flights { config: settings::flights(&args.closed.settings)?, tracks }),
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// What the results are a function of.
fn manifest(args: &EvalArgs, sweep: &Sweep<'_>) -> Result<Manifest> {
    let names = sweep.source.names();
    let mut inputs = BTreeMap::new();
    for &place in &sweep.places {
        inputs.insert(names[place].0.clone(), sweep.source.checksum(place)?);
    }
    if let Some(dir) = &args.models {
        inputs.insert("models".into(), dir.display().to_string());
    }
    let tracks = match sweep.source.tracks() {
        Tracks::Given(_) => serde_json::json!("given"),
        Tracks::Made(config) => serde_json::json!(config),
        // The front-end's settings are the estimator's.
        Tracks::Seen(vision) => match &vision.images {
            Images::Folder { .. } => serde_json::json!(vision.images.name()),
            Images::Rendered(config) => serde_json::json!({ "rendered": config }),
        },
    };
    let source = match sweep.source {
        Source::Recorded { .. } => serde_json::json!({ "tracks": tracks }),
        Source::Flights { config, .. } => serde_json::json!({ "flights": config, "tracks": tracks }),
    };
    let specs: Vec<String> = sweep.noises.iter().map(ToString::to_string).collect();
    let sequences: Vec<&str> = sweep.places.iter().map(|place| names[*place].0.as_str()).collect();
    Ok(Manifest {
        program: program(),
        estimator: serde_json::to_value(&sweep.estimator)?,
        source,
        from: sweep.from.to_string(),
        inputs,
        cells: serde_json::json!({ "sequences": sequences, "noises": specs, "seeds": sweep.seeds }),
    })
}
