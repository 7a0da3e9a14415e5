//! `dpn simulate tracks`.

use super::{along, apart};
use crate::args::TracksArgs;
use crate::ui::outln;
use anyhow::Result;
use dpn_io::config::load_over;
use dpn_io::write_tracks;
use dpn_sim::tracks::{TracksConfig, simulate_tracks, summarise};
use std::path::PathBuf;

pub(crate) fn run(TracksArgs { along: args, out }: &TracksArgs) -> Result<()> {
    let mut config: TracksConfig = load_over(args.config.as_deref(), &args.sets)?;
    let source = along::open(args, "tracks", &config.path, &mut config.camera)?;
    if let Some(out) = out {
        apart::file("--out", out, &[&args.source])?;
    }
    let frames = simulate_tracks(&config, source.path.as_ref(), &source.stamps, args.seed)?;
    let out =
        out.clone().unwrap_or_else(|| PathBuf::from("runs/tracks").join(format!("{}.txt", source.name)));
    write_tracks(&out, &frames)?;
    let counts = summarise(&frames);
    if args.json {
        let row = serde_json::json!({
            "sequence": source.name, "seed": args.seed, "world": config.world.settled(&source.path.bounds()),
            "camera_frames": source.stamps.len(), "frames": counts.frames, "tracks": counts.tracks,
            "mean_in_frame": counts.mean_in_frame, "mean_life_frames": counts.mean_life, "file": out,
        });
        outln!("{row}")?;
    } else {
        outln!(
            "{}: {} frames of {} camera frames, {} tracks, {:.1} in a frame, each in {:.1} frames",
            out.display(),
            counts.frames,
            source.stamps.len(),
            counts.tracks,
            counts.mean_in_frame,
            counts.mean_life
        )?;
    }
    Ok(())
}
