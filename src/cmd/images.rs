//! `dpn simulate images`.

use super::tracks::{
    CAMERA_HZ, made_stamps, no_ground_truth, recorded, truth_of_a_flight, unknown_source, unsuited_lens,
};
use crate::args::ImagesArgs;
use crate::ui::{Bar, Fault, outln};
use anyhow::Result;
use dpn_core::camera::CameraConfig;
use dpn_core::config::Validate;
use dpn_core::imu::ImuRecording;
use dpn_core::progress::Progress;
use dpn_core::truth::GroundTruth;
use dpn_core::{SampleRate, Stamp};
use dpn_eval::closed_loop::path_config;
use dpn_io::asl::{
    CameraFrame, ImuConfig, Sequence, SequenceParts, image_place, write_camera_config, write_camera_frames,
    write_jpeg, write_png, write_sequence,
};
use dpn_io::{IoError, atomic_write};
use dpn_sim::render::{RenderError, SharedPath};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, RecordedPath};
use dpn_sim::{Flight, FlightConfig, RenderConfig, RenderedCamera, simulate};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;

/// Samples and true states this long before the first image and after the last go with a part of a sequence \[s\].
const MARGIN_S: f64 = 0.5;

/// Where images come from, and what goes with them.
struct SeenSequence {
    name: String,
    path: SharedPath,
    stamps: Vec<Stamp>,
    rate: SampleRate,
    imu: ImuRecording,
    imu_config: Option<ImuConfig>,
    truth: GroundTruth,
}

pub(crate) fn run(args: &ImagesArgs) -> Result<()> {
    let mut config: RenderConfig = match &args.config {
        Some(path) => dpn_io::config::load(path)?,
        None => RenderConfig::default(),
    };
    args.over(&mut config);
    let faults = config.faults();
    if !faults.is_empty() {
        return Err(RenderError::Config(faults).into());
    }
    let mut source = open(args, &mut config)?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("runs/images").join(&source.name));
    if out.join("mav0").exists() || out.is_file() {
        let remedy = "name another folder with --out, or remove this one: images of two runs are not mixed";
        return Err(Fault::new(format!("{} is there already", out.display())).hint(remedy).into());
    }
    let camera = RenderedCamera::new(&config, source.path.clone(), args.seed)?;
    source.cut(args, &camera)?;

    let ending = if args.jpeg.is_some() { "jpg" } else { "png" };
    let frames: Vec<CameraFrame> =
        source.stamps.iter().map(|t| CameraFrame { t: *t, file: format!("{}.{ending}", t.ns()) }).collect();
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    write_images(&camera, &frames, &out, args.jpeg, args.threads.unwrap_or_else(cores).max(1))?;
    write_camera_frames(&out, &frames)?;
    write_camera_config(&out, &calibration(camera.settings(), source.rate)?)?;
    let imu_config = source.imu_config.as_ref();
    write_sequence(&out, &SequenceParts { imu: &source.imu, imu_config, ground_truth: Some(&source.truth) })?;
    repeat_rows(&Sequence::open(&out)?.imu_path(), args.repeated_rows)?;
    if args.json {
        let row = serde_json::json!({
            "sequence": source.name, "seed": args.seed, "world": camera.world(), "images": frames.len(),
            "samples": source.imu.len(), "dir": out, "config": config,
        });
        outln!("{row}")?;
    } else {
        let seconds = source.imu.duration();
        outln!("{}: {} images, {} samples, {seconds:.1} s", out.display(), frames.len(), source.imu.len())?;
    }
    Ok(())
}

/// A folder is a sequence, anything else a flight.
fn open(args: &ImagesArgs, config: &mut RenderConfig) -> Result<SeenSequence> {
    let dir = Path::new(&args.source);
    if dir.exists() {
        return sequence(&recorded(dir, args.truth.as_deref())?, config);
    }
    let flight: Flight = args.source.parse().map_err(|unknown| unknown_source(&args.source, &unknown))?;
    if args.truth.is_some() {
        return Err(truth_of_a_flight().into());
    }
    let flown = simulate(flight, args.flight_seed, &FlightConfig::default())?;
    let path = AnalyticPath::of(&flown);
    Ok(SeenSequence {
        name: flight.name().to_owned(),
        stamps: made_stamps(&path, CAMERA_HZ)?,
        path: Arc::new(path),
        rate: rate(CAMERA_HZ)?,
        truth: GroundTruth::new(flown.ground_truth)?,
        imu: flown.recording,
        imu_config: None,
    })
}

