//! `dpn simulate images`.

use super::along::{self, Along, Source};
use super::cores::cores;
use crate::args::ImagesArgs;
use crate::ui::{Bar, Fault, outln, refuse};
use anyhow::Result;
use dpn_core::camera::CameraConfig;
use dpn_core::imu::ImuRecording;
use dpn_core::progress::Progress;
use dpn_core::truth::GroundTruth;
use dpn_core::{SampleRate, Stamp};
use dpn_io::asl::{
    CameraFrame, SequenceParts, image_place, write_camera_config, write_camera_frames, write_png,
    write_sequence,
};
use dpn_io::config::load_over;
use dpn_io::{IoError, ResultPath};
use dpn_sim::tracks::CameraSettings;
use dpn_sim::{FlightConfig, RenderConfig, RenderedCamera, simulate};
use std::path::Path;
use std::sync::mpsc::channel;

/// Samples and true states this long before the first image and after the last go with a part of a sequence \[s\].
const MARGIN_S: f64 = 0.5;

pub(crate) fn run(args: &ImagesArgs) -> Result<()> {
    let along = &args.along;
    let mut config: RenderConfig = load_over(along.config.as_deref(), &along.sets)?;
    let source = along::open(along, "images", &config.path, &mut config.camera)?;
    let out = args.out.clone().unwrap_or_else(|| Path::new("runs/images").join(&source.name).into());
    if out.join("mav0").kind().is_some() || out.is_file() {
        let remedy = "name another folder with --out, or remove this one: images of two runs are not mixed";
        return refuse(format!("{} is there already", out.display()), remedy);
    }
    let camera = RenderedCamera::new(&config, source.path.clone(), along.seed)?;
    let (mut imu, mut truth, imu_config) = match &source.of {
        Source::Recorded(sequence) => (sequence.imu()?, sequence.ground_truth()?, sequence.imu_config()?),
        Source::Flown(flight) => {
            let flown = simulate(*flight, 0, &FlightConfig::default())?;
            (flown.recording, GroundTruth::new(flown.ground_truth)?, None)
        }
    };
    let stamps = asked_for(args, &source, &camera)?;
    if args.from.is_some() || args.to.is_some() {
        let (begin, end) = (stamps[0], stamps[stamps.len() - 1]);
        let near = |t: Stamp| t.seconds_since(begin) >= -MARGIN_S && t.seconds_since(end) <= MARGIN_S;
        imu = ImuRecording::new(imu.samples().iter().filter(|sample| near(sample.t)).copied().collect())?;
        truth = GroundTruth::new(truth.states().iter().filter(|state| near(state.t)).copied().collect())?;
    }

    let frames: Vec<CameraFrame> =
        stamps.iter().map(|t| CameraFrame { t: *t, file: format!("{}.png", t.ns()) }).collect();
    write_images(&camera, &frames, &out, args.threads.unwrap_or_else(cores).max(1))?;
    write_camera_frames(&out, &frames)?;
    write_camera_config(&out, &calibration(camera.settings(), source.rate)?)?;
    let parts = SequenceParts { imu: &imu, imu_config: imu_config.as_ref(), ground_truth: Some(&truth) };
    write_sequence(&out, &parts)?;
    if along.json {
        let row = serde_json::json!({
            "sequence": source.name, "seed": along.seed, "world": camera.world(), "images": frames.len(),
            "samples": imu.len(), "dir": out, "config": config,
        });
        outln!("{row}")?;
    } else {
        let seconds = imu.duration();
        outln!("{}: {} images, {} samples, {seconds:.1} s", out.display(), frames.len(), imu.len())?;
    }
    Ok(())
}

/// The stamps between --from and --to at which the path is known; at least one.
fn asked_for(args: &ImagesArgs, source: &Along, camera: &RenderedCamera) -> Result<Vec<Stamp>> {
    let Some(&first) = source.stamps.first() else {
        return Err(Fault::new(format!("{}: the camera has no frame", source.name)).into());
    };
    let (from, to) = (args.from.unwrap_or(0.0), args.to.unwrap_or(f64::INFINITY));
    // A microsecond outside is within, for seconds are rounded when they are written.
    let asked = |t: &Stamp| (from - 1e-6..=to + 1e-6).contains(&t.seconds_since(first));
    let taken = |t: &Stamp| asked(t) && camera.takes(*t);
    let stamps: Vec<Stamp> = source.stamps.iter().copied().filter(taken).collect();
    if stamps.is_empty() {
        let (name, all) = (&source.name, source.stamps.len());
        let remedy = "widen --from and --to, and see that camera and ground truth are on one clock";
        let what = format!("{name}: at none of its {all} frames asked for there is a true pose");
        return refuse(what, remedy);
    }
    Ok(stamps)
}

/// Renders and writes every frame; thread n of N those at n, n + N, ...
fn write_images(
    camera: &RenderedCamera,
    frames: &[CameraFrame],
    out: &ResultPath,
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
                    let written = write_png(image_place(out, frame), image.view());
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
