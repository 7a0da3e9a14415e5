//! `dpn run`.

use super::{apart, foxglove, learned, program, rerun, settings, shipped};
use crate::args::RunArgs;
use crate::ui::{Untrusted, errln, out, outln, refuse, warn};
use anyhow::Result;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{GrayImage, Stamp};
#[cfg(feature = "rerun")]
use dpn_eval::closed_loop::{CameraInput, frames_from};
use dpn_eval::closed_loop::{
    JudgedRun, Recording, Report, RunInfo, RunSource, SequenceSet, Span, Watchers, paired, watched_run,
    write_states,
};
use dpn_eval::metrics::{AlignmentKind, align};
use dpn_figures::{Album, Cell, save, timeline, top_view};
use dpn_io::calibration::Calibration;
use dpn_io::{ResultPath, atomic_write, write_file, write_noise_track, write_tum};
use dpn_live::settings_for;
use dpn_logs::ImageLogOptions;
use dpn_vio::clock::{CameraClock, Readout};
use dpn_vio::estimator::{EstimatorConfig, FrontEndObserver, Update};
use dpn_vio::frontend::Fed;
use dpn_vio::window::Window;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

pub(crate) fn run(args: &RunArgs) -> Result<()> {
    rerun::check(args.rerun.as_deref())?;
    if args.view.is_some() {
        let text = format!("--view is for what is read as it comes; `{}` is a recording", args.source);
        return refuse(text, "--mcap FILE keeps the run for Foxglove, with the same topics");
    }
    apart_from(args)?;
    let noise: NoiseSpec = args.noise.parse()?;
    let estimator = estimator(args)?;
    let calibration = settings::calibration(&args.settings)?;
    if let Some(given) = &calibration {
        errln!("calibration: {given}");
    }
    let (source, place) = open(args, calibration)?;
    if let Some((file, found)) = source.found_calibration() {
        errln!("calibration: found in {}: {found}", file.display());
    }
    let networks = shipped::or_of(args.models.as_deref())?;
    let recording = source.recording(place, args.seed)?;
    let span = Span { from_s: args.from.seconds(&recording.name), to_s: args.to };
    let mut album = args.draw.as_ref().map(|dir| Album::new(dir.clone(), args.draw_every));
    let camera = source.camera_input(place, args.seed, &span)?;
    let info = RunInfo::new(&source, &noise, args.seed, &span);
    #[cfg(feature = "rerun")]
    let scene = args.rerun.as_ref().map(|_| rerun::RunScene::new(&recording)).transpose()?;
    #[cfg(feature = "rerun")]
    if let (Some(scene), CameraInput::Tracks(frames, span)) = (&scene, &camera) {
        scene.tracks(frames_from(&recording, frames, span)?);
    }
    let mut log = args.mcap.as_ref().map(|_| foxglove::RunLog::new()).transpose()?;
    let mut images = Lookers(Vec::new());
    images.0.extend(log.as_mut().map(|log| log as &mut dyn FrontEndObserver));
    images.0.extend(album.as_mut().map(|album| album as &mut dyn FrontEndObserver));
    #[cfg(feature = "rerun")]
    let mut images_shown = scene.clone();
    #[cfg(feature = "rerun")]
    images.0.extend(images_shown.as_mut().map(|scene| scene as &mut dyn FrontEndObserver));
    let mut watch = |_update: &Update, _window: &Window| {
        #[cfg(feature = "rerun")]
        if let Some(scene) = &scene {
            scene.update(_update, _window);
        }
        ControlFlow::Continue(())
    };
    let watchers = Watchers { images: &mut images, updates: &mut watch };
    let done = watched_run(&estimator, &recording, camera, &noise, info, &networks, watchers)?;
    let out = args.out.clone().unwrap_or_else(|| format!("runs/run-{}", recording.name).into());
    let poses = done.output.poses();
    let pairs = match &recording.truth {
        Some(truth) if !poses.is_empty() => paired(truth, &poses)?,
        _ => Vec::new(),
    };
    let origin = (source.tracks.is_simulated(), source.truth());
    let report = done.json(&program(), &estimator, Some(&source.checksum(place)?), origin);
    write(&done, &report, &out)?;
    // Of a straight line there is no heading: the estimate is shown where it is.
    let aligned = align(&pairs, AlignmentKind::YawPosition).ok();
    let truth_from_world = aligned.map(|alignment| alignment.true_world_from_est_world);
    #[cfg(feature = "rerun")]
    if let Some((scene, file)) = scene.zip(args.rerun.as_ref()) {
        drop(images_shown);
        scene.finish(file, &recording, &done, truth_from_world.as_ref())?;
    }
    if let Some((log, file)) = log.zip(args.mcap.as_ref()) {
        log.finish(file, &recording, &done, truth_from_world.as_ref())?;
    }
    if let (Some(dir), Some(album)) = (&args.draw, album) {
        draw(dir, album, &recording, &done)?;
    }
    warn(settings_for(&estimator, &noise).warnings());
    warn(&done.report.warnings);
    if args.json {
        outln!("{report}")?;
    } else {
        let simulated = source.tracks.is_simulated();
        out!("{}", words(&done.report, &done, simulated))?;
        if let Some(learned) = &done.report.learned_noise {
            out!("{}", learned::paste(learned, args.paste.walks).page(&args.paste.paste.0))?;
        }
        outln!("files:          {}", out.display())?;
        if let Some(dir) = &args.draw {
            outln!("pictures:       {}", dir.display())?;
        }
    }
    if poses.is_empty() {
        errln!("warning: {}", no_pose(done.report.row.frames, &done.report.waited_for));
        return Err(Untrusted::NoPose.into());
    }
    if args.strict && done.report.is_doubted() {
        return Err(Untrusted::Doubted.into());
    }
    Ok(())
}

