//! Faults as people's recordings have them, injected into recordings that are sound: whatever is wrong, a run is still right or says so.

mod kinds;
mod table;

use dpn_core::estimate::NoiseSpec;
use dpn_core::trajectory::StampedPose;
use dpn_core::{GrayImage, ImuRecording, ImuSample, Stamp, TrackFrame};
use dpn_eval::closed_loop::{
    CameraInput, ImageStream, Recording, Report, RunInfo, SequenceSet, Span, Watchers, paired, watched_run,
};
use dpn_eval::metrics::{AlignmentKind, align, associate_nearest, ate};
use dpn_vio::estimator::Doubt;
use kinds::{Damage, Fault};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// What a run's scale may be off by, against the sound run's.
const SCALE_OFF: f64 = 0.1;
/// An error that grows by more than this factor is harm, beyond what another seed's outliers do.
const ERROR_GROWS: f64 = 2.0;

/// The noise that the odometry is given where nobody says.
fn noise() -> NoiseSpec {
    "self".parse().unwrap()
}

/// What the odometry sees, kept for all faults.
enum Seen {
    Images(Vec<(Stamp, GrayImage)>),
    Tracks(Vec<TrackFrame>),
}

/// A sound recording.
struct Sound {
    recording: Recording,
    seen: Seen,
    info: RunInfo,
    /// Whether the truth is known up to scale.
    to_scale: bool,
}

/// How a run went.
#[derive(Debug, Clone)]
struct Outcome {
    /// Root mean square of the position's error \[m\], and the estimate's scale against the truth's; none without a pose.
    found: Option<(f64, f64)>,
    /// What was said of it, a line each.
    said: Vec<String>,
    /// The same by names: the verdict on the axes, doubts, `camera clock`, `readout`; `input` for what is seen in samples and images alone.
    names: BTreeSet<String>,
    /// Whether it asks not to be trusted, or was refused.
    distrusted: bool,
}

impl Sound {
    /// The part of `source`'s first sequence, in seconds after its first image.
    fn of(source: &SequenceSet, [from_s, to_s]: [f64; 2], to_scale: bool) -> Self {
        let span = Span { from_s, to_s: Some(to_s) };
        let recording = source.recording(0, 0).unwrap();
        let seen = match source.camera_input(0, 0, &span).unwrap() {
            CameraInput::Images(images) => {
                Seen::Images(images.map(|(t, image)| (t, image.unwrap())).collect())
            }
            CameraInput::Tracks(frames, span) => Seen::Tracks(span.of(&frames, |frame| frame.t).to_vec()),
        };
        let info = RunInfo::new(source, &noise(), 0, &span);
        Self { recording, seen, info, to_scale }
    }

    fn name(&self) -> &str {
        &self.recording.name
    }

    /// Whether `fault` can be injected.
    fn takes(&self, fault: &Fault) -> bool {
        !matches!((&fault.damage, &self.seen), (Damage::Image(_), Seen::Tracks(_)))
    }

