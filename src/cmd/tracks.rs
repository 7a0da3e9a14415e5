//! `dpn simulate tracks`.

use crate::args::TracksArgs;
use crate::ui::{Fault, outln};
use anyhow::Result;
use dpn_core::config::Validate;
use dpn_core::{SampleRate, Stamp};
use dpn_eval::closed_loop::path_config;
use dpn_io::asl::Sequence;
use dpn_io::write_tracks;
use dpn_sim::tracks::{
    AnalyticPath, CameraPath, CameraSettings, RecordedPath, TracksConfig, TracksError, camera_stamps,
    simulate_tracks, summarise,
};
use dpn_sim::{Flight, FlightConfig};
use std::path::{Path, PathBuf};

/// Rate of a camera that is not there \[Hz\]: EuRoC's.
pub(super) const CAMERA_HZ: f64 = 20.0;
/// A faster one is a slip in its calibration \[Hz\].
const FASTEST_CAMERA_HZ: f64 = 1000.0;

/// Where tracks come from.
struct SeenPath {
    name: String,
    path: Box<dyn CameraPath>,
    stamps: Vec<Stamp>,
}

pub(crate) fn run(args: &TracksArgs) -> Result<()> {
    let mut config: TracksConfig = match &args.config {
        Some(path) => dpn_io::config::load(path)?,
        None => TracksConfig::default(),
    };
    args.over(&mut config);
    let faults = config.faults();
    if !faults.is_empty() {
        return Err(TracksError::Config(faults).into());
    }
    let source = open(args, &mut config)?;
    let frames = simulate_tracks(&config, source.path.as_ref(), &source.stamps, args.seed)?;
    let out =
        args.out.clone().unwrap_or_else(|| PathBuf::from("runs/tracks").join(format!("{}.txt", source.name)));
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

/// A folder is a sequence, anything else a flight.
fn open(args: &TracksArgs, config: &mut TracksConfig) -> Result<SeenPath> {
    let dir = Path::new(&args.source);
    if dir.exists() {
        return sequence(&recorded(dir, args.truth.as_deref())?, config);
    }
    let flight: Flight = args.source.parse().map_err(|unknown| unknown_source(&args.source, &unknown))?;
    if args.truth.is_some() {
        return Err(truth_of_a_flight().into());
    }
    let flown = FlightConfig::default();
    let path =
        AnalyticPath::new(dpn_sim::path(flight, args.flight_seed, &flown)?, Stamp::from_ns(flown.epoch_ns));
    let stamps = made_stamps(&path, CAMERA_HZ)?;
    Ok(SeenPath { name: flight.name().to_owned(), path: Box::new(path), stamps })
}

/// The sequence in `dir`, with the reconciled ground truth of another folder where one is named.
pub(super) fn recorded(dir: &Path, truth: Option<&Path>) -> Result<Sequence> {
    let sequence = Sequence::open(dir)?;
    Ok(match truth {
        Some(truth) => sequence.with_reconciled_truth(truth),
        None => sequence,
    })
}

/// A flight has no other ground truth than its own.
pub(super) fn truth_of_a_flight() -> Fault {
    Fault::new("--truth is for a recording; a flight's ground truth is exact").hint("leave --truth away")
}

/// What is neither a folder nor a flight.
pub(super) fn unknown_source(source: &str, unknown: &dyn std::fmt::Display) -> Fault {
    Fault::new(format!("there is no folder `{source}`, and {unknown}"))
        .hint("name a folder with an ASL sequence, or a flight of `dpn simulate flight --list`")
}

/// A sequence that nothing can be made along; `why` it would have to be there.
pub(super) fn no_ground_truth(dir: &Path, why: &str) -> Fault {
    let looked = "state_groundtruth_estimate0/data.csv and mocap0/data.csv are not there";
    Fault::new(format!("{}: no ground truth: {looked}", dir.display()))
        .hint(format!("{why}; without them only real images can be tracked"))
}

/// A sequence's own lens that cannot be simulated; `file` shows how another is given.
pub(super) fn unsuited_lens(dir: &Path, error: &dyn std::fmt::Display, file: &str) -> Fault {
    Fault::new(format!("{}: {error}", dir.display()))
        .hint(format!("or give the camera to simulate as `[camera]` in a file: {file}"))
}

/// Stamps of a camera that left none.
pub(super) fn made_stamps(path: &dyn CameraPath, hz: f64) -> Result<Vec<Stamp>> {
    let rate = SampleRate::from_hz(hz).filter(|rate| rate.hz() <= FASTEST_CAMERA_HZ);
    let rate =
        rate.ok_or_else(|| Fault::new(format!("a camera of {hz} Hz; at most {FASTEST_CAMERA_HZ} are made")))?;
    Ok(camera_stamps(path, rate))
}

/// The sequence's own camera and stamps where it has them.
fn sequence(sequence: &Sequence, config: &mut TracksConfig) -> Result<SeenPath> {
    let dir = sequence.dir();
    if sequence.ground_truth_path().is_none() {
        return Err(no_ground_truth(dir, "tracks are made along true poses").into());
    }
    let path = RecordedPath::new(&sequence.ground_truth()?, &path_config(sequence, &config.path))?;
    let camera = sequence.camera_config()?;
    if let (None, Some(own)) = (&config.camera, &camera) {
        let settings = CameraSettings::try_from(own);
        config.camera = Some(settings.map_err(|e| unsuited_lens(dir, &e, "configs/tracks/euroc.toml"))?);
    }
    let stamps = if sequence.has_camera_frames() {
        sequence.camera_frames()?.iter().map(|frame| frame.t).collect()
    } else {
        made_stamps(&path, camera.map_or(CAMERA_HZ, |camera| camera.rate.hz()))?
    };
    Ok(SeenPath { name: sequence.name().to_owned(), path: Box::new(path), stamps })
}