/// The estimator's settings, as typed.
pub(super) fn estimator(args: &RunArgs) -> Result<EstimatorConfig> {
    let mut settings = args.settings.clone();
    let offset = args.time_offset.map(|seconds| format!("{seconds:?}"));
    settings.sets.extend(offset.map(|seconds| ("front_end.time_offset_s".to_owned(), seconds)));
    settings::estimator(&settings)
}

/// What is said of a run without a pose: a recording may be too short for one, or at rest throughout.
pub(super) fn no_pose(frames: usize, waited_for: &BTreeMap<String, usize>) -> String {
    let waited = match waited_for.len() {
        0 => "no image had samples on both sides of it".to_owned(),
        _ => format!("never initialised; waited for {}", waiting(waited_for)),
    };
    let most = waited_for
        .iter()
        .filter(|(reason, _)| *reason != "too-few-frames")
        .max_by_key(|(_, frames)| **frames);
    let remedy = match most.map(|(reason, _)| reason.as_str()) {
        Some("at-rest") => "Nothing moved: carry the camera sideways, not only turn it",
        Some("too-little-parallax") => {
            "The camera turned, or moved too little for how far it sees: carry it sideways, past things that are near"
        }
        Some("too-few-tracks") => {
            "Points are lost from image to image: look for blur, darkness, a dirty lens (--draw shows the tracks)"
        }
        Some("implausible-accel-bias") => {
            "The accelerometer reads another force than gravity: its scale (--accel-scale), an axis or a sign is wrong (`dpn check`)"
        }
        Some("implausible-gyro-bias") => {
            "The gyroscope reads turns that the camera does not make: its unit, its bias at rest (`dpn check`)"
        }
        Some("no-structure" | "implausible-track-residual") => {
            "Tracks and gyroscope fit no camera that moves: look at the calibration (focal length, mounting, clock) and at the gyroscope's axes and signs"
        }
        _ => {
            "Look at other warnings, at the calibration, and at the accelerometer's axes and signs: one that reads -1 g upwards (iOS) is turned by --accel-scale -1; \
             a camera that keeps its speed, or only turns, shows no scale"
        }
    };
    format!(
        "no pose in {frames} frames: {waited}. {remedy}; `dpn check` says what is wrong with an IMU's log"
    )
}

/// What is known of the camera's clock; `first` is its first frame's stamp.
fn clock_words(clock: &CameraClock, first: Stamp) -> String {
    let off = |seconds: f64| {
        format!("{:.1} ms {}", 1e3 * seconds.abs(), if seconds < 0.0 { "late" } else { "early" })
    };
    let seen = clock.seen_s.zip(clock.std_s);
    match (clock.given, clock.found, seen) {
        (true, _, _) => format!("{}, as given", off(clock.offset_s)),
        (_, Some(t), Some((seen, std))) => format!(
            "{} (+- {:.1}) against the gyroscope, taken off since {:.1} s; `--time-offset {:.4}` takes it off from the start",
            off(seen),
            1e3 * std,
            t.seconds_since(first),
            clock.offset_s
        ),
        (_, _, Some((seen, std))) => {
            format!("{} (+- {:.1}) against the gyroscope, left as it is", off(seen), 1e3 * std)
        }
        _ => "not told: too few turns, or none that the gyroscope shares within 250 ms; `--time-offset` gives it".to_owned(),
    }
}