    /// The run with `fault`, at the default settings.
    fn run(&self, fault: &Fault) -> Outcome {
        let mut recording = self.recording.clone();
        let begin = match &self.seen {
            Seen::Images(images) => images[0].0,
            Seen::Tracks(frames) => frames[0].t,
        };
        match fault.damage {
            Damage::Samples(of) => {
                let samples = recording.imu.samples().iter();
                let mut kept: Vec<ImuSample> =
                    samples.filter_map(|sample| of(*sample, sample.t.seconds_since(begin))).collect();
                // A reader leaves out what is not later than the last.
                let mut last: Option<Stamp> = None;
                kept.retain(|sample| {
                    let later = last.is_none_or(|last| last < sample.t);
                    last = last.max(Some(sample.t));
                    later
                });
                recording.imu = ImuRecording::new(kept).unwrap();
            }
            Damage::Calibration(of) => of(&mut recording),
            Damage::None | Damage::CameraClock(_) | Damage::Image(_) => {}
        }
        let stamped = |t: Stamp| match fault.damage {
            Damage::CameraClock(of) => begin.plus_seconds(of(t.seconds_since(begin))),
            _ => t,
        };
        if let Some(truth) = recording.truth.as_mut().filter(|_| self.to_scale) {
            // Structure from motion has the camera's stamps.
            truth.iter_mut().for_each(|pose| pose.t = stamped(pose.t));
        }
        let camera = match &self.seen {
            Seen::Tracks(frames) => {
                let frames = frames.iter().map(|frame| TrackFrame { t: stamped(frame.t), ..frame.clone() });
                CameraInput::Tracks(frames.collect(), Span::from(0.0))
            }
            Seen::Images(images) => {
                let mut last: Option<&GrayImage> = None;
                let images = images.iter().enumerate().filter_map(move |(k, (t, image))| {
                    let seconds = t.seconds_since(begin);
                    let image = match fault.damage {
                        Damage::Image(of) => of(k, seconds, image, last)?,
                        _ => image.clone(),
                    };
                    // What is repeated is the last sound image.
                    if seconds < kinds::HALF_S {
                        last = Some(&images[k].1);
                    }
                    Some((stamped(*t), Ok(image)))
                });
                let images: ImageStream<'_> = Box::new(images);
                CameraInput::Images(images)
            }
        };
        let watchers = Watchers { images: &mut (), updates: &mut |_, _| ControlFlow::Continue(()) };
        let (config, info) = (Default::default(), self.info.clone());
        let done = watched_run(&config, &recording, camera, &noise(), info, &[], watchers);
        let done = match done {
            Ok(done) => done,
            Err(refused) => {
                let names = BTreeSet::from(["refused".to_owned()]);
                return Outcome { found: None, said: vec![refused.to_string()], names, distrusted: true };
            }
        };
        let poses = done.output.poses();
        let found = recording.truth.as_ref().filter(|_| poses.len() > 30).and_then(|truth| {
            // Structure from motion has few poses, on the camera's clock.
            let late = done.report.clock.offset_s;
            let on_camera_clock = |pose: &StampedPose| StampedPose { t: pose.t.plus_seconds(-late), ..*pose };
            let pairs = if self.to_scale {
                let poses: Vec<_> = poses.iter().map(on_camera_clock).collect();
                associate_nearest(truth, &poses, 0.02).ok()?.pairs
            } else {
                paired(truth, &poses).ok()?
            };
            let kind = if self.to_scale { AlignmentKind::Sim3 } else { AlignmentKind::Se3 };
            let error = ate(&pairs, kind).ok()?.translation.rmse;
            let scale = align(&pairs, AlignmentKind::Sim3).ok()?.scale;
            Some((error, scale))
        });
        let report = &done.report;
        let (said, names) = (report.warnings.clone(), names(report));
        Outcome { found, said, names, distrusted: found.is_none() || report.is_doubted() }
    }
}

/// What is said, by names.
fn names(report: &Report) -> BTreeSet<String> {
    let tag = |value: Value, key: &str| value[key].as_str().unwrap().replace('_', " ");
    let doubted = |doubt: &Doubt| match doubt {
        Doubt::Calibration { suspect } => tag(json!(suspect), "suspect"),
        _ => tag(json!(doubt), "doubt"),
    };
    let mut names: BTreeSet<String> = report.doubts.iter().map(doubted).collect();
    names.extend(report.axes.warning().map(|_| tag(json!(report.axes.verdict), "verdict")));
    names.extend(report.clock.found.map(|_| "camera clock".to_owned()));
    names.extend(report.readout.map(|_| "readout".to_owned()));
    let others = usize::from(report.axes.warning().is_some()) + usize::from(!report.doubts.is_empty());
    if report.warnings.len() > others {
        names.insert("input".to_owned());
    }
    if report.row.poses == 0 {
        names.insert("no pose".to_owned());
    }
    names
}

impl Outcome {
    /// Whether this is worse than the sound run by more than luck.
    fn harmed(&self, sound: &Self) -> bool {
        let Some((sound_error, sound_scale)) = sound.found else { return false };
        self.found.is_none_or(|(error, scale)| {
            error > ERROR_GROWS * sound_error || (scale / sound_scale - 1.0).abs() > SCALE_OFF
        })
    }
}