/// The sequence's own camera and stamps where it has them.
fn sequence(sequence: &Sequence, config: &mut RenderConfig) -> Result<SeenSequence> {
    let dir = sequence.dir();
    if sequence.ground_truth_path().is_none() {
        return Err(no_ground_truth(dir, "images are rendered along true poses").into());
    }
    let truth = sequence.ground_truth()?;
    let path = RecordedPath::new(&truth, &path_config(sequence, &config.path))?;
    let camera = sequence.camera_config()?;
    if let (None, Some(own)) = (&config.camera, &camera) {
        let settings = CameraSettings::try_from(own);
        config.camera = Some(settings.map_err(|e| unsuited_lens(dir, &e, "configs/images/euroc.toml"))?);
    }
    let hz = camera.map_or(CAMERA_HZ, |camera| camera.rate.hz());
    let stamps = if sequence.has_camera_frames() {
        sequence.camera_frames()?.iter().map(|frame| frame.t).collect()
    } else {
        made_stamps(&path, hz)?
    };
    Ok(SeenSequence {
        name: sequence.name().to_owned(),
        path: Arc::new(path),
        stamps,
        rate: rate(hz)?,
        imu: sequence.imu()?,
        imu_config: sequence.imu_config()?,
        truth,
    })
}

fn rate(hz: f64) -> Result<SampleRate> {
    Ok(SampleRate::from_hz(hz).ok_or_else(|| Fault::new(format!("a camera of {hz} Hz")))?)
}

impl SeenSequence {
    /// Leaves the stamps asked for at which the path is known, and where a part was asked for its samples and true states alone.
    fn cut(&mut self, args: &ImagesArgs, camera: &RenderedCamera) -> Result<()> {
        let all = self.stamps.len();
        let Some(&first) = self.stamps.first() else {
            return Err(Fault::new(format!("{}: the camera has no frame", self.name)).into());
        };
        let (from, to) = (args.from.unwrap_or(0.0), args.to.unwrap_or(f64::INFINITY));
        // A microsecond outside is within, for seconds are rounded when they are written.
        let asked = |t: &Stamp| (from - 1e-6..=to + 1e-6).contains(&t.seconds_since(first));
        self.stamps.retain(|t| asked(t) && camera.takes(*t));
        let (Some(&begin), Some(&end)) = (self.stamps.first(), self.stamps.last()) else {
            let remedy = "widen --from and --to, and see that camera and ground truth are on one clock";
            let what = format!("{}: at none of its {all} frames asked for there is a true pose", self.name);
            return Err(Fault::new(what).hint(remedy).into());
        };
        if args.from.is_some() || args.to.is_some() {
            let near = |t: &Stamp| t.seconds_since(begin) >= -MARGIN_S && t.seconds_since(end) <= MARGIN_S;
            self.imu = ImuRecording::new(
                self.imu.samples().iter().filter(|sample| near(&sample.t)).copied().collect(),
            )?;
            let states = self.truth.states().iter().filter(|state| near(&state.t)).copied();
            self.truth = GroundTruth::new(states.collect())?;
        }
        Ok(())
    }
}

/// Renders and writes every frame; thread n of N those at n, n + N, ...
fn write_images(
    camera: &RenderedCamera,
    frames: &[CameraFrame],
    out: &Path,
    jpeg: Option<u8>,
    threads: usize,
) -> Result<()> {
    let mut bar = Bar::new();
    bar.start("rendering", frames.len() as u64);
    let (sender, written) = channel::<Result<(), IoError>>();
    let outcome = std::thread::scope(|scope| {
        for first in 0..threads {
            let (sender, mut camera) = (sender.clone(), camera.clone());
            scope.spawn(move || {
                for frame in frames.iter().skip(first).step_by(threads) {
                    let Some(image) = camera.image(frame.t) else { continue };
                    let place = image_place(out, frame);
                    let written = match jpeg {
                        Some(quality) => write_jpeg(&place, image.view(), quality),
                        None => write_png(&place, image.view()),
                    };
                    // Nobody listens any more after a fault.
                    if sender.send(written).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (done, written) in (1..).zip(written) {
            written?;
            bar.step(done, "");
        }
        Ok::<(), IoError>(())
    });
    outcome?;
    bar.finish(&format!("{} images", frames.len()));
    Ok(())
}

/// Writes a `share` of the rows of a table a second time, evenly spread.
fn repeat_rows(table: &Path, share: f64) -> Result<()> {
    if share == 0.0 {
        return Ok(());
    }
    let text = std::fs::read_to_string(table).map_err(|e| IoError::reading(table, e))?;
    atomic_write(table, |out| {
        let mut due = 0.0;
        for row in text.lines() {
            writeln!(out, "{row}")?;
            due += if row.starts_with('#') { 0.0 } else { share };
            if due >= 1.0 {
                due -= 1.0;
                writeln!(out, "{row}")?;
            }
        }
        Ok(())
    })?;
    Ok(())
}

/// What `cam0/sensor.yaml` says of it.
fn calibration(settings: &CameraSettings, rate: SampleRate) -> Result<CameraConfig> {
    let lens = settings.model()?.lens();
    Ok(CameraConfig {
        rate,
        resolution: settings.resolution,
        intrinsics: settings.intrinsics,
        distortion: lens.model(),
        coefficients: lens.coefficients(),
        body_from_cam: settings.body_from_cam()?,
    })
}