/// How a rolling shutter was found; `first` is the first frame's stamp.
fn shutter_words(readout: &Readout, first: Stamp) -> String {
    format!(
        "rolling: lines are read out in {:.1} ms (+- {:.1}), taken into account since {:.1} s unless given; `--set front_end.readout_s={:.4}` does from the start",
        1e3 * readout.seconds,
        1e3 * readout.std_s,
        readout.since.seconds_since(first),
        readout.seconds
    )
}

/// From when on the scale was known.
fn scale_words(report: &Report) -> String {
    if report.is_doubted() {
        return "not known: the run is not to be trusted".to_owned();
    }
    let known = report
        .scale_known
        .iter()
        .map(|known| format!("to {:.0} % from {:.1} s", 100.0 * known.within, known.since_s));
    match known.collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => {
            "not known to 10 %: the camera has to speed up and slow down, not only turn".to_owned()
        }
        known => format!("known {known}"),
    }
}

/// What frames waited for, and how many.
fn waiting(waited_for: &BTreeMap<String, usize>) -> String {
    let reasons = waited_for.iter().map(|(reason, frames)| format!("{reason} ({frames} frames)"));
    reasons.collect::<Vec<_>>().join(", ")
}

/// All who look on while images are worked off.
struct Lookers<'a>(Vec<&'a mut dyn FrontEndObserver>);

impl FrontEndObserver for Lookers<'_> {
    fn begin(&mut self, t: Stamp) {
        self.0.iter_mut().for_each(|looker| looker.begin(t));
    }

    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        self.0.iter_mut().for_each(|looker| looker.end(image, fed));
    }
}

/// Refuses results over what is read.
fn apart_from(args: &RunArgs) -> Result<()> {
    let given = [&args.tracks, &args.truth, &args.settings.calib];
    let read: Vec<&Path> = [Path::new(&args.source)]
        .into_iter()
        .chain(given.into_iter().filter_map(|file| file.as_deref()))
        .collect();
    for (flag, file) in [("--mcap", &args.mcap), ("--rerun", &args.rerun)] {
        file.as_deref().map_or(Ok(()), |file| apart::file(flag, file, &read))?;
    }
    let of_run = ["trajectory.tum", "states.csv", "noise_learned.csv", "report.json"];
    let drawn = ["top.*", "timeline.*"];
    for (flag, dir, files) in [("--out", &args.out, &of_run[..]), ("--draw", &args.draw, &drawn)] {
        dir.as_ref().map_or(Ok(()), |dir| apart::folder(flag, dir, files, &read))?;
    }
    Ok(())
}

/// What was typed, as a sequence and its place in its set.
fn open(args: &RunArgs, given: Option<Calibration>) -> Result<(SequenceSet, usize)> {
    let source = RunSource {
        camera: args.camera,
        tracks: args.tracks.clone(),
        truth: args.truth.clone(),
        log: image_log(args),
        simulated_tracks: settings::tracks(&args.settings)?,
        images: settings::images(&args.settings)?,
        flights: settings::flights(&args.settings)?,
        calibration: None,
    };
    Ok(source.with_calibration(given)?.one(&args.source)?)
}

/// What was typed about a log with images.
pub(super) fn image_log(args: &RunArgs) -> ImageLogOptions {
    let log = &args.log;
    ImageLogOptions {
        imu: super::log::options(&log.imu),
        image_topic: log.image_topic.clone(),
        skip_missing: args.skip_missing,
    }
}

fn write(done: &JudgedRun, report: &serde_json::Value, out: &ResultPath) -> Result<()> {
    write_tum(out.join("trajectory.tum"), &done.output.poses())?;
    atomic_write(out.join("states.csv"), |file| write_states(&done.output, &done.noise, file))?;
    if done.report.row.noise.is_learned() {
        write_noise_track(out.join("noise_learned.csv"), &done.noise)?;
    }
    let text = serde_json::to_string_pretty(report)? + "\n";
    write_file(out.join("report.json"), &text)?;
    Ok(())
}

/// The flight from above and over time, beside the frames that were drawn while images were looked at.
fn draw(dir: &ResultPath, album: Album, recording: &Recording, done: &JudgedRun) -> Result<()> {
    album.finish()?;
    save(&top_view(recording, done)?, dir.join("top"))?;
    save(&timeline(recording, done)?, dir.join("timeline"))?;
    Ok(())
}

/// A share in percent; a dash where there is none.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".into(), |share| format!("{:.1}", 100.0 * share))
}

/// The summary for people.
fn words(report: &Report, done: &JudgedRun, simulated: bool) -> String {
    let row = &report.row;
    let mut lines = vec![format!(
        "{}, noise {}, {} frames in {:.1} s",
        row.sequence, row.noise, row.frames, done.output.data_s
    )];
    let mut line = |name: &str, text: String| lines.push(format!("{name:<16}{text}"));
    if simulated {
        let seen = if row.front_end.is_some() { "images rendered" } else { "tracks made" };
        line(
            "camera:",
            format!("simulated: {seen} along the ground truth, so the errors are no real camera's"),
        );
    }
    match row.init_s {
        Some(seconds) => {
            let moving = row.init_in_motion_s.map(|s| format!(", {s:.1} s after the first motion"));
            line("initialised:", format!("first pose after {seconds:.1} s{}", moving.unwrap_or_default()));
            line("scale:", scale_words(report));
        }
        None => {
            line("initialised:", format!("never; waited for: {}", waiting(&report.waited_for)));
        }
    }
    line("camera clock:", clock_words(&report.clock, done.output.frames[0]));
    if let Some(readout) = &report.readout {
        line("shutter:", shutter_words(readout, done.output.frames[0]));
    }
    let without = row.frames - done.output.updates.len();
    let share = row.completion.map_or_else(String::new, |c| match without {
        0 => format!(", {:.1} % since the first pose", 100.0 * c),
        _ => format!(
            ", {:.1} % of those since the first pose that have samples; {without} have none",
            100.0 * c
        ),
    });
    line("poses:", format!("{} of {} frames{share}", row.poses, row.frames));
    line("restarts:", row.restarts.to_string());
    for restart in &row.restart_reasons {
        line("", format!("at {:.1} s: {}", restart.at_s, restart.reason));
    }
    for jump in &report.bias_jumps {
        let [ax, ay, az] = jump.accel;
        let [gx, gy, gz] = jump.gyro;
        let after = jump.between[1].seconds_since(done.output.frames[0]);
        let by = format!("({ax:.2}, {ay:.2}, {az:.2}) m/s^2, ({gx:.3}, {gy:.3}, {gz:.3}) rad/s");
        line("bias jumped:", format!("before {after:.1} s by {by}"));
    }
    if let Some(px) = report.lens_px {
        line("lens:", format!("{px:.2} px off its calibration, rms"));
    }
    if let Some(learned) = &report.learned {
        let three = |[x, y, z]: [f64; 3]| format!("{x:.2} {y:.2} {z:.2}");
        let text = format!(
            "accelerometer {}, gyroscope {}, pixels {:.2} times what was given, at the end",
            three(learned.accel),
            three(learned.gyro),
            learned.pixel
        );
        line("learned:", text);
    }
    if let Some(whitened) = row.whitened {
        line("whitened IMU:", format!("{whitened:.2} (1 where the noise given is the noise there is)"));
    }
    let iterations = row.iterations.map_or_else(|| "-".into(), |i| format!("{i:.1}"));
    line("iterations:", format!("{iterations} a frame, {} outliers in all", row.outliers));
    if let Some(front_end) = &row.front_end {
        line(
            "images:",
            format!(
                "{}, {} passed over; {:.0} tracks a frame, {:.1} frames long, {} % agreed; {:.4} CPU s a second, 95 % within {:.1} ms",
                front_end.images,
                front_end.passed_over,
                front_end.tracks,
                front_end.track_length,
                percent(front_end.inlier_share),
                front_end.cpu_per_data_s,
                front_end.p95_ms
            ),
        );
    }
    let stage = &row.stage_s;
    line(
        "time:",
        format!(
            "{:.4} CPU s a second, 95 % of updates within {:.1} ms (feed {:.2} s, initialise {:.2}, solve {:.2}, reject {:.2}, slide {:.2})",
            row.cpu_per_data_s,
            row.p95_update_ms,
            stage.feed,
            stage.initialise,
            stage.solve,
            stage.reject,
            stage.slide
        ),
    );
    match (row.ate_se3, row.ate_yaw, row.ate_sim3, row.scale_error) {
        (Some(se3), yaw, sim3, scale) => {
            let metres = |v: Option<f64>| Cell::metres(v).shown().to_owned();
            let scale = scale.map_or_else(|| "-".into(), |s| format!("{:+.2} %", 100.0 * s));
            line(
                "ATE [m]:",
                format!(
                    "{} (SE(3)), {} (yaw and position), {} (Sim(3)); scale {scale}",
                    metres(Some(se3)),
                    metres(yaw),
                    metres(sim3)
                ),
            );
        }
        _ => line("ATE [m]:", "none: no ground truth, or too few poses under it".into()),
    }
    if let Some(failure) = row.failure {
        line("failed:", format!("{failure:?}"));
    }
    lines.join("\n") + "\n"
}
